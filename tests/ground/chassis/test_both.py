"""What both chassis promise."""

import math
from dataclasses import replace

import numpy as np
import pytest

from chassis_replay import understeer_error, unresisted, yaw_gain_error
from ground.chassis.bench import Bench, Inputs, columns, drive, finite, surroundings
from tierod.core.block import leaves
from tierod.core.graph import scan
from tierod_lab.ground.chassis import SingleTrack, TwoTrack, demonstrator

G = 9.81
BODIES = [SingleTrack(), TwoTrack(), demonstrator()]


@pytest.fixture(params=BODIES, ids=["single", "two", "demonstrator"])
def body(request):
    return request.param


@pytest.mark.parametrize("speed", [8.0, 20.0, 35.0])
def test_steady_yaw_gain_is_the_closed_form(body, speed):
    assert abs(yaw_gain_error(unresisted(body), speed)) < 0.01


@pytest.mark.parametrize("body", BODIES[:2], ids=["single", "two"])
def test_understeer_gradient_is_the_closed_form(body):
    assert abs(understeer_error(unresisted(body))) < 0.01


def test_left_turn_is_positive_everywhere(body):
    out = drive(body, 4.0, 15.0, steer=0.03, drive_left=40.0, drive_right=40.0).at(-1).reaction
    for name in ("yaw_rate", "lateral_acceleration", "front_lateral_force", "rear_lateral_force", "front_slip_angle"):
        assert getattr(out, name) > 0.0, name
    assert out.self_aligning_torque > 0.0
    assert out.kingpin_left > 0.0
    assert out.kingpin_right > 0.0
    assert out.wheel_speeds.front_right > out.wheel_speeds.front_left
    assert out.wheel_speeds.rear_right > out.wheel_speeds.rear_left


def test_right_turn_mirrors_the_left_one(body):
    left, right = (drive(body, 3.0, 15.0, steer=angle).at(-1).reaction for angle in (0.04, -0.04))
    assert right.yaw_rate == pytest.approx(-left.yaw_rate, rel=1e-9)
    assert right.kingpin_left == pytest.approx(-left.kingpin_right, rel=1e-9)
    assert right.loads.front_left == pytest.approx(left.loads.front_right, rel=1e-9)


def test_lateral_acceleration_of_a_steady_turn_is_speed_times_yaw_rate(body):
    out = drive(unresisted(body), 6.0, 15.0, steer=0.01).at(-1).reaction
    assert out.lateral_acceleration == pytest.approx(out.speed * out.yaw_rate, rel=1e-3)


def test_rolls_from_twenty_metres_a_second_to_rest_and_stays(body):
    out = drive(body, 240.0, 20.0)
    speed = out["reaction.speed"]
    assert finite(out)
    assert np.all(np.diff(speed)[speed[1:] > 0.05] < 0.0)
    assert speed.min() > -0.01
    assert abs(speed[-1]) < 1e-6


def test_held_by_its_brakes_on_a_slope_and_a_bank(body):
    out = drive(body, 20.0, 3.0, brake=500.0, bank=0.08, grade=0.12)
    late = slice(10_000, None)
    assert finite(out)
    for name in ("reaction.speed", "reaction.lateral_speed", "reaction.yaw_rate"):
        assert abs(np.sum(out[name][late]) * 1e-3) < 1e-3, name
    end = out.at(-1).reaction
    assert end.longitudinal_acceleration == pytest.approx(G * math.sin(0.12), rel=1e-3)
    assert end.lateral_acceleration == pytest.approx(G * math.sin(0.08), rel=1e-3)


def test_rolling_resistance_holds_on_less_than_its_own_slope(body):
    resting = drive(body, 20.0, 0.0, grade=0.006)
    assert abs(resting.at(-1).reaction.speed) < 1e-4
    rolling = drive(body, 4.0, 0.0, grade=0.05)
    gained = -np.diff(rolling["reaction.speed"])[-1000:].mean() / 1e-3
    coefficient = body.rolling_coefficient if isinstance(body, SingleTrack) else body.front.tyre.rolling_coefficient
    assert gained == pytest.approx(G * (math.sin(0.05) - coefficient), rel=0.1)


def test_driven_up_and_braked_hard_it_never_rolls_back(body):
    braking = {"brake": lambda t: np.where(t > 3.0, 2000.0, 0.0)}
    for adhesion in (0.3, 1.0):
        out = drive(
            body, 25.0, 1.0, drive_left=lambda t: 150.0 * (t < 3.0), drive_right=lambda t: 150.0 * (t < 3.0),
            adhesion_left=adhesion, adhesion_right=adhesion, **braking,
        )  # fmt: skip
        assert finite(out)
        for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
            assert out[f"reaction.wheel_speeds.{wheel}"].min() > -1e-6
        assert abs(out.at(-1).reaction.speed) < 1e-3


def test_on_a_hoist_nothing_acts(body):
    steer = lambda t: 0.5 * np.sin(3.0 * t)  # noqa: E731
    out = drive(body, 4.0, 0.0, steer=steer, support=0.0, bank=0.05, grade=0.05, crosswind=15.0)
    assert finite(out)
    for name in out.names:
        if any(part in name for part in ("kingpin", "force", "loads", "torque", "acceleration", "reaction.yaw_rate")):
            assert not np.any(out[name]), name


def test_lowered_from_a_hoist_it_stands(body):
    steer = lambda t: 0.5 * np.sin(3.0 * t)  # noqa: E731
    out = drive(body, 8.0, 0.0, steer=steer, support=lambda t: np.clip(t - 3.0, 0.0, 1.0), brake=200.0)
    assert finite(out)
    assert out.at(-1).reaction.loads.front_left > 0.0


def test_wheels_turned_in_the_air_come_down_without_scrub(body):
    support = lambda t: np.interp(t, [2.0, 2.5, 4.5, 5.0], [1.0, 0.0, 0.0, 1.0])  # noqa: E731
    steer = lambda t: np.interp(t, [0.0, 1.0, 3.0, 4.0], [0.0, 0.3, 0.3, -0.3])  # noqa: E731
    out = drive(body, 6.0, 0.0, steer=steer, support=support, brake=500.0)
    scrub = out["reaction.scrub_torque"]
    assert abs(scrub[1500]) > 20.0
    assert abs(scrub[-1]) < 0.02 * abs(scrub[1500])


def test_wheels_turned_at_rest_scrub_and_a_little_rolling_frees_them(body):
    turned = drive(body, 4.0, 0.0, steer=lambda t: 0.3 * np.minimum(t, 1.0), brake=500.0)
    held = turned.at(-1).reaction
    greatest = np.max(np.abs(turned["reaction.scrub_torque"]))
    assert held.scrub_torque == pytest.approx(greatest, rel=0.02)
    state, around = turned.state, {"steer": 0.3, "drive_left": 60.0, "drive_right": 60.0}
    rolled = scan(Bench(body, 0.0), columns(2.0, **around), state)
    assert np.sum(rolled["reaction.speed"]) * 1e-3 > 0.2
    assert abs(rolled.at(-1).reaction.scrub_torque) < 0.2 * greatest


def test_crosswind_pushes_and_turns_a_standing_start(body):
    steer, road, wind = surroundings(Inputs(crosswind=10.0))
    at = body.reaction(body.init(30.0), steer, road, wind)
    force = body.side_area * 0.6 * math.hypot(30.0, 10.0) * 10.0
    mass = body.mass
    assert at.lateral_acceleration == pytest.approx(force / mass)
    assert at.yaw_acceleration == pytest.approx(force * body.side_force_lead / body.yaw_inertia)


def test_driven_straight_in_crosswind_the_tyres_balance_the_air(body):
    angle = 0.0
    for _ in range(12):
        out = drive(unresisted_with_air(body), 4.0, 25.0, steer=angle, crosswind=8.0).at(-1).reaction
        angle -= 0.5 * body.wheelbase * out.yaw_rate / out.speed
    air = body.side_area * 0.6 * math.hypot(25.0, 8.0) * 8.0
    assert abs(out.yaw_rate) < 1e-3
    assert angle < 0.0
    assert out.front_lateral_force + out.rear_lateral_force == pytest.approx(-air, rel=0.05)


def unresisted_with_air(body):
    return replace(unresisted(body), side_area=body.side_area)


def test_straight_on_a_bank_the_tyres_carry_the_slope(body):
    still, bank = unresisted(body), 0.05
    steer = still.understeer_gradient * G * math.sin(bank)
    out = drive(still, 8.0, 20.0, steer=steer, bank=bank).at(-1).reaction
    assert out.lateral_acceleration == pytest.approx(G * math.sin(bank), rel=0.01)
    assert abs(out.yaw_rate) < 0.02 * G * math.sin(bank) / 20.0


def test_a_step_of_a_millisecond_is_short_enough(body):
    given = {"steer": lambda t: 0.05 * np.sin(4.0 * t), "drive_left": 60.0, "drive_right": 60.0}
    for speed in (3.0, 20.0, 50.0):
        inputs = columns(3.0, **given)
        coarse = scan(Bench(body, speed), inputs)
        fine = scan(Bench(body, speed, 0.25e-3), np.repeat(inputs, 4, axis=0))
        for name in ("yaw_rate", "lateral_acceleration", "kingpin_left", "wheel_speeds.front_left"):
            reference = fine[f"reaction.{name}"][::4]
            error = coarse[f"reaction.{name}"] - reference
            assert np.max(np.abs(error)) < 5e-3 * np.max(np.abs(reference)), (speed, name)


def test_floats_and_kernel_agree(body):
    bench = Bench(body, 12.0)
    inputs = columns(0.02, steer=0.03, brake=100.0, bank=0.02, crosswind=3.0)
    state = bench.init()
    for row in inputs:
        state, out = bench.step(state, Inputs(*row.tolist()))
    compiled = scan(bench, inputs).at(-1)
    slow, fast = (np.array([value for _, value in leaves(tree)], dtype=float) for tree in (out, compiled))
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-9)


def test_backwards_it_rolls_as_well(body):
    out = drive(body, 5.0, 0.0, steer=0.2, drive_left=-60.0, drive_right=-60.0)
    end = out.at(-1).reaction
    assert finite(out)
    assert end.speed < -0.5
    assert end.yaw_rate < 0.0


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
