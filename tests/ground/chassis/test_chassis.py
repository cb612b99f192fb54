"""What both chassis promise, and each alone."""

import numpy as np
import pytest

from chassis_replay import energy_error, unresisted, yaw_gain_error
from ground.rigs import Bench, columns, drive, finite
from tierod.core.graph import scan
from tierod_lab.ground.chassis import SingleTrack, TwoTrack, demonstrator
from tierod_lab.ground.chassis.tyres import air_forces

G = 9.81
BODIES = [SingleTrack(), TwoTrack(), demonstrator()]


@pytest.fixture(params=BODIES, ids=["single", "two", "demonstrator"])
def body(request):
    return request.param


@pytest.mark.parametrize("speed", [8.0, 20.0, 35.0])
def test_steady_yaw_gain_is_the_closed_form(body, speed):
    assert abs(yaw_gain_error(unresisted(body), speed)) < 0.01


def test_rolls_from_twenty_metres_a_second_to_rest_and_stays(body):
    out = drive(body, 240.0, 20.0)
    speed = out["reaction.speed"]
    assert finite(out)
    assert np.all(np.diff(speed)[speed[1:] > 0.05] < 0.0)
    assert speed.min() > -0.01
    assert abs(speed[-1]) < 1e-6


def test_on_a_hoist_nothing_acts(body):
    steer = lambda t: 0.5 * np.sin(3.0 * t)  # noqa: E731
    out = drive(body, 4.0, 0.0, steer=steer, support=0.0, bank=0.05, grade=0.05, crosswind=15.0)
    assert finite(out)
    for name in out.names:
        if any(part in name for part in ("kingpin", "force", "loads", "torque", "acceleration", "reaction.yaw_rate")):
            assert not np.any(out[name]), name


def test_wheels_turned_at_rest_scrub_and_a_little_rolling_frees_them(body):
    turned = drive(body, 4.0, 0.0, steer=lambda t: 0.3 * np.minimum(t, 1.0), brake=500.0)
    held = turned.at(-1).reaction
    greatest = np.max(np.abs(turned["reaction.scrub_torque"]))
    assert held.scrub_torque == pytest.approx(greatest, rel=0.02)
    state, around = turned.state, {"steer": 0.3, "drive_left": 60.0, "drive_right": 60.0}
    rolled = scan(Bench(body, 0.0), columns(2.0, **around), state)
    assert np.sum(rolled["reaction.speed"]) * 1e-3 > 0.2
    assert abs(rolled.at(-1).reaction.scrub_torque) < 0.2 * greatest


@pytest.mark.parametrize("seed", range(4))
def test_whatever_is_done_to_it_it_stays_finite(body, seed):
    random = np.random.default_rng(seed)
    count = 10_000

    def held(milliseconds):
        return np.repeat(random.normal(size=count // milliseconds + 1), milliseconds)[:count]

    steer = np.clip(0.3 * np.convolve(held(300), np.ones(150) / 150.0, "same"), -0.7, 0.7)
    inputs = columns(
        10.0,
        steer=steer,
        drive_left=600.0 * held(700),
        drive_right=600.0 * held(700),
        brake=np.maximum(1500.0 * held(900), 0.0),
        bank=0.05 * held(3000),
        grade=0.05 * held(3000),
        adhesion_left=np.clip(0.6 + 0.4 * held(2000), 0.0, 1.2),
        adhesion_right=np.clip(0.6 + 0.4 * held(2000), 0.0, 1.2),
        support=np.clip(1.5 + held(2000), 0.0, 1.0),
        crosswind=10.0 * held(1500),
    )
    out = scan(Bench(body, 60.0 * random.random()), inputs)
    assert finite(out)
    assert np.max(np.abs(out["reaction.yaw_rate"])) < 20.0


CAR = TwoTrack()


def test_energy_goes_where_it_is_accounted_for():
    assert energy_error(TwoTrack()) < 1e-3
    assert energy_error(demonstrator()) < 1e-3


def test_loads_of_a_steady_turn_balance_weight_and_moments():
    out = drive(unresisted(CAR), 8.0, 20.0, steer=0.02).at(-1).reaction
    loads = out.loads
    assert sum(loads) == pytest.approx(CAR.mass * G, rel=1e-9)
    moved = [0.5 * (right - left) * axle.track for left, right, axle in (
        (loads.front_left, loads.front_right, CAR.front), (loads.rear_left, loads.rear_right, CAR.rear)
    )]  # fmt: skip
    overturning = CAR.mass * (out.lateral_acceleration * CAR.centre_height + G * CAR.roll_arm * out.roll_angle)
    assert sum(moved) == pytest.approx(overturning, rel=2e-3)
    assert moved[0] > moved[1]


def test_brakes_on_split_ground_pull_to_the_side_that_grips():
    out = drive(CAR, 0.5, 25.0, brake=500.0, adhesion_left=1.0, adhesion_right=0.2).at(-1).reaction
    assert out.yaw_rate > 0.02


AREAS = (0.65, 5.0, 0.4)


def test_wind_to_the_left_pushes_left_and_turns_the_nose_with_it():
    forces = air_forces(30.0, -10.0, *AREAS)
    assert forces.lateral == pytest.approx(5.0 * 0.6 * 1000.0**0.5 * 10.0)
    assert forces.yaw_moment == pytest.approx(0.4 * forces.lateral)


def turned(about, angle):
    """Rotation matrices about the x or the z axis, shape (n, 3, 3)."""
    cosine, sine, zero, one = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    x = [[one, zero, zero], [zero, cosine, -sine], [zero, sine, cosine]]
    z = [[cosine, -sine, zero], [sine, cosine, zero], [zero, zero, one]]
    return np.moveaxis(np.array(x if about == "x" else z), -1, 0)
