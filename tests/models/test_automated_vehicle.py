"""The small automated car: steady turns, column and torques against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.core.block import skeleton
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.physics.single_track import steady_yaw_gain, understeer_gradient
from tierod.vehicles import load

CAR = load("smartload").parameters_for(AutomatedVehicle.Parameters)
PLAIN = replace(CAR, turn_slip_stiffness=0.0, jacking_torque=0.0, rolling_resistance=0.0, drag=0.0)
REST = skeleton(AutomatedVehicle.State)
NOTHING = skeleton(AutomatedVehicle.Input)


def held(state, inputs, car, steps, **fixed):
    for _ in range(steps):
        state = AutomatedVehicle.transition(state, inputs, car)._replace(**fixed)
    return state


@pytest.mark.parametrize("speed", [2.0, 6.0, 12.0])
def test_a_gentle_steady_turn_is_that_of_the_single_track(speed):
    car = replace(PLAIN, tyre_friction=50.0)
    wheels = 0.01
    still = {"speed": speed, "column_angle": wheels / car.steering_ratio, "column_rate": 0.0}
    state = held(REST._replace(**still), NOTHING, car, 2000, **still)
    front, rear = car.front_distance - car.pneumatic_trail, car.rear_distance + car.pneumatic_trail
    gradient = understeer_gradient(car.mass, front, rear, car.front_cornering_stiffness, car.rear_cornering_stiffness)
    expected = steady_yaw_gain(speed, front + rear, gradient) * wheels
    assert state.yaw_rate == pytest.approx(expected, rel=2e-3)
    output = AutomatedVehicle.output(state, NOTHING, replace(car, roll_share=0.0))
    assert output.lateral_acceleration == pytest.approx(speed * state.yaw_rate, rel=2e-3)
    turned = car.track_width * state.yaw_rate
    assert output.wheel_speed_rear_right - output.wheel_speed_rear_left == pytest.approx(turned, rel=1e-9)
    force = car.rear_distance / (car.front_distance + car.rear_distance) * car.mass * speed * state.yaw_rate
    rod = car.steering_ratio / car.rack_ratio * (car.mechanical_trail + car.pneumatic_trail) * force
    assert output.tie_rod_force == pytest.approx(rod, rel=0.03)


@pytest.mark.parametrize(("learnt", "known"), [(0.02, 0.0), (0.0, 0.02), (0.03, -0.01)])
def test_tyres_of_different_size_make_wheel_speeds_differ_by_that_share(learnt, known):
    car = replace(PLAIN, wheel_speed_difference=known, wheel_speed_scale=1.05)
    straight = REST._replace(speed=10.0, wheel_speed_difference=learnt)
    output = AutomatedVehicle.output(straight, NOTHING, car)
    assert output.wheel_speed_rear_right == pytest.approx(10.0 * 1.05 * 1.01, rel=1e-12)
    assert output.wheel_speed_rear_left == pytest.approx(10.0 * 1.05 * 0.99, rel=1e-12)
    larger = AutomatedVehicle.output(straight._replace(wheel_speed_scale=0.04), NOTHING, car)
    assert larger.wheel_speed_rear_left == pytest.approx(1.04 * output.wheel_speed_rear_left, rel=1e-12)


def test_the_column_follows_a_torque_exactly():
    car = replace(PLAIN, rack_stiffness=0.0, nominal_friction=1e-12)
    torque, damping = 2.0, car.rack_ratio**2 * car.rack_damping
    inputs = NOTHING._replace(steering_motor_1=torque, steering_motor_1_now=torque)
    state = held(REST, inputs, car, 10, front_slip=0.0, yaw_rate=0.0, lateral_speed=0.0)
    time, slow = 10 * car.sample_time, car.column_inertia / damping
    rate = torque / damping * (1.0 - np.exp(-time / slow))
    assert state.column_rate == pytest.approx(rate, rel=1e-9)
    assert state.column_angle == pytest.approx(torque / damping * time - slow * rate, rel=1e-9)


def test_friction_holds_the_column_against_a_small_torque():
    inputs = NOTHING._replace(steering_motor_1=0.5, steering_motor_1_now=0.5)
    state = held(REST, inputs, CAR, 500)
    assert abs(state.column_angle) < CAR.column_friction_angle
    assert state.friction_share * CAR.nominal_friction == pytest.approx(0.5, rel=0.05)


def test_at_standstill_nothing_stirs_and_nothing_rings():
    assert held(REST, NOTHING, CAR, 300) == REST
    struck = REST._replace(lateral_speed=0.1, yaw_rate=0.1)
    state = held(struck, NOTHING, CAR, 3000)
    assert max(abs(state.lateral_speed), abs(state.yaw_rate)) < 0.1
    assert abs(state.speed) < 0.01


def test_a_suspected_actuator_gives_less_and_no_other():
    inputs = NOTHING._replace(
        steering_motor_1_now=3.0, steering_motor_2_now=5.0, drive_left_now=40.0, drive_right_now=60.0
    )
    lossy = REST._replace(torque_loss=0.25, speed=5.0)

    def seen(name):
        return AutomatedVehicle.output(lossy, inputs._replace(**{f"{name}_suspected": 1.0}), PLAIN)

    whole = AutomatedVehicle.output(lossy, inputs, PLAIN)
    share = 1.0 - PLAIN.steering_motor_inertia / PLAIN.column_inertia
    for name, torque in (("steering_motor_1", 3.0), ("steering_motor_2", 5.0)):
        lost = whole.steering_shaft_torque - seen(name).steering_shaft_torque
        assert lost == pytest.approx(0.25 * torque * share)
    heavy = PLAIN.wheel_radius * (PLAIN.mass + PLAIN.rolling_mass)
    for name, torque in (("drive_left", 40.0), ("drive_right", 60.0)):
        lost = whole.longitudinal_acceleration - seen(name).longitudinal_acceleration
        assert lost == pytest.approx(0.25 * torque / heavy)


def test_more_drive_on_the_right_turns_to_the_left():
    inputs = NOTHING._replace(drive_right=50.0, drive_right_now=50.0)
    state = AutomatedVehicle.transition(REST._replace(speed=5.0), inputs, PLAIN)
    moment = 0.5 * PLAIN.track_width * 50.0 / PLAIN.wheel_radius
    assert state.yaw_rate == pytest.approx(PLAIN.sample_time * moment / PLAIN.yaw_inertia, rel=1e-3)


def test_a_lighter_vehicle_and_smaller_tyres_are_excesses():
    torque = 60.0
    pushed = NOTHING._replace(drive_left=torque, drive_right=torque, drive_left_now=torque, drive_right_now=torque)
    rolling = REST._replace(speed=5.0)
    usual = AutomatedVehicle.output(rolling, pushed, PLAIN).longitudinal_acceleration
    light = AutomatedVehicle.output(rolling._replace(drive_excess=0.1), pushed, PLAIN).longitudinal_acceleration
    assert light == pytest.approx(1.1 * usual, rel=1e-9)
    assert AutomatedVehicle.output(rolling._replace(drive_excess=0.1), NOTHING, PLAIN).longitudinal_acceleration == 0.0
    small = AutomatedVehicle.output(rolling._replace(wheel_speed_scale=0.1), NOTHING, PLAIN)
    assert small.wheel_speed_rear_left == pytest.approx(1.1 * 5.0 * PLAIN.wheel_speed_scale, rel=1e-9)


def test_turning_carries_speed_from_across_to_along_and_back():
    car = replace(CAR, sample_time=0.01)
    inputs = skeleton(AutomatedVehicle.Input)
    state = skeleton(AutomatedVehicle.State)._replace(speed=8.0, yaw_rate=0.4)
    calm, drifting = (AutomatedVehicle.moved(each, inputs, car) for each in (state, state._replace(lateral_speed=1.5)))
    assert drifting.speed - calm.speed == pytest.approx(0.01 * 1.5 * 0.4)
    assert calm.lateral_speed == pytest.approx(-0.01 * 8.0 * 0.4)
