import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.block import leaves, rebuild, skeleton
from tierod.core.graph import scan
from tierod.core.graph.trace import trace
from tierod.physics import single_track
from tierod_lab.ground.cars.car import Start
from tierod_lab.ground.cars.eps_car import EpsCar
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.control.assist import ActiveReturn, AssistUnit, Characteristic
from tierod_lab.ground.control.driver import HumanDriver, Pedals
from tierod_lab.ground.parts import Port, pass_through
from tierod_lab.ground.recorder import channel_names
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.friction import Dahl, DryFriction

STEP = 1e-3
ONES = ("road.adhesion_left", "road.adhesion_right", "road.support", "demand.grip")
CHASSIS = [SingleTrack(), TwoTrack()]
KINDS = ["single track", "two track"]


def inputs(car, seconds, speed=20.0, **columns):
    time = np.arange(round(seconds / STEP)) * STEP
    names = [path for path, _ in leaves(skeleton(car.Sample))]
    given = {name.replace("__", "."): value for name, value in columns.items()} | {"demand.speed": speed}
    values = np.zeros((len(time), len(names)))
    for column, name in enumerate(names):
        usual = 1.0 if name in ONES or name.endswith(".gain") else 0.0
        value = given.get(name, usual)
        values[:, column] = value(time) if callable(value) else value
    assert set(given) <= set(names)
    return values


def car_with(chassis, speed=20.0, level=4.0, **parts):
    steering = parts.pop("steering", ColumnEps())
    steering = replace(steering, friction=replace(steering.friction, level=level))
    return EpsCar(chassis=chassis, start=Start(speed), steering=steering, **parts)


def last(result, name):
    (path,) = (n for n in result.names if n.split(".")[-1] == name)
    return result[path][-1]


def series(result, name):
    (path,) = (n for n in result.names if n.split(".")[-1] == name)
    return result[path]


@pytest.mark.parametrize("chassis", CHASSIS, ids=KINDS)
def test_every_channel_has_one_name(chassis):
    car = EpsCar(chassis=chassis)
    names = channel_names(car)
    assert len(names) == len(trace(car).output)
    assert {"steering_wheel_angle", "driver_torque", "motor_torque", "yaw_rate", "lateral_acceleration"} <= set(names)


@pytest.mark.parametrize("chassis", CHASSIS, ids=KINDS)
@pytest.mark.parametrize("speed", [8.0, 15.0, 25.0])
def test_steady_yaw_gain_is_the_closed_form(chassis, speed):
    car = car_with(chassis, speed, level=0.0)
    out = scan(car, inputs(car, 14.0, speed, demand__steering_wheel_angle=0.05))
    steer = 0.5 * (last(out, "road_wheel_angle_left") + last(out, "road_wheel_angle_right"))
    true_speed = last(out, "truth_speed")
    gain = single_track.steady_yaw_gain(true_speed, chassis.wheelbase, chassis.understeer_gradient)
    assert last(out, "yaw_rate") / steer == pytest.approx(gain, rel=0.01)


@pytest.mark.parametrize("chassis", CHASSIS, ids=KINDS)
def test_left_is_positive_everywhere_and_right_mirrors_it(chassis):
    car = car_with(chassis, 15.0)
    left, right = (scan(car, inputs(car, 6.0, 15.0, demand__steering_wheel_angle=angle)) for angle in (0.5, -0.5))
    for name in ("steering_wheel_angle", "yaw_rate", "lateral_acceleration", "driver_torque", "motor_torque"):
        assert last(left, name) > 0.0, name
        assert last(right, name) == pytest.approx(-last(left, name), rel=1e-9), name
    assert last(left, "truth_self_aligning_torque") > 0.0
    assert last(left, "wheel_speed_rear_right") > last(left, "wheel_speed_rear_left")


def test_work_on_the_column_is_kinetic_energy_and_losses():
    car = car_with(TwoTrack(), 15.0, level=8.0)
    out = scan(car, inputs(car, 20.0, 15.0, demand__steering_wheel_angle=lambda t: 0.8 * np.sin(2.0 * t)))
    steering, motor = car.steering, car.steering.motor
    rate = series(out, "motor_speed") / motor.ratio
    tie_rods = series(out, "rack_force") * series(out, "rack_speed")
    power_in = (series(out, "driver_torque") + motor.ratio * series(out, "motor_torque")) * rate
    damping = steering.damping + motor.ratio**2 * motor.damping
    lost = (series(out, "truth_friction_resistance") + damping * rate) * rate + tie_rods
    inertia = steering.column_inertia + motor.ratio**2 * motor.inertia
    kinetic = 0.5 * inertia * (rate[-1] ** 2 - rate[0] ** 2)
    assert np.trapezoid(power_in, dx=STEP) == pytest.approx(np.trapezoid(lost, dx=STEP) + kinetic, rel=0.01)


def test_friction_loop_area_in_the_car_is_level_times_path():
    steering = ColumnEps(friction=DryFriction(law=Dahl(math.radians(0.02))))
    car = car_with(TwoTrack(), 15.0, 8.0, steering=steering)
    out = scan(car, inputs(car, 20.0, 15.0, demand__steering_wheel_angle=lambda t: 0.8 * np.sin(2.0 * t)))
    rate = series(out, "motor_speed") / car.steering.motor.ratio
    work = np.trapezoid(series(out, "truth_friction_resistance") * rate, dx=STEP)
    assert work == pytest.approx(8.0 * np.trapezoid(np.abs(rate), dx=STEP), rel=0.01)


@pytest.mark.parametrize("chassis", CHASSIS, ids=KINDS)
def test_hands_off_the_wheel_returns_until_friction_holds_it(chassis):
    for level, left in ((1.0, 0.6), (0.0, 0.05)):
        car = car_with(chassis, 15.0, level)
        grip = lambda t: np.where(t < 3.0, 1.0, 0.0)  # noqa: E731
        outcome = lambda t: np.where(t < 3.0, 1.0, 0.0)  # noqa: E731
        out = scan(car, inputs(car, 9.0, 15.0, demand__steering_wheel_angle=outcome, demand__grip=grip))
        angle = series(out, "steering_wheel_angle")
        assert angle[2990] == pytest.approx(1.0, abs=0.05)
        assert abs(angle[-1]) < left
        assert abs(series(out, "steering_wheel_rate")[-1]) < 0.02


def test_standing_car_scrubs_on_the_ground_only():
    car = car_with(TwoTrack(), 0.0)
    turn = lambda t: 3.0 * np.sin(t)  # noqa: E731
    ground, hoist = (
        scan(car, inputs(car, 10.0, 0.0, demand__steering_wheel_angle=turn, road__support=support))
        for support in (1.0, 0.0)
    )
    assert np.max(np.abs(series(ground, "truth_scrub_torque"))) > 100.0
    assert not np.any(series(hoist, "truth_scrub_torque"))
    assert np.max(np.abs(series(ground, "truth_position_y"))) < 0.05
    assert np.max(np.abs(series(ground, "motor_torque"))) > 2.0 * np.max(np.abs(series(hoist, "motor_torque")))


@pytest.mark.parametrize("chassis", CHASSIS, ids=KINDS)
def test_a_halting_car_swings_on_its_tyres_but_rolls_no_way_back(chassis):
    car = car_with(chassis, 8.0)
    outcome = lambda t: np.maximum(8.0 - 2.0 * np.maximum(t - 1.0, 0.0), 0.0)  # noqa: E731
    planned = lambda t: np.where((t > 1.0) & (t < 5.0), -2.0, 0.0)  # noqa: E731
    out = scan(car, inputs(car, 9.0, outcome, demand__acceleration=planned))
    distance = series(out, "truth_distance")
    assert series(out, "truth_speed")[5500] == pytest.approx(0.0, abs=0.03)
    assert np.max(distance) - distance[-1] < 2e-3
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        assert np.min(series(out, f"wheel_speed_{wheel}")) > -1e-3
    assert np.max(np.abs(series(out, "truth_speed")[-100:])) < 1e-3


def free(chassis, step, level):
    unit = AssistUnit(
        characteristic=Characteristic(linear_gain=0.0, quadratic_gain=0.0),
        active_return=ActiveReturn(gain=0.0),
        damping=0.0,
        step_time=step,
    )
    driver = HumanDriver(pedals=Pedals(proportional=1e-12, integral=0.0), step_time=step)
    return car_with(chassis, 15.0, level, assist=unit, driver=driver, step_time=step)


@pytest.mark.parametrize("chassis", CHASSIS, ids=KINDS)
@pytest.mark.parametrize("level", [0.0, 8.0])
def test_a_step_of_a_millisecond_is_of_second_order_and_short_enough(chassis, level):
    push = lambda t: 5.0 * np.sin(3.0 * t) ** 3  # noqa: E731
    values = inputs(free(chassis, STEP, level), 2.0, 15.0, demand__hand_torque=push, demand__grip=0.0)
    coarse, quarter, fine = (
        scan(free(chassis, STEP / parts, level), np.repeat(values, parts, axis=0)) for parts in (1, 4, 32)
    )
    for name in ("steering_wheel_rate", "driver_torque", "yaw_rate", "lateral_acceleration", "truth_kingpin_torque"):
        exact = series(fine, name)[::32]
        first, second = (np.std(series(each, name)[::k] - exact) for each, k in ((coarse, 1), (quarter, 4)))
        assert first < 1e-3 * np.std(exact), name
        assert first > 10.0 * second, name


def test_a_port_changes_what_the_unit_reads():
    car = car_with(SingleTrack(), 15.0)
    outcome = {"demand__steering_wheel_angle": 0.4}
    fault_free = scan(car, inputs(car, 4.0, 15.0, **outcome))
    lost = scan(car, inputs(car, 4.0, 15.0, ports__driver_torque__gain=0.0, **outcome))
    dead = scan(car, inputs(car, 4.0, 15.0, ports__motor_torque__gain=0.0, **outcome))
    assert last(fault_free, "motor_torque") > 0.01
    assert last(lost, "motor_target_torque") <= 0.0
    assert abs(last(dead, "motor_torque")) < 1e-9
    assert last(dead, "motor_target_torque") > 0.01
    assert last(dead, "driver_torque") > 1.5 * last(fault_free, "driver_torque")


def test_a_held_port_gives_the_last_fault_free_value():
    kept = 0.0
    seen = []
    for value, held in ((1.0, 0.0), (2.0, 0.0), (3.0, 1.0), (4.0, 1.0), (5.0, 0.0)):
        kept, out = pass_through(Port(2.0, 0.5, held), kept, value)
        seen.append(out)
    assert seen == [2.5, 4.5, 4.5, 4.5, 10.5]


@pytest.mark.parametrize("chassis", CHASSIS, ids=KINDS)
def test_float_steps_agree_with_the_kernel(chassis):
    car = car_with(chassis, 15.0, driver=HumanDriver(delay_steps=1))
    values = inputs(car, 0.03, 15.0, demand__steering_wheel_angle=lambda t: 0.5 * np.sin(60.0 * t))
    kernel = scan(car, values)
    state, oldest = car.init(), 0.0
    for row, expected in zip(values.tolist(), kernel.values, strict=True):
        memory = state.held.driver
        ring = memory.offset_ahead._replace(oldest=oldest)
        state = state._replace(held=state.held._replace(driver=memory._replace(offset_ahead=ring)))
        state, out = car.step(state, rebuild(skeleton(car.Sample), row))
        oldest = state.held.driver.offset_ahead.newest
        np.testing.assert_allclose([v for _, v in leaves(out)], expected, rtol=1e-7, atol=1e-9)
