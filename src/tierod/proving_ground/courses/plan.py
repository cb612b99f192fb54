"""The speed at which a way is driven: as fast as limits allow, planned over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.proving_ground.courses.way import Way

TICK = 0.02
"""Spacing of a plan in time [s]."""


class Plan(NamedTuple):
    """Distance [m], speed [m/s] and acceleration [m/s**2] over time, one value per tick."""

    distance: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray


@dataclass(frozen=True)
class Pace:
    """How a driver takes a way.

    Args:
        acceleration: out of bends and from rest
        braking: before bends and stops
        smoothing: time over which the acceleration builds up
    """

    acceleration: Annotated[float, "m/s**2", POSITIVE] = 1.5
    braking: Annotated[float, "m/s**2", POSITIVE] = 2.0
    smoothing: Annotated[float, "s", NOT_NEGATIVE] = 0.6

    def fastest(self, way: Way, stopping: bool) -> np.ndarray:
        """Speed [m/s] at every point: within all limits, with acceleration and braking, halts left out or not."""
        curved = np.sqrt(way.lateral_acceleration / np.maximum(np.abs(way.curvature), 1e-9))
        limit = np.minimum(way.speed, curved)
        if stopping:
            limit[[round(place / way.step) for place, _ in way.stops]] = 0.0
        return reachable(limit, way.step, self.acceleration, self.braking)

    def plan(self, way: Way) -> Plan:
        """When the car is where, halts included."""
        speed = self.fastest(way, stopping=True)
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
    """The greatest speed [m/s] on equal steps below a limit, with bounded acceleration and braking.

    The squared speed is linear over distance where the acceleration is constant.

    Args:
        limit: of the speed [m/s]
        step: spacing [m]
        acceleration, braking: both positive [m/s**2]
    """
    distance = np.arange(len(limit)) * step
    squared = np.minimum.accumulate(limit**2 - 2.0 * acceleration * distance) + 2.0 * acceleration * distance
    reach = squared + 2.0 * braking * distance
    squared = np.minimum.accumulate(reach[::-1])[::-1] - 2.0 * braking * distance
    return np.sqrt(np.maximum(squared, 0.0))


def _averaged(distance: np.ndarray, count: int) -> np.ndarray:
    """Moving average, going on straight before the beginning and after the end."""
    before, after = count // 2, count - 1 - count // 2
    first, last = distance[1] - distance[0], distance[-1] - distance[-2]
    earlier = distance[0] - first * np.arange(before, 0, -1)
    later = distance[-1] + last * np.arange(1, after + 1)
    return np.convolve(np.concatenate([earlier, distance, later]), np.full(count, 1.0 / count), mode="valid")
