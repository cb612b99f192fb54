"""Relations between redundant signals: their ratios decide units, their correlations decide signs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tierod.core.recording import Aligned, Recording
from tierod.methods.detectors.reversing import STEERING_RATIO, WHEELBASE, reversing_of_any_signs

# Rate of the comparison [Hz], samples of the moving average before it, and length that is compared [s]
RATE, SMOOTHING, LONGEST = 20.0, 20, 3600.0

SECONDS = 5.0  # Shortest driving time that two signals must have in common [s]
STRONG = 0.6  # Smallest magnitude of the correlation coefficient at which two signals count as related [-]

# Further parameters of a usual car, good enough to separate degrees from radians: [rad s^2/m], [m]
UNDERSTEER, TRACK = 0.0025, 1.5


class Relation(NamedTuple):
    """Physical relation between two signals of a car."""

    words: str  # what is compared
    correlation: float  # correlation coefficient of both, from -1 to 1
    ratio: float  # magnitude of the first over that of the second, as recorded; 1 with the right units
    powers: Mapping[str, int]  # by signal, exponent with which its unit enters the ratio
    spread: float  # standard deviation of the ratio's logarithm between cars


@dataclass
class Motion:
    """The matched columns of a recording as recorded, on one grid and smoothed."""

    columns: dict[str, np.ndarray]  # values by signal, (n,) each
    cache: dict[float, list[Relation]] = field(default_factory=dict)

    @classmethod
    def of(cls, raw: Recording) -> Motion:
        """Motion of a recording whose channels have the names of signals and the values of the file."""
        return cls._smoothed(_aligned(raw).columns)

    @classmethod
    def forward(cls, raw: Recording, factors: Mapping[str, float]) -> Motion:
        """The same in SI units, without the samples at which the car reverses, which mirrors turns."""
        aligned = _aligned(raw)
        columns = {name: factors.get(name, 1.0) * column for name, column in aligned.columns.items()}
        reverses = reversing_of_any_signs(aligned.time, columns, RATE)
        return cls._smoothed({name: np.where(reverses, np.nan, column) for name, column in columns.items()})

    @classmethod
    def _smoothed(cls, columns: Mapping[str, np.ndarray]) -> Motion:
        kernel = np.full(SMOOTHING, 1.0 / SMOOTHING)
        long = all(len(column) > SMOOTHING for column in columns.values())
        return cls({name: np.convolve(column, kernel, "valid") for name, column in columns.items()} if long else {})

    def pair(self, end: str) -> tuple[np.ndarray, np.ndarray] | None:
        """Left and right wheel speed of an axle, where both are recorded."""
        names = [f"wheel_speed_{end}_{side}" for side in ("left", "right")]
        return (self.columns[names[0]], self.columns[names[1]]) if all(n in self.columns for n in names) else None

    @property
    def axle(self) -> str | None:
        """The axle whose wheel speeds are used for speed and turn: the rear one where it is recorded."""
        return next((end for end in ("rear", "front") if self.pair(end) is not None), None)

    @property
    def basis(self) -> str | None:
        """The signal that represents the speed."""
        if self.axle is not None:
            return f"wheel_speed_{self.axle}_left"
        return "vehicle_speed" if "vehicle_speed" in self.columns else None

    def speed(self) -> np.ndarray | None:
        """Speed as recorded, in the unit of the basis."""
        pair = self.pair(self.axle) if self.axle else None
        if pair is not None:
            return np.asarray(0.5 * (pair[0] + pair[1]))
        return self.columns.get("vehicle_speed")

    def turn(self) -> np.ndarray | None:
        """Right less left wheel speed, positive in a left turn while the car goes forwards."""
        pair = self.pair(self.axle) if self.axle else None
        return None if pair is None else np.asarray(pair[1] - pair[0])

    def relations(self, factor: float) -> list[Relation]:
        """Every relation whose signals are recorded."""
        if factor not in self.cache:
            self.cache[factor] = list(self._relations(factor))
        return self.cache[factor]

    def _relations(self, factor: float) -> list[Relation]:
        speed, basis, found = self.speed(), self.basis, []
        yaw, lateral, angle, forward = (
            self.columns.get(name)
            for name in ("yaw_rate", "lateral_acceleration", "steering_wheel_angle", "longitudinal_acceleration")
        )

        def add(words: str, a: np.ndarray, b: np.ndarray, powers: dict[str, int], spread: float) -> None:
            correlation, ratio = compared(a, b)
            found.append(Relation(words, correlation, ratio, powers, spread))

        if speed is None or basis is None:
            return []
        if yaw is not None and lateral is not None:
            powers = {"lateral_acceleration": 1, basis: -1, "yaw_rate": -1}
            add("lateral acceleration over speed times yaw rate", lateral, speed * yaw, powers, 0.35)
        turn = self.turn()
        if turn is not None and yaw is not None:
            powers = {basis: 1, "yaw_rate": -1}
            add("difference of the wheel speeds over track times yaw rate", turn, TRACK * yaw, powers, 0.35)
        if yaw is not None and angle is not None:
            bend = WHEELBASE + UNDERSTEER * (factor * speed) ** 2
            powers = {"yaw_rate": 1, basis: -1, "steering_wheel_angle": -1}
            words = "yaw rate over that of a usual car at this speed and steering angle"
            add(words, yaw, speed * angle * STEERING_RATIO / bend, powers, 0.4)
        elif angle is not None and lateral is not None:
            bend = WHEELBASE + UNDERSTEER * (factor * speed) ** 2
            powers = {"lateral_acceleration": 1, basis: -2, "steering_wheel_angle": -1}
            words = "lateral acceleration over that of a usual car at this speed and steering angle"
            add(words, lateral, speed**2 * angle * STEERING_RATIO / bend, powers, 0.45)
        turning = self.columns.get("steering_wheel_rate")
        if turning is not None and angle is not None:
            powers = {"steering_wheel_rate": 1, "steering_wheel_angle": -1}
            add("steering wheel rate over change of its angle", turning, np.gradient(angle) * RATE, powers, 0.25)
        if forward is not None:
            powers = {"longitudinal_acceleration": 1, basis: -1}
            add("longitudinal acceleration over change of speed", forward, np.gradient(speed) * RATE, powers, 0.35)
        return found


def _aligned(raw: Recording) -> Aligned:
    """The first hour of all columns on one grid; empty without columns."""
    if not raw.channels:
        return Aligned(np.zeros(0), np.zeros((0, 0)), ())
    return raw.slice(stop=raw.span[0] + LONGEST).align(raw.names, RATE, maximum_age=0.25)


def compared(a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Correlation coefficient of two signals, and the magnitude of the first over the second; (0, NaN) if unknown."""
    good = np.isfinite(a) & np.isfinite(b)
    if np.count_nonzero(good) < SECONDS * RATE:
        return 0.0, math.nan
    # Without their means, so that the offset of a sensor has no effect.
    a, b = a[good] - np.mean(a[good]), b[good] - np.mean(b[good])
    of_a, of_b = float(a @ a), float(b @ b)
    if not (of_a > 0.0 and of_b > 0.0):
        return 0.0, math.nan
    return float(a @ b) / math.sqrt(of_a * of_b), math.sqrt(of_a / of_b)
