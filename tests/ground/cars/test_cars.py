"""Whole cars and benches against closed forms, balances of energy and published equations."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ground.rigs import Run
from tierod.core.block import leaves, rebuild, skeleton
from tierod.core.graph import scan
from tierod.core.graph.trace import jacobian
from tierod_lab.ground.cars import Start
from tierod_lab.ground.cars.benches import Acting, ColumnBench, ColumnMotion, MotorBench
from tierod_lab.ground.cars.road_cars import DemonstratorCar, EpsCar, SteerByWireCar
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.control import ActiveReturn, AssistUnit, Characteristic
from tierod_lab.ground.drivers import HumanDriver, Pedals
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.friction import DryFriction

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
def test_left_is_positive_everywhere_and_right_mirrors_it(chassis):
    car = car_with(chassis, 15.0)
    left, right = (scan(car, inputs(car, 6.0, 15.0, demand__steering_wheel_angle=angle)) for angle in (0.5, -0.5))
    for name in ("steering_wheel_angle", "yaw_rate", "lateral_acceleration", "driver_torque", "motor_torque"):
        assert last(left, name) > 0.0, name
        assert last(right, name) == pytest.approx(-last(left, name), rel=1e-9), name
    assert last(left, "truth_self_aligning_torque") > 0.0
    assert last(left, "wheel_speed_rear_right") > last(left, "wheel_speed_rear_left")


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


pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")
BY_WIRE = SteerByWireCar(chassis=SingleTrack(), driver=HumanDriver(persistence=0.0), start=Start(15.0))
BY_WIRE_STEPS = 4000
BY_WIRE_SWING = 0.8 * np.sin(3.0 * np.arange(BY_WIRE_STEPS) * 1e-3)


def test_equation_1_holds_along_a_drive():
    """J_w 3.5 kg m2 and b_w 160 Nms/rad with the true friction and kingpins; Ackermann off."""
    linkage = replace(BY_WIRE.steering.linkage, ackermann_gain=0.0)
    car = replace(BY_WIRE, steering=replace(BY_WIRE.steering, linkage=linkage))
    run = Run(car, BY_WIRE_STEPS, demand__speed=15.0, demand__steering_wheel_angle=BY_WIRE_SWING)
    left = 3.5 * run["truth_road_wheel_acceleration"] + 160.0 * run["road_wheel_rate"]
    left += run["truth_road_wheel_friction"] + run["truth_kingpin_torque"]
    driving = 17.0 * 3.0 * 75.0 * 0.7 * 0.06 * run["motor_current"]
    np.testing.assert_allclose(left, driving, atol=1e-3 * np.max(np.abs(driving)))
    assert np.max(np.abs(driving)) > 100.0


CAR = DemonstratorCar(start=Start(6.0))
COUNT = 8000
TIME = np.arange(COUNT) * 1e-3
AHEAD = CAR.driver.anticipation


def bends(time):
    """Curvature of the road [1/m]: to the left and right, after two seconds."""
    return 0.08 * np.sin(1.2 * np.maximum(time - 1.0, 0.0))


def driven(car=CAR, **inputs):
    return Run(
        car,
        COUNT,
        demand__speed=6.0,
        demand__attention=1.0,
        road__curvature=bends(TIME),
        demand__curvature_ahead=bends(TIME + AHEAD),
        **inputs,
    )


@cache
def winding():
    return driven()


def test_it_follows_the_road_and_keeps_its_speed():
    run = winding()
    assert np.max(np.abs(run["truth_lateral_offset"])) < 0.35
    np.testing.assert_allclose(run["vehicle_speed"], 6.0, atol=0.25)
    angle, target = run["steering_wheel_angle"], run["target_steering_wheel_angle"]
    assert np.max(np.abs(angle)) > 2.0
    assert np.sqrt(np.mean((angle - target) ** 2)) < 0.08
    np.testing.assert_allclose(
        angle / 19.7, 0.5 * (run["road_wheel_angle_left"] + run["road_wheel_angle_right"]), atol=1e-3
    )


TABLE_3 = (
    -0.491074732452 + 706.750702094704j,
    -0.491074732452 - 706.750702094704j,
    -0.000000000001,
    -8.114907494361,
    -3.839922431729 + 79.657898579634j,
    -3.839922431729 - 79.657898579634j,
)
SMOOTH = replace(ColumnBench(), friction=DryFriction(level=0.0))
IDLE = rebuild(skeleton(Acting), [0.0] * 10)


def linear_bench(bench):
    def slope(motion):
        return bench.derivative(motion, motion, bench.friction.remembered(), 0.0, IDLE)

    return np.array(jacobian(slope, ColumnMotion(*[0.0] * 6)))


def ordered(values):
    return sorted(values, key=lambda value: (round(value.real, 3), value.imag))


def test_it_has_the_published_eigenvalues():
    np.testing.assert_allclose(ordered(np.linalg.eigvals(linear_bench(SMOOTH))), ordered(TABLE_3), atol=1e-5)
    relative = np.abs(np.subtract(ordered(np.linalg.eigvals(linear_bench(SMOOTH))), ordered(TABLE_3)))
    assert np.max(relative / np.maximum(np.abs(ordered(TABLE_3)), 1.0)) < 1e-6


MOTOR_BENCH = MotorBench()
BENCH_STEPS = 4000
TARGET = 15.0 * np.sin(4.0 * np.arange(BENCH_STEPS) * 1e-3)
PERIOD, INDUCTANCE = 1e-4, 1e-4


@cache
def swinging_motor(**inputs):
    return Run(MOTOR_BENCH, BENCH_STEPS, control=1.0, target_motor_angle=TARGET, **inputs)


def test_the_flux_of_currents_and_voltages_shows_the_angle():
    run = swinging_motor()
    current = run["motor_current_alpha"] + 1j * run["motor_current_beta"]
    voltage = run["motor_voltage_alpha"] + 1j * run["motor_voltage_beta"]
    resistance = np.repeat(run["truth_motor_resistance"], 10)
    middle = 0.5 * (current[1:] + current[:-1])
    flux = run["truth_motor_flux"][0] + np.cumsum(PERIOD * (voltage[1:] - resistance[1:] * middle))
    angle = np.unwrap(np.angle(flux - INDUCTANCE * current[1:])) / 4.0
    np.testing.assert_allclose(angle, run["motor_angle_mechanical"][1:], atol=1e-3)
