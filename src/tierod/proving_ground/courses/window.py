"""When or where a condition of a course holds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE


@dataclass(frozen=True)
class During:
    """From one instant to another, fading in and out smoothly; always, unless told otherwise.

    Args:
        start, end: of the whole, fading included
        ramp: how long it takes to fade in, and out
        every: period after which it comes again
    """

    start: Annotated[float, "s", ANY] = -math.inf
    end: Annotated[float, "s", ANY] = math.inf
    ramp: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    every: Annotated[float, "s", POSITIVE] = math.inf

    def __post_init__(self):
        _in_order(self.start, self.end, "s")

    def share(self, time: np.ndarray, distance: np.ndarray) -> np.ndarray | float | None:
        """How much of the condition holds, 0 to 1; one number where it is always so, None where it does not hold."""
        return _share(time, self.start, self.end, self.ramp, self.every)


@dataclass(frozen=True)
class Along:
    """From one place of the path to another, fading in and out smoothly.

    Args:
        start, end: of the whole, fading included
        ramp: over which distance it fades in, and out
        every: length after which it comes again
    """

    start: Annotated[float, "m", ANY] = -math.inf
    end: Annotated[float, "m", ANY] = math.inf
    ramp: Annotated[float, "m", NOT_NEGATIVE] = 0.0
    every: Annotated[float, "m", POSITIVE] = math.inf

    def __post_init__(self):
        _in_order(self.start, self.end, "m")

    def share(self, time: np.ndarray, distance: np.ndarray) -> np.ndarray | float | None:
        """How much of the condition holds, 0 to 1; one number where it is always so, None where it does not hold."""
        return _share(distance, self.start, self.end, self.ramp, self.every)


Window = During | Along


def _in_order(start: float, end: float, unit: str) -> None:
    if not start < end:
        raise ParameterError(f"a window from {start:g} to {end:g} {unit} is empty; let its end come after its start")


def _share(place: np.ndarray, start: float, end: float, ramp: float, every: float) -> np.ndarray | float | None:
    if every < math.inf:
        first = start if start > -math.inf else 0.0
        place = np.where(place < start, place, first + np.mod(place - first, every))
    elif place[-1] < start or place[0] > end:
        return None
    elif start == -math.inf and end == math.inf:
        return 1.0
    if ramp == 0.0:
        return ((place >= start) & (place < end)).astype(float)
    inside = np.minimum(np.minimum(place - start, end - place) / ramp, 1.0)
    inside = np.maximum(inside, 0.0)
    return inside * inside * (3.0 - 2.0 * inside)
