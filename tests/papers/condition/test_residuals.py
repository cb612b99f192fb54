"""The residuals at one instant beside rigid-body kinematics written out by hand, and over drives in closed form."""

from math import atan, cos, hypot, tan

import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.core.graph import scan
from tierod.models.single_track import SingleTrack
from tierod.monitors.condition.signals import ConditionSample, Measured
from tierod_lab.papers.condition.rules.filters import AdaptiveSpeed, SteeringSignals
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, Coefficients
from tierod_lab.papers.condition.rules.residual_set import Seen, residual_set

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

KNOWN = Coefficients(1.1, 1.2, 0.13, 0.5, 0.4, 0.1, 0.2, 90.0, 0.6, 10.0, 1e-3, 0.01, 400.0, 50.0, 0.3, 200.0)
BLOCK, PLAIN, PRINTED = residual_set(CAR, KNOWN), residual_set(CAR), residual_set(CAR, printed=True)
NOW = Measured(5.6, 6.3, 0.37, 0.9, 1.7, 210.0, 0.45, 2.1)
SMOOTH = SteeringSignals.Output(0.88, 0.6, -1.5, 0.93, 1.65, 205.0, 2.05)
TURNING = SingleTrack.State(0.06, 0.41)
FORWARD = AdaptiveSpeed.Output(5.9, 0.31, 0.02, 0.25, 0.35)
_, SEEN = BLOCK.of_sensors(Seen(NOW, SMOOTH, 0.93, TURNING, FORWARD))
HALF, BASE, REAR = CAR.track_width / 2.0, CAR.front_distance + CAR.rear_distance, CAR.rear_distance


def kinematic(steer):
    turn = tan(steer) / BASE  # per speed of the rear axle's middle
    centre = hypot(1.0, REAR * turn)
    return atan(REAR * turn), (1.0 - HALF * turn) / centre, (1.0 + HALF * turn) / centre


def rolling():
    left, right, yaw = NOW[:3]
    return 0.5 * (atan(BASE * yaw / (left + HALF * yaw)) + atan(BASE * yaw / (right - HALF * yaw)))


def by_angle():
    return CAR.steering_ratio * (0.9 - 0.01)


def test_the_steering_s_residuals_are_the_model_less_the_reading():
    torque = 1.1 * 0.88 + 1.2 * 0.6 - 0.13 * 1.5 + 0.5 * 0.93 + 0.4 * 2.05 + 0.1
    force = 0.2 * CAR.mass * 2.05 + 90.0 * (1.65 - 0.6 * 0.93) + 10.0
    angle = (rolling() + 1e-3 * 5.95 * 0.37) / CAR.steering_ratio + 0.01
    assert SEEN["r1"] == pytest.approx(0.93 - 0.9)
    assert SEEN["r2"] == pytest.approx(angle - 0.9)
    assert SEEN["r3"] == pytest.approx(torque - 1.65)
    assert SEEN["r19"] == pytest.approx(force - 205.0)


def test_the_motion_s_residuals_are_the_model_less_the_reading():
    speed = 5.95
    front = (0.06 + CAR.front_distance * 0.41 / speed) - by_angle()
    rear = 0.06 - REAR * 0.41 / speed
    force = -CAR.front_cornering_stiffness * front - CAR.rear_cornering_stiffness * rear
    # eq (18): speed times (measured yaw rate plus the single track's rate of sideslip)
    across = speed * (0.37 + force / (CAR.mass * speed) - 0.41)
    assert SEEN["r4"] == pytest.approx(0.41 - 0.37)
    assert SEEN["r5"] == pytest.approx(0.3 - speed * tan(0.06) * 0.37 - 0.45)
    assert SEEN["r6"] == pytest.approx(across - 2.1, rel=1e-6)
    assert SEEN["r15"] == pytest.approx(5.9 - speed)
    assert SEEN["r16"] == pytest.approx(0.31 - 5.9 * tan(0.06) * 0.37 - 0.45)
    assert SEEN["r17"] == pytest.approx(0.06 - kinematic(by_angle())[0])
    assert SEEN["r18"] == pytest.approx(0.06 - kinematic(rolling())[0])


@pytest.mark.parametrize(
    ("steer", "by_mean", "by_forward"),
    [(rolling(), ("r7", "r11"), ("r8", "r12")), (by_angle(), ("r9", "r13"), ("r10", "r14"))],
)
def test_the_wheels_residuals_follow_from_the_kinematics(steer, by_mean, by_forward):
    slip, *shares = kinematic(steer)
    centre = 0.5 * sum(value / share for value, share in zip(NOW[:2], shares, strict=True))
    for name, other, value, share in zip(by_mean, by_forward, NOW[:2], shares, strict=True):
        assert SEEN[name] == pytest.approx(centre * share - value), name
        assert SEEN[other] == pytest.approx(5.9 / cos(slip) * share - value), other


def test_a_steer_beyond_any_road_wheel_is_cut_before_the_pole_of_the_tangent():
    wild = NOW._replace(steering_wheel_angle=1.55 / CAR.steering_ratio + 0.01)
    _, seen = BLOCK.of_sensors(Seen(wild, SMOOTH, 0.93, TURNING, FORWARD))
    assert seen["r17"] == pytest.approx(0.06 - kinematic(1.2)[0])


def column(samples, name):
    return samples[:, ConditionSample._fields.index(name)]


def last(samples, block=PLAIN):
    result = scan(block, samples)
    return {name: result[f"residuals.{name}"][-1] for name in RESIDUALS}


def targeted(**changed):
    samples = circle(seconds=4.0, **changed)
    column(samples, "target_steering_wheel_angle")[:] = column(samples, "steering_wheel_angle")
    return samples


def test_rolling_on_a_circle_with_its_targets_met_leaves_no_residual():
    residuals = last(targeted())
    for name in ("r2", *(f"r{number}" for number in range(7, 16)), "r5a"):
        assert residuals[name] == pytest.approx(0.0, abs=2e-3), name
    # The tyres slip a little in the single track.
    for name, size in {"r5": 0.03, "r16": 0.03, "r1a": 0.02, "r3a": 0.1, "r4a": 0.1, "r7a": 0.05}.items():
        assert residuals[name] == pytest.approx(0.0, abs=size), name


def test_a_lost_wheel_is_seen_by_the_means_of_both_and_by_its_own_filter_alone():
    samples = circle(seconds=8.0)
    column(samples, "wheel_speed_rear_right")[400:] = 0.0
    residuals = last(samples)
    assert residuals["r14"] == pytest.approx(samples[0, 1], abs=0.1)
    assert abs(residuals["r10"]) < 0.1
    assert all(abs(residuals[name]) > 1.0 for name in ("r7", "r9", "r11", "r13", "r12"))


def test_misprints_spoil_both_wheels_by_the_yaw_rate_and_make_an_angle_of_nothing():
    tight = circle(radius=5.0, speed=3.0)
    printed, right = last(tight, PRINTED), last(tight)
    assert abs(right["r7"]) < 2e-3 < 0.3 < abs(printed["r7"])
    assert printed["r9"] == right["r9"]
    assert last(circle(), PRINTED)["r2"] == pytest.approx(-circle()[0, 3], rel=0.01)


def test_standing_and_what_is_missing_say_that_they_are_not_there():
    standing = scan(PLAIN, circle(speed=0.0))
    assert all(standing[f"there.{each.name}"][-1] == 0.0 for each in RESIDUALS.values() if each.moving)
    samples = circle()
    column(samples, "yaw_rate")[300:] = np.nan
    result = scan(PLAIN, samples)
    for each in RESIDUALS.values():
        assert result[f"there.{each.name}"][-1] == (0.0 if "yaw_rate" in each.signals else 1.0), each.name
    assert all(np.isfinite(result[name]).all() for name in result.names if not name.startswith("held"))


def test_a_residual_changes_with_its_signals_and_with_no_others():
    random = np.random.default_rng(2)
    samples = targeted(steering_motor_1_target_torque=3.0, steering_motor_2_target_torque=2.0)
    for side in ("left", "right"):
        column(samples, f"target_drive_torque_{side}")[:] = 20.0
    column(samples, "steering_shaft_torque")[:] = 3.0  # about the torque estimated from the motion of the steering
    samples += 0.01 * random.normal(size=samples.shape)
    base, seen = scan(BLOCK, samples), {name: set() for name in RESIDUALS}
    for place, signal in enumerate(ConditionSample._fields):
        other = samples.copy()
        other[200:, place] += 0.2 * random.normal(size=200)
        result = scan(BLOCK, other)
        for name in RESIDUALS:
            if not np.array_equal(result[f"residuals.{name}"], base[f"residuals.{name}"]):
                seen[name].add(signal)
    assert seen == {name: set(each.signals) for name, each in RESIDUALS.items()}


def test_a_motor_without_torque_is_reported_by_its_own_target():
    samples = targeted()
    split = np.where(np.arange(len(samples)) % 24 < 12, 0.65, 0.35)
    column(samples, "steering_motor_1_target_torque")[:] = 4.0 * split
    column(samples, "steering_motor_2_target_torque")[:] = 4.0 * (1.0 - split)
    column(samples, "steering_shaft_torque")[:] = 4.0 * (1.0 - split) + 0.1
    found = last(samples, residual_set(CAR, Coefficients(torque_offset=0.1)))
    assert (found["motor_1_share"], found["motor_2_share"]) == pytest.approx((1.0, 0.0), abs=0.2)


@pytest.mark.parametrize("speed", [4.0, 9.0])
def test_the_missing_share_of_the_drives_is_what_resistance_slope_and_air_do_not_explain(speed):
    block = residual_set(CAR, Coefficients(inertia=420.0, resistance=60.0, drag=3.0, turning=150.0))
    targets = {"target_drive_torque_left": 70.0, "target_drive_torque_right": 60.0}
    found = last(circle(radius=25.0, speed=speed, seconds=8.0, **targets), block)
    along, across = -((speed / 25.0) ** 2) * REAR, speed * speed / 25.0
    given = 420.0 * along + 60.0 + 3.0 * speed**2 + 150.0 * across * atan(BASE / 25.0)
    share = (130.0 - given * CAR.wheel_radius) * 130.0 / (130.0**2 + 8.0**2)  # drawn to zero by the doubt of 8 N m
    assert found["drive_share"] == pytest.approx(share, rel=1e-3)


def test_angle_rate_and_acceleration_belong_together_and_what_is_missing_is_held():
    time = np.arange(400) * 0.01
    columns = np.stack([2.0 * np.sin(2.0 * time)] * 4, axis=1)
    result, late = scan(SteeringSignals(bandwidth=30.0), columns), slice(100, None)
    np.testing.assert_allclose(np.gradient(result["angle"], 0.01)[late][1:-1], result["rate"][late][1:-1], atol=0.05)
    expected = -8.0 * np.sin(2.0 * (time - 2.0 / 30.0))  # delayed by both poles
    np.testing.assert_allclose(result["acceleration"][late], expected[late], atol=0.5)
    columns[:], columns[200:, 0] = 1.5, np.nan
    assert scan(SteeringSignals(), columns)["angle"][-1] == pytest.approx(1.5, abs=1e-3)
