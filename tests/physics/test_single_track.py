import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import single_track
from tierod.physics.tyre import linear_lateral_force

MASS, FRONT, REAR, FRONT_STIFFNESS, REAR_STIFFNESS = 1600.0, 1.14, 1.69, 110e3, 130e3
GRADIENT = single_track.understeer_gradient(MASS, FRONT, REAR, FRONT_STIFFNESS, REAR_STIFFNESS)


@given(st.floats(2.0, 60.0), st.floats(-0.02, 0.02))
def test_steady_turn_balances_forces_and_moments(speed, curvature):
    steer = single_track.steady_road_wheel_angle(curvature, speed, FRONT + REAR, GRADIENT)
    yaw_rate = speed * curvature
    rear_force = MASS * speed * yaw_rate * FRONT / (FRONT + REAR)
    lateral_speed = REAR * yaw_rate - speed * rear_force / REAR_STIFFNESS
    front_slip = single_track.front_slip_speed(lateral_speed, yaw_rate, speed, steer, FRONT) / speed
    rear_slip = single_track.rear_slip_speed(lateral_speed, yaw_rate, REAR) / speed
    front = linear_lateral_force(front_slip, FRONT_STIFFNESS)
    rear = linear_lateral_force(rear_slip, REAR_STIFFNESS)
    assert single_track.yaw_acceleration(front, rear, 2800.0, FRONT, REAR) == pytest.approx(0.0, abs=1e-6)
    assert single_track.lateral_acceleration(front, rear, MASS) == pytest.approx(speed * yaw_rate, abs=1e-6)
    gain = single_track.steady_yaw_gain(speed, FRONT + REAR, GRADIENT)
    assert gain * steer == pytest.approx(yaw_rate, abs=1e-9)


def test_neutral_car_has_no_gradient_and_this_one_understeers():
    assert single_track.understeer_gradient(MASS, 1.4, 1.4, 1e5, 1e5) == 0.0
    assert GRADIENT > 0.0


def test_axle_loads_add_up_to_the_weight():
    front = single_track.front_axle_load(MASS, FRONT, REAR)
    rear = single_track.front_axle_load(MASS, REAR, FRONT)
    assert front + rear == pytest.approx(MASS * 9.81)
    assert front > rear


def test_lever_arm_of_an_accelerometer():
    assert single_track.lateral_acceleration_at(2.0, 0.5, 0.3, 1.0) == pytest.approx(2.5)
    assert single_track.lateral_acceleration_at(2.0, 0.0, 0.3, 0.0, 1.0) == pytest.approx(2.0 - 0.09)
