"""The road of a course as numbers, and the speed over time with which it is driven, as fast as its limits allow."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod_lab.ground.courses.course import Columns

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


def bump(arc: float, ramps: float, step: float = STEP) -> np.ndarray:
    """Normalised curvature of a bend, with ends that rise and fall like a cosine; its integral is the arc.

    Args:
        arc: length of the circular arc with the same change of heading [m]
        ramps: share of the length of the two ends [-]
        step: spacing [m]
    """
    length = arc / (1.0 - 0.5 * ramps)
    place = (np.arange(max(int(length / step), 2)) + 0.5) * step / length
    rise = np.minimum(np.minimum(place, 1.0 - place) / (0.5 * ramps), 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(math.pi * np.clip(rise, 0.0, 1.0)))


def across(forward: np.ndarray, left: np.ndarray, step: float = STEP) -> np.ndarray:
    """Curvature of a line of points, on equal steps [1/m].

    Args:
        forward, left: coordinates of closely spaced points along the line [m]
        step: spacing of the result [m]
    """
    heading = np.unwrap(np.arctan2(np.gradient(left), np.gradient(forward)))
    gone = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(forward), np.diff(left)))])
    return np.asarray(np.interp(np.arange(0.0, gone[-1], step), gone, np.gradient(heading, gone)))


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
    """Maximum speed below a limit with bounded acceleration and braking, on equal steps [m/s].

    At constant acceleration the squared speed is linear over distance.

    Args:
        limit: speed limit [m/s]
        step: spacing [m]
        acceleration, braking: limits, both positive [m/s**2]
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
