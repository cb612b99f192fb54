"""r1 to r19 and the driving force at one instant, beside rigid-body kinematics written out by hand."""

from math import atan, cos, hypot, tan

import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.core.graph import scan
from tierod.models.single_track import SingleTrack
from tierod.monitors.condition.signals import ConditionSample, Measured
from tierod_lab.papers.condition.rules.actuator_set import actuator_set
from tierod_lab.papers.condition.rules.adaptive_speed import AdaptiveSpeed
from tierod_lab.papers.condition.rules.all_residuals import AllResiduals
from tierod_lab.papers.condition.rules.equations import Equations
from tierod_lab.papers.condition.rules.parameters import Coefficients
from tierod_lab.papers.condition.rules.rack import StiffRack
from tierod_lab.papers.condition.rules.residual_set import residual_set
from tierod_lab.papers.condition.rules.steering_signals import SteeringSignals

KNOWN = Coefficients(1.1, 1.2, 0.13, 0.5, 0.4, 0.1, 0.2, 90.0, 0.6, 10.0, 1e-3, 0.01)
EQUATIONS = Equations(CAR, KNOWN, moving=1.5, printed=False)
READINGS = dict.fromkeys(Measured._fields, 0.0) | {
    "wheel_speed_rear_left": 5.6,
    "wheel_speed_rear_right": 6.3,
    "yaw_rate": 0.37,
    "steering_wheel_angle": 0.9,
    "steering_shaft_torque": 1.7,
    "tie_rod_force": 210.0,
    "longitudinal_acceleration": 0.45,
    "lateral_acceleration": 2.1,
}
NOW = Measured(**READINGS)
SMOOTH = SteeringSignals.Output(0.88, 0.6, -1.5, 0.93, 1.65, 205.0, 2.05)
TURNING = SingleTrack.State(0.06, 0.41)
FORWARD = AdaptiveSpeed.Output(5.9, 0.31, 0.02, 0.25, 0.35)
EXPECTED = EQUATIONS.expected(NOW, SMOOTH, TURNING, FORWARD, StiffRack.State(0.7, 0.1))
SEEN = EQUATIONS.residuals(NOW, SMOOTH, 0.93, TURNING, FORWARD, EXPECTED)

HALF, BASE, REAR = CAR.track_width / 2.0, CAR.wheelbase, CAR.rear_distance


def kinematic(steer):
    turn = tan(steer) / BASE  # per speed of the rear axle's middle
    centre = hypot(1.0, REAR * turn)
    return atan(REAR * turn), (1.0 - HALF * turn) / centre, (1.0 + HALF * turn) / centre


def rolling():
    left, right, yaw = NOW.wheel_speed_rear_left, NOW.wheel_speed_rear_right, NOW.yaw_rate
    return 0.5 * (atan(BASE * yaw / (left + HALF * yaw)) + atan(BASE * yaw / (right - HALF * yaw)))


def by_angle():
    return CAR.steering_ratio * (NOW.steering_wheel_angle - KNOWN.angle_offset)


def test_the_routes_differ_in_this_sample():
    assert abs(kinematic(rolling())[0] - kinematic(by_angle())[0]) > 0.01


def test_the_steering_s_residuals_are_the_model_less_the_reading():
    torque = 1.1 * 0.88 + 1.2 * 0.6 - 0.13 * 1.5 + 0.5 * 0.93 + 0.4 * 2.05 + 0.1
    force = 0.2 * CAR.mass * 2.05 + 90.0 * (1.65 - 0.6 * 0.93) + 10.0
    angle = (rolling() + 1e-3 * 5.95 * 0.37) / CAR.steering_ratio + 0.01
    assert pytest.approx(0.93 - 0.9) == SEEN.r1
    assert pytest.approx(angle - 0.9) == SEEN.r2
    assert pytest.approx(torque - 1.65) == SEEN.r3
    assert pytest.approx(force - 205.0) == SEEN.r19


def test_the_motion_s_residuals_are_the_model_less_the_reading():
    car = CAR.single_track
    steer, speed = by_angle(), 5.95
    front = (TURNING.sideslip_angle + car.front_distance * TURNING.yaw_rate / speed) - steer
    rear = TURNING.sideslip_angle - car.rear_distance * TURNING.yaw_rate / speed
    force = -car.front_cornering_stiffness * front - car.rear_cornering_stiffness * rear
    # eq (18): speed times (measured yaw rate plus the single track's rate of sideslip)
    across = speed * (NOW.yaw_rate + force / (car.mass * speed) - TURNING.yaw_rate)
    along = 0.5 * (0.25 + 0.35) - speed * tan(0.06) * 0.37
    assert pytest.approx(0.41 - 0.37) == SEEN.r4
    assert pytest.approx(along - 0.45) == SEEN.r5
    assert pytest.approx(across - 2.1, rel=1e-6) == SEEN.r6
    assert pytest.approx(5.9 - 5.95) == SEEN.r15
    assert pytest.approx(0.31 - 5.9 * tan(0.06) * 0.37 - 0.45) == SEEN.r16


def test_the_sideslip_of_each_route_is_its_own():
    assert pytest.approx(0.06 - kinematic(by_angle())[0]) == SEEN.r17
    assert pytest.approx(0.06 - kinematic(rolling())[0]) == SEEN.r18


@pytest.mark.parametrize(
    ("steer", "by_mean", "by_forward"),
    [(rolling(), ("r7", "r11"), ("r8", "r12")), (by_angle(), ("r9", "r13"), ("r10", "r14"))],
)
def test_the_wheels_residuals_follow_from_the_kinematics(steer, by_mean, by_forward):
    slip, *shares = kinematic(steer)
    read = NOW.wheel_speed_rear_left, NOW.wheel_speed_rear_right
    centre = 0.5 * sum(value / share for value, share in zip(read, shares, strict=True))
    for name, other, value, share in zip(by_mean, by_forward, read, shares, strict=True):
        assert getattr(SEEN, name) == pytest.approx(centre * share - value), name
        assert getattr(SEEN, other) == pytest.approx(5.9 / cos(slip) * share - value), other


def test_a_steer_beyond_any_road_wheel_is_cut_before_the_pole_of_the_tangent():
    wild = NOW._replace(steering_wheel_angle=1.55 / CAR.steering_ratio + KNOWN.angle_offset)
    seen = EQUATIONS.residuals(wild, SMOOTH, 0.93, TURNING, FORWARD, EXPECTED)
    assert seen.r17 == pytest.approx(0.06 - kinematic(1.2)[0])


def test_the_speed_of_one_wheel_alone_is_moved_to_the_middle_by_half_the_track():
    samples = circle(radius=8.0, speed=6.0)
    of_speed = samples[:, [ConditionSample._fields.index(name) for name in (
        "longitudinal_acceleration", "yaw_rate", "yaw_rate", "wheel_speed_rear_left", "wheel_speed_rear_right"
    )]]  # fmt: skip
    of_speed[:, 2] = atan(REAR / 8.0)
    of_speed[400:480, 4] = np.nan
    found = scan(AdaptiveSpeed.design(CAR.track_width, 0.01), of_speed)["forward_speed"]
    assert found[399] == pytest.approx(6.0, abs=0.01)
    assert found[479] == pytest.approx(6.0, abs=0.01)


@pytest.mark.parametrize("speed", [4.0, 9.0])
def test_the_missing_share_of_the_drives_is_what_resistance_slope_and_air_do_not_explain(speed):
    known = Coefficients(inertia=420.0, resistance=60.0, drag=3.0, turning=150.0)
    block = AllResiduals(residual_set(CAR, known), actuator_set(CAR, known))
    samples = circle(
        radius=25.0, speed=speed, seconds=8.0, target_drive_torque_left=70.0, target_drive_torque_right=60.0
    )
    found = scan(block, samples)
    mean, steer = speed, atan(BASE / 25.0)
    along, across = -((speed / 25.0) ** 2) * REAR, speed * speed / 25.0
    given = 420.0 * along + 60.0 + 3.0 * mean**2 + 150.0 * across * steer
    asked = 130.0
    share = (asked - given * CAR.wheel_radius) * asked / (asked**2 + 8.0**2)  # drawn to zero by the doubt of 8 N m
    assert found["residuals.drive_share"][-1] == pytest.approx(share, rel=1e-3)
