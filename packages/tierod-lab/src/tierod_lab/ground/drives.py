"""Drives for studies and tests: recordings of a car on a road, with a course of friction over time and with sensors."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.core.block import tuning
from tierod.core.errors import ParameterError
from tierod.core.recording import Recording
from tierod.core.toml import override
from tierod_lab.ground.cars.eps_car import EpsCar
from tierod_lab.ground.courses import Course
from tierod_lab.ground.courses.conditions import AnyCondition, Restlessness
from tierod_lab.ground.courses.natural import AnyRoad, City, Country, Motorway, NaturalDrive
from tierod_lab.ground.courses.open_loop import LockToLock
from tierod_lab.ground.faults import Course as LevelCourse
from tierod_lab.ground.faults import Fault
from tierod_lab.ground.run import run
from tierod_lab.ground.scatter import Scatter
from tierod_lab.ground.sensors import SensorSet


@dataclass(frozen=True)
class FrictionCourse:
    """Level of dry friction over time: linear between corners, constant before the first and after the last."""

    times: tuple[float, ...]  # instants of the corners [s], not decreasing; two equal ones form a step
    levels: tuple[float, ...]  # friction torque at the column at each corner [N*m], not negative

    def __post_init__(self) -> None:
        if not self.times or len(self.times) != len(self.levels):
            raise ParameterError(
                f"a friction course has {len(self.times)} times and {len(self.levels)} levels; give one level per time"
            )
        if any(later < earlier for earlier, later in zip(self.times, self.times[1:], strict=False)):
            raise ParameterError(f"the times of a friction course run backwards: {self.times}; put them in order")
        if any(first == last for first, last in zip(self.times, self.times[2:], strict=False)):
            raise ParameterError(
                f"a friction course has three corners at one instant: {self.times}; leave the middle out"
            )
        if not all(0.0 <= level < float("inf") for level in self.levels):
            raise ParameterError(f"friction levels must be finite and not negative, not {self.levels} N*m")

    @classmethod
    def constant(cls, level: float) -> FrictionCourse:
        """Course with the same level [N*m] at all times."""
        return cls((0.0,), (level,))

    @classmethod
    def step(cls, before: float, after: float, at: float) -> FrictionCourse:
        return cls((at, at), (before, after))

    def behaviour(self) -> LevelCourse:
        """The course as behaviour of a fault that acts from the start of the run."""
        times = np.array(self.times, dtype=float)
        step = np.flatnonzero(np.diff(times) == 0.0)
        # `LevelCourse` needs ascending times: a step starts a nanosecond early, which is between two samples.
        times[step] -= 1e-9
        return LevelCourse(tuple(times.tolist()), self.levels)


LEVEL = "steering.friction.level"  # Path of the car's parameter that a friction fault changes

CHANNELS = (
    "steering_wheel_angle",
    "steering_wheel_rate",
    "driver_torque",
    "motor_torque",
    "yaw_rate",
    "lateral_acceleration",
    "vehicle_speed",
)
"""Channels that the friction monitors need, as a production car with EPS sends them on its bus."""


def drive(
    vehicle: EpsCar | None = None,
    minutes: float = 13.0,
    friction: FrictionCourse | float | None = None,
    seed: int = 0,
    scatter: bool | Scatter = False,
    sensors: SensorSet | None = None,
    roads: Sequence[AnyRoad] = (City(), Country(), Motorway()),
    conditions: Sequence[AnyCondition] = (Restlessness(),),
) -> Recording:
    """Simulate a drive through city, country and motorway, recorded by production sensors.

    Args:
        vehicle: the car; a mid-size one with a two-track chassis if None
        minutes: duration [min]
        friction: level of dry friction at the column [N*m], constant or over time; that of the car if None
        seed: seed of all random numbers; route, sensors, scatter and faults use separate streams, so that the route of
            a seed does not depend on friction, car or sensors
        sensors: sensors of the car; those of a production car if None

    Returns:
        canonical channels at the rates of their sensors, and true values at 100 Hz in channels prefixed `truth_`;
        `truth_friction_torque` is the friction level that a monitor should estimate, `truth_friction_resistance` the
        signed friction torque
    """
    if not 0.0 < minutes < math.inf:
        raise ParameterError(f"a drive needs a positive duration, not {minutes} min")
    seconds = 60.0 * minutes
    course = NaturalDrive(
        name="natural drive", seed=seed, conditions=tuple(conditions), roads=tuple(roads), time=seconds
    )
    spread = Scatter() if scatter is True else scatter or None
    return _recorded(vehicle or EpsCar(), course, friction, seed, spread, sensors)


def lock_to_lock(
    friction: float,
    hoist: bool,
    vehicle: EpsCar | None = None,
    rate: float = 1.0,
    lock_angle: float = math.radians(570.0),
    seed: int = 0,
    sensors: SensorSet | None = None,
) -> Recording:
    """Simulate the slow turn of the standing car from the middle to the right lock, to the left one, and back.

    Args:
        friction: level of dry friction at the column [N*m]
        hoist: whether the wheels hang free; on the ground the tyres scrub
        vehicle: the car; a mid-size one if None
        rate: maximum rate of the steering wheel [rad/s]; each stroke is half a cosine
        lock_angle: steering wheel angle at the locks [rad]
        sensors: sensors of the car; those of a production car if None

    Returns:
        the same channels as `drive`

    Source: Mohtat et al., Appendix A: 0, -570, +570, 0 degrees.
    """
    if not (rate > 0.0 and lock_angle > 0.0):
        raise ParameterError(f"lock to lock needs a positive rate and angle, not {rate} rad/s and {lock_angle} rad")
    course = LockToLock(name="lock to lock", lock_angle=lock_angle, rate=rate, load=0.0 if hoist else 1.0)
    return _recorded(vehicle or EpsCar(), course, friction, seed, None, sensors, {"hoist": hoist})


def _recorded(
    car: EpsCar,
    course: Course,
    friction: FrictionCourse | float | None,
    seed: int,
    scatter: Scatter | None,
    sensors: SensorSet | None,
    metadata: dict[str, Any] | None = None,
) -> Recording:
    level = dict(tuning(car))[LEVEL] if friction is None else friction
    levels = level if isinstance(level, FrictionCourse) else FrictionCourse.constant(float(level))
    car = with_friction(car, levels.levels[0])
    faults = () if len(set(levels.levels)) == 1 else (Fault(element=LEVEL, behaviour=levels.behaviour()),)
    measured = SensorSet.production().only(CHANNELS) if sensors is None else sensors
    said = {"friction": dataclasses.asdict(levels), "stretches": _stretches(course)} | (metadata or {})
    outcome = run(car, course, None, seed, measured, faults, scatter, said)
    if outcome.diverged_at is not None:
        raise ParameterError(
            f"the drive with seed {seed} diverged after {outcome.diverged_at:.2f} s: the car left the road for good; "
            "check its parameters, or take `run`, which keeps what was recorded until then"
        )
    return outcome.recording


def _stretches(course: Course) -> list[tuple[float, str]] | None:
    """(start [m], kind) of every stretch of a natural drive."""
    if not isinstance(course, NaturalDrive):
        return None
    return [(place, type(kind).__name__.lower()) for place, kind in course.stretches]


def with_friction(car: EpsCar, level: float) -> EpsCar:
    """The car with another level of dry friction at the column [N*m]."""
    changed: EpsCar = override(car, {LEVEL: float(level)})
    return changed
