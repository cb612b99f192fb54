"""The road of a course as numbers, its speed, and base classes of courses along a way or over time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod_lab.ground.courses.course import Acting, AnyCondition, Columns, Grid, Start, combine

STEP = 0.5  # Spacing of the points of a way [m]


@dataclass(frozen=True)
class Way:
    """A road on equal steps."""

    curvature: np.ndarray  # curvature, positive to the left [1/m]
    speed: np.ndarray  # speed limit where no bend or stop requires less [m/s]
    lateral_acceleration: np.ndarray  # limit in bends [m/s**2]
    # "road.bank_angle", "road.grade_angle" where the road is not level [rad]
    slopes: Columns = field(default_factory=dict)
    stops: tuple[tuple[float, float], ...] = ()  # (distance [m], duration [s]) of every halt, in order
    step: Annotated[float, "m"] = STEP  # spacing [m]

    @property
    def distance(self) -> np.ndarray:
        """Distance of every point from the start [m]."""
        return np.arange(len(self.curvature)) * self.step


def bump(arc: float, ramps: float) -> np.ndarray:
    """Normalised curvature of a bend, with ends that rise and fall like a cosine; its integral is the arc.

    Args:
        arc: length of the circular arc with the same change of heading [m]
        ramps: share of the length of the two ends [-]
    """
    length = arc / (1.0 - 0.5 * ramps)
    place = (np.arange(max(int(length / STEP), 2)) + 0.5) * STEP / length
    rise = np.minimum(np.minimum(place, 1.0 - place) / (0.5 * ramps), 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(math.pi * np.clip(rise, 0.0, 1.0)))


def across(forward: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Curvature of a line of points, on equal steps [1/m].

    Args:
        forward, left: coordinates of closely spaced points along the line [m]
    """
    heading = np.unwrap(np.arctan2(np.gradient(left), np.gradient(forward)))
    gone = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(forward), np.diff(left)))])
    return np.asarray(np.interp(np.arange(0.0, gone[-1], STEP), gone, np.gradient(heading, gone)))


TICK = 0.02  # Sampling interval of a plan [s]


class Plan(NamedTuple):
    """Distance [m], speed [m/s] and acceleration [m/s**2] over time, one value per tick."""

    distance: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray


@dataclass(frozen=True)
class Pace:
    """Pace of a driver."""

    acceleration: Annotated[float, "m/s**2", POSITIVE] = 1.5
    braking: Annotated[float, "m/s**2", POSITIVE] = 2.0
    smoothing: Annotated[float, "s", NOT_NEGATIVE] = 0.6

    def fastest(self, way: Way, stopping: bool) -> np.ndarray:
        """Maximum speed within all limits, acceleration and braking at every point, with or without halts [m/s]."""
        curved = np.sqrt(way.lateral_acceleration / np.maximum(np.abs(way.curvature), 1e-9))
        limit = np.minimum(way.speed, curved)
        if stopping:
            limit[[round(place / way.step) for place, _ in way.stops]] = 0.0
        return reachable(limit, way.step, self.acceleration, self.braking)

    def plan(self, way: Way) -> Plan:
        speed = self.fastest(way, stopping=True)
        # A lower bound of the mean speed avoids division by zero where two neighbouring points both are stops.
        mean = np.maximum(0.5 * (speed[1:] + speed[:-1]), 1e-3)
        took = np.concatenate([[0.0], way.step / mean])
        waits = np.zeros(len(speed))
        for place, duration in way.stops:
            waits[round(place / way.step)] += duration
        arrival = np.cumsum(took) + np.concatenate([[0.0], np.cumsum(waits)[:-1]])
        time = np.arange(0.0, arrival[-1] + waits[-1], TICK)
        point = np.minimum(np.searchsorted(arrival, time, side="right") - 1, len(speed) - 2)
        moving = np.clip(time - arrival[point] - waits[point], 0.0, took[point + 1])
        push = (speed[point + 1] ** 2 - speed[point] ** 2) / (2.0 * way.step)
        distance = point * way.step + moving * (speed[point] + 0.5 * push * moving)
        smooth = _averaged(distance, max(round(self.smoothing / TICK), 1))
        velocity = np.gradient(smooth, TICK)
        return Plan(smooth, velocity, np.gradient(velocity, TICK))


def reachable(limit: np.ndarray, step: float, acceleration: float, braking: float) -> np.ndarray:
    """Maximum speed below a limit [m/s] with bounded acceleration and braking [m/s**2], on equal steps [m].

    At constant acceleration the squared speed is linear over distance.
    """
    distance = np.arange(len(limit)) * step
    # Adding the permitted change turns the limit of the slope into a running minimum, without a loop.
    squared = np.minimum.accumulate(limit**2 - 2.0 * acceleration * distance) + 2.0 * acceleration * distance
    reach = squared + 2.0 * braking * distance
    squared = np.minimum.accumulate(reach[::-1])[::-1] - 2.0 * braking * distance
    return np.asarray(np.sqrt(np.maximum(squared, 0.0)))


def _averaged(distance: np.ndarray, count: int) -> np.ndarray:
    before, after = count // 2, count - 1 - count // 2
    first, last = distance[1] - distance[0], distance[-1] - distance[-2]
    earlier = distance[0] - first * np.arange(before, 0, -1)
    later = distance[-1] + last * np.arange(1, after + 1)
    return np.convolve(np.concatenate([earlier, distance, later]), np.full(count, 1.0 / count), mode="valid")


TOLERATED_LAG = 3.0  # Dead band of the distance from the plan within which the target speed is not corrected [m]
HASTE = 1.05  # Factor by which a car behind its plan may exceed the speed that the way allows
_CONDITIONS, WAY = 1, 2


def require_rise(first_speed: float, last_speed: float) -> None:
    """Reject a test whose speed [m/s] does not rise."""
    if not first_speed < last_speed:
        raise ParameterError(
            f"the speed of the test would rise from {first_speed:g} to {last_speed:g} m/s; give a last_speed above the "
            "first_speed"
        )


def require_some(what: str, count: int) -> None:
    """Reject a test with a count below one."""
    if count < 1:
        raise ParameterError(f"a test cannot have {count} {what}; give at least 1")


@dataclass(frozen=True)
class Described:
    """Fields of every course."""

    name: str = ""
    description: str = ""
    source: str = ""
    seed: int = 0
    conditions: tuple[AnyCondition, ...] = ()

    def generator(self, *stream: int) -> np.random.Generator:
        """Random generator of one purpose, independent of all others."""
        return np.random.default_rng([self.seed, *stream])

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @cached_property
    def _acting(self) -> list[Acting]:
        return [each.acting(self.generator(_CONDITIONS, place)) for place, each in enumerate(self.conditions)]

    def _with_conditions(self, columns: Columns, time: np.ndarray, distance: np.ndarray) -> Columns:
        for act in self._acting:
            combine(columns, act(time, distance))
        return columns


@dataclass(frozen=True)
class WayCourse(Described):
    """Base class of the courses along a way in a lane; each kind of course defines its `way`.

    The speed is planned over time, so that halts end. A car that falls behind the plan catches up, but exceeds the
    speed that the way allows by no more than `HASTE`.
    """

    pace: Pace = field(default_factory=Pace)

    catching_up: ClassVar[float] = 0.2
    """Correction of the target speed per distance from the plan beyond the dead band [1/s]."""

    @cached_property
    def way(self) -> Way:
        raise NotImplementedError

    @cached_property
    def plan(self) -> Plan:
        return self.pace.plan(self.way)

    @property
    def duration(self) -> float:
        return (len(self.plan.speed) - 1) * TICK

    @property
    def start(self) -> Start:
        return Start(speed=max(float(self.plan.speed[0]), 0.0))

    @cached_property
    def _road(self) -> Grid:
        way = self.way
        allowed = self.pace.fastest(way, stopping=False)
        # Acceleration at a speed that is given over distance: v dv/ds.
        rise = np.gradient(0.5 * allowed**2, way.step)
        return Grid(way.step, {"road.curvature": way.curvature, **way.slopes, "allowed": allowed, "rise": rise})

    @cached_property
    def _ahead(self) -> Grid:
        return Grid(self.way.step, {"demand.curvature_ahead": self.way.curvature})

    @cached_property
    def _planned(self) -> Grid:
        return Grid(TICK, self.plan._asdict())

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        columns, planned = self._road.at(distance), self._planned.at(time)
        columns |= self._ahead.at(distance + speed * ahead)
        allowed, rise = HASTE * columns.pop("allowed"), columns.pop("rise")
        lag = planned["distance"] - distance
        lag -= np.minimum(np.maximum(lag, -TOLERATED_LAG), TOLERATED_LAG)
        wanted = planned["speed"] + self.catching_up * lag
        hurried = wanted > allowed
        columns["demand.speed"] = np.maximum(np.where(hurried, allowed, wanted), 0.0)
        columns["demand.acceleration"] = np.where(hurried, rise, planned["acceleration"])
        return self._with_conditions(columns, time, distance)


@dataclass(frozen=True)
class TimeCourse(Described):
    """Base class of the open-loop courses without a lane; each kind of course defines `speed_at` and `angle_at`."""

    @property
    def duration(self) -> float:
        raise NotImplementedError

    @property
    def start(self) -> Start:
        return Start(float(self.speed_at(np.zeros(1))[0][0]))

    def speed_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        raise NotImplementedError

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        raise NotImplementedError

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        wanted, acceleration = self.speed_at(time)
        columns = {
            "demand.speed": wanted,
            "demand.acceleration": acceleration,
            "demand.steering_wheel_angle": self.angle_at(time),
            "demand.attention": np.zeros(len(time)),
        }
        return self._with_conditions(columns, time, distance)
