"""The friction fault: the level of the column's dry friction as a function of time, applied from outside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.core.errors import ParameterError
from tierod.proving_ground.faults import Course


@dataclass(frozen=True)
class FrictionCourse:
    """Level of dry friction over time: straight between corners, constant before the first and after the last.

    Args:
        times: instants of the corners [s], not decreasing; two equal ones make a step
        levels: friction torque at the column at the corners [N*m], not negative
    """

    times: tuple[float, ...]
    levels: tuple[float, ...]

    def __post_init__(self):
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
        """The same level [N*m] all the time."""
        return cls((0.0,), (level,))

    @classmethod
    def step(cls, before: float, after: float, at: float) -> FrictionCourse:
        """A jump from one level [N*m] to another at an instant [s]."""
        return cls((at, at), (before, after))

    @classmethod
    def ramp(cls, before: float, after: float, start: float, stop: float) -> FrictionCourse:
        """A straight rise from one level [N*m] to another between two instants [s]."""
        return cls((start, stop), (before, after))

    def behaviour(self) -> Course:
        """The course as the behaviour of a fault that acts from the beginning on; a step takes no sample's time."""
        times = np.array(self.times)
        step = np.flatnonzero(np.diff(times) == 0.0)
        times[step] -= 1e-9
        return Course(tuple(times.tolist()), self.levels)
