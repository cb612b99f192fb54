"""Hands that come to the wheel of a column bench and leave it, while its motor rests, keeps a lane or sweeps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.proving_ground.courses.base import Described
from tierod.proving_ground.courses.chance import Repeated, smooth_noise
from tierod.proving_ground.courses.conditions import Acting, Tremor
from tierod.proving_ground.courses.course import Columns, Start

STRETCH = (20.0, 60.0)
"""Shortest and longest time for which the motor does the same [s]."""
_EPISODES, _TORQUE, _STRETCHES, _LANE = 10, 11, 12, 13


@dataclass(frozen=True)
class BenchHands(Described):
    """Hands on and off at random times, light and firm, with a torque that wanders; the motor of the bench works on.

    The motor does one of three things in turn: nothing, small wandering torques as of a lane keeping aid, sines.

    Args:
        time: of the whole
        shortest, longest: time for which hands stay on, or off; every ratio of times is as likely as any other
        lightest, firmest: standard deviation of the hands' torque of one hold, likewise
        quickest, slowest: between two values of that torque
        tremor: standard deviation of their trembling, near 9 Hz
        ramp: within which a grip takes hold, and lets go
        lane_torque: standard deviation of the motor's small torques, at its shaft
        sweep_torque: greatest amplitude of its sines, 0.2 to 3 Hz
    """

    time: Annotated[float, "s", POSITIVE] = 600.0
    shortest: Annotated[float, "s", POSITIVE] = 3.0
    longest: Annotated[float, "s", POSITIVE] = 20.0
    lightest: Annotated[float, "N*m", NOT_NEGATIVE] = 0.1
    firmest: Annotated[float, "N*m", NOT_NEGATIVE] = 0.5
    quickest: Annotated[float, "s", POSITIVE] = 0.05
    slowest: Annotated[float, "s", POSITIVE] = 0.4
    tremor: Annotated[float, "N*m", NOT_NEGATIVE] = 0.03
    ramp: Annotated[float, "s", POSITIVE] = 0.03
    lane_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.2
    sweep_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.6

    def __post_init__(self):
        for low, high in (("shortest", "longest"), ("lightest", "firmest"), ("quickest", "slowest")):
            if not getattr(self, low) <= getattr(self, high):
                raise ParameterError(
                    f"{low} is {getattr(self, low):g} and {high} {getattr(self, high):g}; the first must not be greater"
                )
        if not 2.0 * self.ramp <= self.shortest:
            raise ParameterError(
                f"hands that stay {self.shortest:g} s cannot take {self.ramp:g} s each to come and to go; "
                "give at least twice the ramp"
            )

    @property
    def duration(self) -> float:
        """Of the whole [s]."""
        return self.time

    @property
    def start(self) -> Start:
        """At rest."""
        return Start()

    @cached_property
    def switches(self) -> np.ndarray:
        """When hands come (even places) and leave (odd places) [s]; off at first."""
        return np.cumsum(_drawn(self.generator(_EPISODES), self.shortest, self.longest, self.time))

    @cached_property
    def firmness(self) -> np.ndarray:
        """Standard deviation of the torque [N*m] and grip of every hold, (n, 2)."""
        draw, count = self.generator(_TORQUE), len(self.switches) // 2 + 1
        torque = self.lightest * (self.firmest / max(self.lightest, 1e-12)) ** draw.random(count)
        return np.column_stack([torque, draw.uniform(0.5, 1.0, count)])

    @cached_property
    def _hand_torque(self) -> Repeated:
        step = 0.2 * self.quickest
        return Repeated(smooth_noise(self.generator(_TORQUE, 1), self.quickest, self.slowest, step), step)

    @cached_property
    def _trembling(self) -> Acting:
        return Tremor(deviation=self.tremor).acting(self.generator(_TORQUE, 2))

    @cached_property
    def _lane_torque(self) -> Repeated:
        return Repeated(smooth_noise(self.generator(_LANE), 0.3, 1.5, 0.05), 0.05)

    @cached_property
    def _stretches(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Start of every stretch of the motor [s], what it does, and torque and frequency of its sines."""
        draw = self.generator(_STRETCHES)
        starts = np.concatenate([[0.0], np.cumsum(_drawn(draw, *STRETCH, self.time))])
        kind = draw.permuted(np.tile([0, 1, 2], (len(starts) // 3 + 1, 1)), axis=1).ravel()[: len(starts)]
        shape = np.column_stack([draw.uniform(0.3, 1.0, len(starts)), 0.2 * 15.0 ** draw.random(len(starts))])
        return starts, kind, shape

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants, see `Course.columns`."""
        present, hold = self.held(time)
        torque, grip = self.firmness[hold].T
        trembling = self._trembling(time, distance)["demand.hand_torque"]
        columns = {
            "motor_torque": self._motor(time),
            "grip": present * grip,
            "hand_torque": present * (torque * self._hand_torque.at(time) + trembling),
        }
        return self._with_conditions(columns, time, distance)

    def held(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Share to which hands are on the wheel, 0 to 1, and the number of the hold, at some instants [s]."""
        place = np.searchsorted(self.switches, time, side="right")
        since = time - self.switches[np.maximum(place - 1, 0)]
        faded = np.clip(since / self.ramp, 0.0, 1.0)
        faded = faded * faded * (3.0 - 2.0 * faded)
        present = np.where(place % 2 == 1, faded, np.where(place == 0, 0.0, 1.0 - faded))
        return present, np.maximum(place - 1, 0) // 2

    def _motor(self, time: np.ndarray) -> np.ndarray:
        starts, kind, shape = self._stretches
        place = np.searchsorted(starts, time, side="right") - 1
        amplitude, frequency = shape[place].T
        since = time - starts[place]
        fade = np.clip(since, 0.0, 1.0)
        sine = self.sweep_torque * amplitude * np.sin(2.0 * math.pi * frequency * since)
        return fade * np.choose(kind[place], [np.zeros(len(time)), self.lane_torque * self._lane_torque.at(time), sine])


def _drawn(generator: np.random.Generator, shortest: float, longest: float, time: float) -> np.ndarray:
    """Times [s] between two bounds, every ratio as likely as any other, until they fill the whole."""
    count = int(time / shortest) + 2
    drawn = shortest * (longest / shortest) ** generator.random(count)
    return drawn[: int(np.searchsorted(np.cumsum(drawn), time)) + 1]
