"""The way that a course leads: road over distance, and where it stops."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from tierod.proving_ground.courses.course import Columns

STEP = 0.5
"""Spacing of the points of a way [m]."""


@dataclass(frozen=True)
class Way:
    """A road as numbers on equal steps.

    Args:
        curvature: positive to the left [1/m]
        speed: limit where no bend or stop asks for less [m/s]
        lateral_acceleration: limit in bends [m/s**2]
        slopes: "road.bank_angle", "road.grade_angle" where the road is not level [rad]
        stops: (distance [m], duration [s]) of every halt, in order
        step: spacing [m]
    """

    curvature: np.ndarray
    speed: np.ndarray
    lateral_acceleration: np.ndarray
    slopes: Columns = field(default_factory=dict)
    stops: tuple[tuple[float, float], ...] = ()
    step: Annotated[float, "m"] = STEP

    @property
    def distance(self) -> np.ndarray:
        """Of every point from the beginning [m]."""
        return np.arange(len(self.curvature)) * self.step


def bump(arc: float, ramps: float, step: float = STEP) -> np.ndarray:
    """A bend's curvature in shares of its greatest: the ends rise and fall like a cosine; the area is the arc.

    Args:
        arc: length of the circular arc that turns as far [m]
        ramps: share of the length taken by the two ends [-]
        step: spacing [m]
    """
    length = arc / (1.0 - 0.5 * ramps)
    place = (np.arange(max(int(length / step), 2)) + 0.5) * step / length
    rise = np.minimum(np.minimum(place, 1.0 - place) / (0.5 * ramps), 1.0)
    return 0.5 - 0.5 * np.cos(math.pi * np.clip(rise, 0.0, 1.0))


def across(forward: np.ndarray, left: np.ndarray, step: float = STEP) -> np.ndarray:
    """Curvature [1/m] on equal steps of a line that is given as points.

    Args:
        forward, left: coordinates of many points along the line [m]
        step: spacing of the result [m]
    """
    heading = np.unwrap(np.arctan2(np.gradient(left), np.gradient(forward)))
    gone = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(forward), np.diff(left)))])
    return np.interp(np.arange(0.0, gone[-1], step), gone, np.gradient(heading, gone))


def drawn(curvature: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates [m] and heading [rad] of every point of a line of known curvature [1/m], from the origin ahead."""
    heading = np.concatenate([[0.0], np.cumsum(0.5 * (curvature[1:] + curvature[:-1]) * step)])
    middle = 0.5 * (heading[1:] + heading[:-1])
    forward = np.concatenate([[0.0], np.cumsum(np.cos(middle) * step)])
    left = np.concatenate([[0.0], np.cumsum(np.sin(middle) * step)])
    return forward, left, heading
