"""Relations between redundant signals: their ratios decide units, their correlations decide signs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tierod.core.recording import Aligned, Recording
from tierod.methods.detectors.reversing import reversing_of_any_signs
from tierod.methods.relations import RELATIONS, STRONG, compared, related

RATE, SMOOTHING, LONGEST = 20.0, 20, 3600.0  # rate [Hz], samples of the moving average, length that is compared [s]
STANDING = 0.1  # speed of all wheels below which a car stands [m/s]
SECONDS = 5.0  # shortest driving time that two signals must have in common [s]

# Relations that decide units; of the fourth and fifth only the first one that is observable, since they are alike.
PROPOSED = ("turn", "wheels", "steering", "braking", "car", "bend")


class Seen(NamedTuple):
    """A relation between signals that the recording shows clearly."""

    words: str  # what is compared
    ratio: float  # magnitude of the second quantity over that of the first, as recorded; 1 with the right units
    powers: Mapping[str, int]  # by signal, exponent with which its unit enters the ratio
    spread: float  # standard deviation of the ratio's logarithm between cars


@dataclass
class Motion:
    """The matched columns of a recording as recorded, on one grid and smoothed."""

    columns: dict[str, np.ndarray]  # values by signal, (n,) each
    cache: dict[float, list[Seen]] = field(default_factory=dict)

    @classmethod
    def of(cls, raw: Recording) -> Motion:
        """Motion of a recording whose channels have the names of signals and the values of the file."""
        return cls._smoothed(_aligned(raw).columns)

    @classmethod
    def forward(cls, raw: Recording, factors: Mapping[str, float]) -> Motion:
        """The same in SI units, without the samples at which the car reverses, which mirrors turns.

        The yaw rate is that above its reading while the car stands.
        """
        aligned = _aligned(raw)
        columns = {name: factors.get(name, 1.0) * column for name, column in aligned.columns.items()}
        reverses = reversing_of_any_signs(aligned.time, columns, RATE)
        speeds = [np.abs(each) for name, each in columns.items() if name == "vehicle_speed" or "wheel_speed" in name]
        rests = np.all([each < STANDING for each in speeds], axis=0) if speeds else np.zeros(len(reverses), dtype=bool)
        if "yaw_rate" in columns and np.count_nonzero(rests) > SECONDS * RATE:
            columns["yaw_rate"] = columns["yaw_rate"] - np.nanmedian(columns["yaw_rate"][rests])
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

    def relations(self, factor: float) -> list[Seen]:
        """Every relation whose signals correlate; `factor` is the speed of one unit of the basis [m/s]."""
        if factor not in self.cache:
            self.cache[factor] = list(self._relations(factor))
        return self.cache[factor]

    def _relations(self, factor: float) -> Iterator[Seen]:
        speed, basis = self.speed(), self.basis
        if speed is None or basis is None:
            return
        signals = {**self.columns, "vehicle_speed": factor * speed}
        if self.axle and (pair := self.pair(self.axle)):
            signals |= {"wheel_speed_left": factor * pair[0], "wheel_speed_right": factor * pair[1]}
        steered = False
        for key in PROPOSED:
            found = None if steered and key == "bend" else related(key, signals, RATE, SECONDS)
            if found is None:
                continue
            steered = steered or key == "car"
            relation = RELATIONS[key]
            if abs(found.correlation()) >= STRONG:
                powers = {basis if name == "vehicle_speed" else name: power for name, power in relation.powers.items()}
                raw = found.ratio() / factor ** powers.get(basis, 0)
                yield Seen(" over ".join(relation.words), raw, powers, relation.spread)


def _aligned(raw: Recording) -> Aligned:
    """The first hour of all columns on one grid; empty without columns."""
    if not raw.channels:
        return Aligned(np.zeros(0), np.zeros((0, 0)), ())
    return raw.slice(stop=raw.span[0] + LONGEST).align(raw.names, RATE, maximum_age=0.25)


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    found = compared(a, b, SECONDS * RATE)
    return 0.0 if found is None else found.correlation()
