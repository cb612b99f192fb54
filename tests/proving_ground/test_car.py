import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.graph import scan
from tierod.physics import single_track
from tierod.proving_ground import AssistMap, Chassis, Driver, EpsCar, Steering, TorsionBar

STEP = 1e-3
STILL_DRIVER = Driver(correction=0.0, restlessness=0.0)
LOOSE_DRIVER = replace(STILL_DRIVER, arm_stiffness=0.0, arm_damping=0.0)


def integral(values, time):
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(time)))


def columns(seconds, speed=20.0, demand=0.0, friction=4.0, ground=1.0, curvature=0.0):
    time = np.arange(round(seconds / STEP)) * STEP
    inputs = np.zeros((len(time), 5))
    for column, value in enumerate((speed, curvature, demand, friction, ground)):
        inputs[:, column] = value(time) if callable(value) else value
    return time, inputs


def steady(demand, speed, chassis=None):
    car = EpsCar(chassis=chassis or Chassis(), driver=STILL_DRIVER)
    _, inputs = columns(12.0, speed, demand, friction=0.0)
    return car, scan(car, inputs).at(-1)


@pytest.mark.parametrize("speed", [8.0, 20.0, 35.0])
def test_steady_yaw_gain_is_the_closed_form(speed):
    car, out = steady(0.05, speed)
    gain = single_track.steady_yaw_gain(speed, car.chassis.wheelbase, car.chassis.understeer_gradient)
    steer = out.steering_wheel_angle * car.steering.ratio
    assert out.yaw_rate / steer == pytest.approx(gain, rel=0.01)
    assert out.lateral_acceleration == pytest.approx(speed * out.yaw_rate, rel=1e-3)


def test_understeer_gradient_in_the_linear_range_is_the_closed_form():
    car, out = steady(0.2, 25.0, Chassis(adhesion=20.0))
    steer = out.steering_wheel_angle * car.steering.ratio
    extra = steer - car.chassis.wheelbase * out.yaw_rate / out.vehicle_speed
    assert extra / out.lateral_acceleration == pytest.approx(car.chassis.understeer_gradient, rel=0.01)


def test_left_turn_is_positive_everywhere():
    _, out = steady(0.5, 15.0)
    for name in ("steering_wheel_angle", "yaw_rate", "lateral_acceleration", "driver_torque", "motor_torque"):
        assert getattr(out, name) > 0.0, name
    assert out.truth_self_aligning_torque > 0.0
    assert out.truth_front_lateral_force > 0.0


def test_right_turn_mirrors_the_left_one():
    _, left = steady(0.5, 15.0)
    _, right = steady(-0.5, 15.0)
    assert right.yaw_rate == -left.yaw_rate
    assert right.driver_torque == -left.driver_torque


@pytest.mark.parametrize("bar", [None, TorsionBar()])
def test_work_of_driver_and_motor_is_kinetic_energy_and_losses(bar):
    car = EpsCar(driver=STILL_DRIVER, torsion_bar=bar)
    time, inputs = columns(20.0, 15.0, lambda t: 0.8 * np.sin(2.0 * t), friction=8.0)
    out = scan(car, inputs)
    if bar is None:
        rate, inertia = out["steering_wheel_rate"], car.steering.inertia
    else:
        rate = np.gradient(out["steering_wheel_angle"] - out["driver_torque"] / bar.stiffness, time)
        inertia = car.steering.inertia - bar.wheel_inertia
    power_in = (out["driver_torque"] + car.steering.motor_gear * out["motor_torque"]) * rate
    resistance = out["truth_friction_resistance"] + out["truth_scrub_resistance"]
    resistance += car.steering.ratio * out["truth_self_aligning_torque"] + car.steering.damping * rate
    work_in, lost = integral(power_in, time), integral(resistance * rate, time)
    kinetic = 0.5 * inertia * (rate[-1] ** 2 - rate[0] ** 2)
    friction_work = integral(out["truth_friction_resistance"] * rate, time)
    assert work_in == pytest.approx(lost + kinetic, rel=0.01)
    assert 0.0 < friction_work < 8.0 * integral(np.abs(rate), time)


def test_friction_loop_area_in_the_car_is_level_times_path():
    """Strokes of many Dahl angles: each of the reversals lacks less than two Dahl angles of path."""
    car = EpsCar(driver=STILL_DRIVER, steering=Steering(dahl_angle=math.radians(0.02)))
    time, inputs = columns(20.0, 15.0, lambda t: 0.8 * np.sin(2.0 * t), friction=8.0)
    out = scan(car, inputs)
    rate = out["steering_wheel_rate"]
    work = integral(out["truth_friction_resistance"] * rate, time)
    assert work == pytest.approx(8.0 * integral(np.abs(rate), time), rel=0.01)


def test_hands_off_the_wheel_returns_until_friction_holds_it():
    car = EpsCar(driver=LOOSE_DRIVER)
    start = car.init()
    state = start._replace(motion=start.motion._replace(column_angle=1.0))
    _, inputs = columns(6.0, 15.0, friction=1.0)
    out = scan(car, inputs, state)
    angle = out["steering_wheel_angle"]
    assert angle[0] == 1.0
    held = car.steering.ratio * out["truth_self_aligning_torque"][-1]
    assert abs(angle[-1]) < 0.4
    assert abs(out["steering_wheel_rate"][-1]) < 1e-2
    assert abs(held) < 1.0
    _, inputs = columns(6.0, 15.0, friction=0.0)
    assert abs(scan(car, inputs, state)["steering_wheel_angle"][-1]) < 0.01


def test_standing_car_scrubs_on_the_ground_only():
    turn = lambda t: 3.0 * np.sin(t)  # noqa: E731
    car = EpsCar(driver=STILL_DRIVER)
    ground = scan(car, columns(10.0, 0.0, turn, ground=1.0)[1])
    hoist = scan(car, columns(10.0, 0.0, turn, ground=0.0)[1])
    parking = car.chassis.parking_torque * car.steering.ratio
    assert np.max(ground["truth_scrub_resistance"]) == pytest.approx(parking, rel=0.05)
    assert not np.any(hoist["truth_scrub_resistance"])
    assert not np.any(ground["yaw_rate"])
    rolling = scan(car, columns(10.0, 8.0, turn, ground=1.0)[1])
    assert np.max(np.abs(rolling["truth_scrub_resistance"])) < 1e-3


def test_trail_falls_as_the_tyres_slip():
    _, gentle = steady(0.2, 15.0)
    _, hard = steady(2.5, 15.0)
    trails = [out.truth_self_aligning_torque / out.truth_front_lateral_force for out in (gentle, hard)]
    assert trails[0] == pytest.approx(0.05, rel=0.05)
    assert 0.025 < trails[1] < 0.9 * trails[0]


@pytest.mark.parametrize(("bar", "tolerance"), [(None, 0.01), (TorsionBar(), 0.01)])
def test_a_millisecond_is_short_enough(bar, tolerance):
    car = EpsCar(driver=STILL_DRIVER, torsion_bar=bar, steering=Steering(dahl_angle=math.radians(0.3)))
    demand = lambda t: 0.6 * np.sin(1.5 * t)  # noqa: E731
    coarse = scan(car, columns(8.0, 12.0, demand, friction=12.5)[1])
    fine_car = replace(car, step_time=STEP / 8.0, driver=replace(car.driver, delay_steps=8 * car.driver.delay_steps))
    time = np.arange(8 * len(coarse)) * STEP / 8.0
    held = np.floor(time / STEP + 1e-6) * STEP
    fine = scan(fine_car, np.column_stack([0.0 * time + 12.0, 0.0 * time, demand(held), 0.0 * time + 12.5, time**0]))
    for name in ("steering_wheel_rate", "driver_torque", "yaw_rate"):
        error = coarse[name] - fine[name][::8]
        assert np.sqrt(np.mean(error**2)) < tolerance * np.std(fine[name]), name


def test_torsion_bar_twists_by_the_torque():
    car = EpsCar(driver=STILL_DRIVER, torsion_bar=TorsionBar())
    _, inputs = columns(8.0, 15.0, 0.5)
    out = scan(car, inputs)
    rigid = scan(EpsCar(driver=STILL_DRIVER), inputs)
    column_angle = out.state.values[0]
    assert out["steering_wheel_angle"][-1] - column_angle == pytest.approx(out["driver_torque"][-1] / 140.0, rel=1e-6)
    assert out["driver_torque"][-1] == pytest.approx(rigid["driver_torque"][-1], abs=0.2)


def test_torque_limit_of_the_driver_holds():
    car = EpsCar(driver=replace(STILL_DRIVER, torque_limit=2.0), assist=AssistMap(maximum_torque=1.0))
    out = scan(car, columns(5.0, 0.0, 3.0)[1])
    assert np.max(np.abs(out["driver_torque"])) == 2.0
    assert np.max(np.abs(out["motor_torque"])) <= 1.0 / 20.0


def test_float_steps_agree_with_the_kernel():
    car = EpsCar(driver=replace(STILL_DRIVER, delay_steps=1, correction=1.0))
    _, inputs = columns(0.2, 15.0, lambda t: 0.5 * np.sin(20.0 * t), curvature=0.01)
    kernel = scan(car, inputs)
    state, oldest = car.init(), 0.0
    for row, expected in zip(inputs.tolist(), kernel.values, strict=True):
        state = state._replace(seen_offset=state.seen_offset._replace(oldest=oldest))
        state, out = car.step(state, car.Sample(*row))
        oldest = state.seen_offset.newest
        np.testing.assert_allclose(list(out), expected, rtol=1e-9, atol=1e-12)
