"""Virtual drives: a car, a road, a friction course and sensors become a recording."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tierod.block import tuning, units
from tierod.errors import ParameterError
from tierod.graph import Memory, scan
from tierod.physics.single_track import steady_road_wheel_angle
from tierod.proving_ground.car import EpsCar
from tierod.proving_ground.car_signals import Output
from tierod.proving_ground.friction_course import FrictionCourse
from tierod.proving_ground.road import MIXED, Road, RoadKind, random_road
from tierod.proving_ground.scatter import Scatter
from tierod.proving_ground.sensors import SensorNoise
from tierod.recording import Channel, Recording
from tierod.signals import SIGNALS

TRUTH_RATE = 100.0
"""Rate of the channels prefixed `truth_` [Hz]."""
_CHUNK = 60_000
_REST = 2.0
_ROAD, _DRIVER, _SENSORS, _SCATTER = range(4)

Inputs = Callable[[np.ndarray], np.ndarray]


def drive(
    vehicle: EpsCar | None = None,
    minutes: float = 13.0,
    friction: FrictionCourse | float = 4.0,
    seed: int = 0,
    scatter: bool | Scatter = False,
    noise: SensorNoise | None = None,
    road: tuple[RoadKind, ...] = MIXED,
) -> Recording:
    """A drive through city, country and motorway, as production sensors see it.

    Args:
        vehicle: the car; the mid-size one where none is given
        minutes: duration [min]
        friction: level of dry friction at the column [N*m], constant or over time
        seed: of all chance; route, driver, sensors and scatter draw from streams of their own, so that the same seed
            keeps the route whatever the friction, the car or the sensors are
        scatter: whether car and sensors are drawn at random around the given ones, and how widely
        noise: the sensors; those of a production car where none are given
        road: kinds of road, in order

    Returns:
        canonical channels at their sensors' rates, and the truth at 100 Hz in channels prefixed `truth_`;
        `truth_friction_torque` is the level that a monitor should find, `truth_friction_resistance` the signed torque

    Raises:
        ParameterError: a duration that is not positive, or a sensor's rate that does not divide the plant's
    """
    if not 0.0 < minutes < math.inf:
        raise ParameterError(f"a drive needs a positive duration, not {minutes} min")
    nominal = vehicle or EpsCar()
    course = friction if isinstance(friction, FrictionCourse) else FrictionCourse.constant(float(friction))
    sensors = noise or SensorNoise()
    spread = Scatter() if scatter is True else scatter
    car = nominal
    if spread:
        car, sensors = spread.draw(nominal, sensors, _generator(seed, _SCATTER))
    seconds = 60.0 * minutes
    route = random_road(seconds, _generator(seed, _ROAD), road)
    inputs = _driving(nominal, route, course, _restlessness(nominal, seconds, _generator(seed, _DRIVER)))
    metadata = {
        "source": "tierod virtual drive",
        "seed": seed,
        "minutes": minutes,
        "friction": dataclasses.asdict(course),
        "scatter": dataclasses.asdict(spread) if spread else None,
        "road": list(zip(route.starts, route.kinds, strict=True)),
    }
    return _recorded(car, inputs, seconds, sensors, seed, metadata)


def lock_to_lock(
    friction: float,
    hoist: bool,
    vehicle: EpsCar | None = None,
    rate: float = 1.0,
    lock_angle: float = math.radians(570.0),
    seed: int = 0,
    noise: SensorNoise | None = None,
) -> Recording:
    """The slow turn of the standing car from the middle to the right lock, to the left one, and back.

    Args:
        friction: level of dry friction at the column [N*m]
        hoist: whether the wheels hang free; on the ground the tyres scrub
        vehicle: the car; the mid-size one where none is given
        rate: greatest rate of the steering wheel [rad/s]; each stroke is half a cosine
        lock_angle: of the steering wheel at the locks [rad]
        seed: of the sensors' noise
        noise: the sensors; those of a production car where none are given

    Returns:
        channels as of `drive`

    Raises:
        ParameterError: a rate or an angle that is not positive

    Source: Mohtat et al., Appendix A: 0, -570, +570, 0 degrees.
    """
    if not (rate > 0.0 and lock_angle > 0.0):
        raise ParameterError(f"lock to lock needs a positive rate and angle, not {rate} rad/s and {lock_angle} rad")
    course = FrictionCourse.constant(float(friction))
    car = vehicle or EpsCar()
    person = replace(car.driver, correction=0.0, persistence=3.0, restlessness=0.0)
    inputs, seconds = _turning(course, lock_angle, rate, hoist)
    metadata = {
        "source": "tierod virtual lock-to-lock turn",
        "seed": seed,
        "hoist": hoist,
        "friction": dataclasses.asdict(course),
    }
    sensors = noise or SensorNoise()
    return _recorded(replace(car, driver=person), inputs, seconds, sensors, seed, metadata)


def _generator(seed: int, stream: int, part: int = 0) -> np.random.Generator:
    return np.random.default_rng([seed, stream, part])


def _driving(car: EpsCar, road: Road, course: FrictionCourse, restless: Inputs) -> Inputs:
    """What acts on the car at given instants; the driver steers ahead what the road will ask for."""
    chassis, ratio, ahead = car.chassis, car.steering.ratio, car.driver.anticipation

    def inputs(time: np.ndarray) -> np.ndarray:
        speed = road.speed_at(time)
        steer = steady_road_wheel_angle(
            road.curvature_at(time + ahead), speed, chassis.wheelbase, chassis.understeer_gradient
        )
        demand = steer / ratio + restless(time)
        ground = np.ones(len(time))
        return np.column_stack([speed, road.curvature_at(time), demand, course.at(time), ground])

    return inputs


def _turning(course: FrictionCourse, lock_angle: float, rate: float, hoist: bool) -> tuple[Inputs, float]:
    """What acts on the standing car that is turned from lock to lock, and how long [s]; a rest before every stroke."""
    targets = np.array([0.0, -lock_angle, lock_angle, 0.0])
    turning = 0.5 * math.pi * np.abs(np.diff(targets)) / rate
    ends = np.cumsum(turning + _REST)

    def inputs(time: np.ndarray) -> np.ndarray:
        stroke = np.minimum(np.searchsorted(ends, time), len(turning) - 1)
        share = np.clip((time - (ends - turning)[stroke]) / turning[stroke], 0.0, 1.0)
        shape = 0.5 - 0.5 * np.cos(math.pi * share)
        standing, ground = np.zeros(len(time)), np.full(len(time), 0.0 if hoist else 1.0)
        demand = targets[stroke] + (targets[stroke + 1] - targets[stroke]) * shape
        return np.column_stack([standing, standing, demand, course.at(time), ground])

    return inputs, float(ends[-1] + _REST)


def _restlessness(car: EpsCar, seconds: float, generator: np.random.Generator) -> Inputs:
    """Small needless corrections [rad]: random values about every 0.7 s, joined smoothly."""
    knots = np.cumsum(generator.uniform(0.4, 1.0, int(seconds / 0.4) + 10))
    values = car.driver.restlessness * generator.standard_normal(len(knots))

    def restless(time: np.ndarray) -> np.ndarray:
        after = np.clip(np.searchsorted(knots, time), 1, len(knots) - 1)
        share = np.clip((time - knots[after - 1]) / (knots[after] - knots[after - 1]), 0.0, 1.0)
        smooth = share * share * (3.0 - 2.0 * share)
        return values[after - 1] + smooth * (values[after] - values[after - 1])

    return restless


def _recorded(
    car: EpsCar, inputs: Inputs, seconds: float, sensors: SensorNoise, seed: int, metadata: dict[str, Any]
) -> Recording:
    """The car run over its inputs and read by its sensors."""
    rates = {name: sensor.rate for name, sensor in sensors.items()}
    names = Output._fields
    strides = [_stride(name, rates.get(name, TRUTH_RATE), car.step_time) for name in names]
    kept: list[list[np.ndarray]] = [[] for _ in names]
    for start, values in _chunks(car, inputs, seconds):
        for column, stride in enumerate(strides):
            kept[column].append(values[-start % stride :: stride, column].copy())
    channels = {}
    noisy = dict(sensors.items())
    times: dict[int, np.ndarray] = {}
    for column, (name, stride, unit) in enumerate(zip(names, strides, units(Output), strict=True)):
        values = np.concatenate(kept[column])
        kept[column].clear()
        time = times.setdefault(stride, np.arange(len(values)) * (stride * car.step_time))
        if name in noisy:
            values = noisy[name].measure(values, _generator(seed, _SENSORS, column))
        channels[name] = Channel(name, time, values, SIGNALS[name].unit if name in SIGNALS else unit, "virtual car")
    described = {"vehicle": dict(tuning(car)), "sensors": dataclasses.asdict(sensors)}
    return Recording(channels, metadata | described)


def _chunks(car: EpsCar, inputs: Inputs, seconds: float) -> Iterator[tuple[int, np.ndarray]]:
    """(first step, outputs) of a minute at a time, so that a long drive needs little memory."""
    count = round(seconds / car.step_time)
    memory: Memory | None = None
    for start in range(0, count, _CHUNK):
        time = np.arange(start, min(start + _CHUNK, count)) * car.step_time
        result = scan(car, inputs(time), memory)
        memory = result.state
        yield start, result.values


def _stride(name: str, rate: float, step_time: float) -> int:
    stride = round(1.0 / (rate * step_time))
    if stride < 1 or not math.isclose(stride * step_time * rate, 1.0, rel_tol=1e-9):
        raise ParameterError(
            f"the sensor of {name} reads at {rate} Hz, which does not divide the plant's {1.0 / step_time:g} Hz; "
            "choose a divisor"
        )
    return stride
