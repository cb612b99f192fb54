"""The study of two real cars: what it says without the recordings, and the simple estimates on made ones."""

import math

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.vehicles import load
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.sideslip import car_park, race_laps, real_cars, rivals
from tierod_lab.papers.sideslip.real_recordings import recorded
from tierod_lab.studies.effort import Effort

TIME = np.arange(2000) / 100.0


def recording(**values):
    return Recording(
        {name: Channel(name, TIME, np.broadcast_to(value, TIME.shape), "") for name, value in values.items()}
    )


def test_without_recordings_it_says_so_and_measures_nothing(monkeypatch, tmp_path):
    monkeypatch.setenv("TIEROD_DATA", str(tmp_path))
    claims = [item for item in real_cars.items(Effort()) if isinstance(item, Claim)]
    assert {claim.note for claim in claims} == {NO_DATA}
    assert all(claim.measured is None for claim in claims)


def test_the_claims_on_the_car_park_hold(monkeypatch):
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("revsted_slip_angle").parent))
    items = list(car_park.items(recorded(car_park.FILE, car_park.VEHICLE)))
    claims = {item.id: item for item in items if isinstance(item, Claim)}
    assert claims["cars.passenger-car-rms"].unit == "deg"
    for claim in claims.values():
        assert claim.goal is None or claim.goal.holds(claim.measured)
    assert claims["cars.passenger-car-any-noises"].measured >= claims["cars.passenger-car-rms"].measured
    (table,) = (item for item in items if isinstance(item, Table))
    assert car_park.COMBINED in [row[0] for row in table.rows]


def test_noises_that_are_tried_are_those_of_the_other_car_and_about_them():
    car, laps = load("revsted-car"), load("ferrari-250lm")
    tried = car_park.settings(car)
    assert len(tried) == 3 ** len(car_park.TRIED)
    assert {each["yaw_rate_noise"] for each in tried} == {laps["yaw_rate_noise"]}
    assert {each["yaw_rate_drift"] / laps["yaw_rate_drift"] for each in tried} == {0.5, 1.0, 2.0}
    assert {each["rear_distance"] for each in tried} == {car["rear_distance"]}


@pytest.mark.slow
def test_the_claims_on_the_race_laps_hold(monkeypatch):
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("ferrari_250lm_race").parent))
    items = list(race_laps.items(recorded(race_laps.FILE, race_laps.VEHICLE), Effort()))
    claims = [item for item in items if isinstance(item, Claim)]
    assert {claim.id for claim in claims} >= {"cars.race-laps-mean", "cars.race-laps-rms", "cars.stiffness-wrong"}
    assert all(claim.goal.holds(claim.measured) for claim in claims)


def test_the_leaky_integral_follows_its_equation():
    block = rivals.LeakyKinematic(0.01, 1.5)
    out = scan(block, np.tile([20.0, 0.1, 3.0], (3000, 1))).values[:, 0]
    assert out[-1] == pytest.approx((3.0 - 2.0) * 1.5 / 20.0, rel=1e-6)  # v' = 0 where a - r V = v / leak
    reached = np.flatnonzero(out > out[-1] * (1.0 - math.exp(-1.0)))[0] * 0.01
    assert reached == pytest.approx(1.5, abs=0.03)


def test_geometry_finds_the_distance_that_made_the_truth():
    rate, speed = 0.3 * np.sin(TIME), 5.0
    made = recording(
        yaw_rate=rate,
        vehicle_speed=speed,
        wheel_speed_rear_right=speed + 0.7 * rate,
        wheel_speed_rear_left=speed - 0.7 * rate,
        sideslip_angle=1.2 * rate / speed,
    )
    seen = rivals.geometric(made, 10.0)
    np.testing.assert_allclose(seen.estimate, seen.truth, atol=1e-12)
    fused = car_park.with_rear_wheels(made, 10.0)
    np.testing.assert_allclose(fused["yaw_rate"].values, rate, atol=1e-12)


def test_a_linear_car_is_found_by_the_linear_filter():
    car = load("ferrari-250lm")
    steer = 0.02 * np.sin(2.0 * TIME)
    stiffness = {"front": 7e4, "rear": 1.1e5}
    tuned = rivals.LINEAR_START | stiffness
    block = rivals.linear_filter(car, tuned)
    quiet = np.column_stack([steer, np.full(len(TIME), 25.0), np.full((len(TIME), 2), np.nan)])
    out = scan(block, quiet)
    made = recording(
        road_wheel_angle=steer,
        vehicle_speed=25.0,
        yaw_rate=out["mean.yaw_rate"],
        lateral_acceleration=np.gradient(out["mean.sideslip_angle"], 0.01) * 25.0 + 25.0 * out["mean.yaw_rate"],
        sideslip_angle=out["mean.sideslip_angle"],
    )
    found = rivals.linear(made, car, 10.0)
    spread = float(np.std(found.truth))
    assert found.figures(10.0).rms < 0.05 * spread
