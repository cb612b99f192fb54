"""The regressors of the default estimator against torques worked out by hand."""

import math

import pytest

from models.friction_paper import CAR
from tierod.monitors.friction.estimator import (
    BuildUp,
    Coefficients,
    ColumnMotion,
    column_motion,
    regressors,
    road_torques,
)
from tierod.monitors.friction.signals import ConditionedSteering, SteeringSample

RATIO, LOAD = CAR.steering_ratio, CAR.mass * 9.81 * CAR.rear_distance / (CAR.front_distance + CAR.rear_distance)


def clean(angle=0.0, rate=0.0, speed=10.0, yaw_rate=0.0, lateral=0.0, vehicle_acceleration=0.0):
    signals = SteeringSample(angle, rate, 1.0, 0.1, yaw_rate, lateral, speed)
    return ConditionedSteering(signals, 0.0, 0.0, 0.0, vehicle_acceleration, 0.0, 0.0, 1.0, 1.0)


def road(**motion):
    given = clean(**motion)
    return road_torques(given, column_motion(given, math.inf, 0.01), CAR)


def test_weight_turns_back_by_the_sine_of_the_steer():
    for angle in (-6.0, 0.5, 6.0):
        assert road(angle=angle).weight == pytest.approx(RATIO * LOAD * math.sin(RATIO * angle))


@pytest.mark.parametrize(("acceleration", "angle", "sign"), [(2.0, 4.0, -1.0), (-2.0, 4.0, 1.0), (2.0, -4.0, 1.0)])
def test_drive_force_takes_from_the_aligning_torque_and_brakes_add_to_it(acceleration, angle, sign):
    found = road(vehicle_acceleration=acceleration, angle=angle).drive
    expected = RATIO * CAR.trail * CAR.mass * 2.0 * math.sin(RATIO * 4.0)
    assert found == pytest.approx(sign * expected)


def test_the_column_lags_the_wheel_by_the_twist():
    signals = SteeringSample(0.3, 0.2, 7.0, 0.1, 0.0, 0.0, 10.0)
    given = ConditionedSteering(signals, 2e-3, 1.0, 0.0, 0.0, 14.0, 140.0, 1.0, 1.0)
    assert column_motion(given, math.inf, 0.01) == ColumnMotion(0.3, 2e-3, 0.2, 1.0)
    assert column_motion(given, 140.0, 0.01) == pytest.approx((0.25, 1e-3, 0.1, 0.0))


@pytest.mark.parametrize("gains", [(2.0, 0.0, 0.0), (1.5, 0.3, 0.0), (1.5, 0.3, 0.7)])
def test_friction_grows_with_the_load_of_aligning_torque_weight_and_turn_slip_together(gains):
    """Weight and aligning torque both turn back in a curve, so that they press on the gear with their sum."""
    aligning_gain, lever, slip = gains
    given = clean(angle=3.0, yaw_rate=0.3, speed=10.0, lateral=3.0)
    known = Coefficients(*(0.0,) * len(Coefficients._fields))._replace(
        aligning_gain=aligning_gain, weight_lever=lever, turn_slip=slip
    )
    law = BuildUp(*(0.8,) * len(BuildUp._fields))
    column = column_motion(given, math.inf, 0.01)
    found = regressors(given, column, (law, law, law), known, CAR, 4.0)
    acting = road(angle=3.0, yaw_rate=0.3, speed=10.0, lateral=3.0)
    load = aligning_gain * acting.aligning + lever * acting.weight + slip * acting.turn_slip
    assert min(abs(lever * acting.weight), abs(acting.aligning)) > 0.05 or lever == 0.0
    assert found.loaded_friction == pytest.approx(0.8 * (abs(load) - 4.0))
