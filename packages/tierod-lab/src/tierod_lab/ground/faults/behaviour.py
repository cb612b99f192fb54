"""Base class of the behaviours of faults, and their seeded random numbers."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import check_ranges
from tierod_lab.ground.sensors import Sensor

_BLOCK = 1024  # Number of random numbers that are drawn together


Drawn = TypeVar("Drawn")


class Chance:
    """Random numbers of one fault in one run.

    A loop at 1 kHz and a recorded channel at 100 Hz get the same spikes, the same lost frames, and the same noise where
    their instants coincide.

    Args:
        start: onset of the fault [s]
        horizon: duration from the onset for which random processes are drawn [s]
        rate: sampling rate of the element [Hz]
    """

    def __init__(self, key: tuple[int, ...], start: float, horizon: float, rate: float = 100.0):
        self.key, self.start, self.horizon, self.rate = key, start, horizon, rate
        self.tick = min(1e-3, 1.0 / rate)
        self._known: dict[tuple[Any, ...], Any] = {}
        self._block = lru_cache(maxsize=8)(self._drawn_block)

    def generator(self, purpose: str, part: int = 0) -> np.random.Generator:
        """Random generator of one purpose, independent of all others."""
        return np.random.default_rng([*self.key, zlib.crc32(purpose.encode()), part])

    def normal(self, since: np.ndarray) -> np.ndarray:
        """White noise of unit standard deviation at times since the onset [s]."""
        return self._at("normal", np.rint(since / self.tick).astype(int))

    def uniform(self, index: np.ndarray) -> np.ndarray:
        """Uniform random numbers between 0 and 1, one for every integer index from 0."""
        return self._at("uniform", index)

    def _at(self, kind: str, index: np.ndarray) -> np.ndarray:
        # Numbers are drawn in blocks by index, so that any order and division of the queries gives the same numbers.
        index = np.maximum(index, 0)
        values = np.empty(len(index))
        for block in np.unique(index // _BLOCK):
            here = index // _BLOCK == block
            values[here] = self._block(kind, int(block))[index[here] % _BLOCK]
        return values

    def _drawn_block(self, kind: str, block: int) -> np.ndarray:
        generator = self.generator(kind, block)
        return generator.standard_normal(_BLOCK) if kind == "normal" else generator.random(_BLOCK)

    def events(self, rate: float) -> tuple[np.ndarray, np.ndarray]:
        """(times since the onset [s], signs) of the events of a Poisson process with this rate [Hz]."""
        return self._remembered(("events", rate), lambda: self._drawn_events(rate))

    def _drawn_events(self, rate: float) -> tuple[np.ndarray, np.ndarray]:
        generator = self.generator("events")
        count = int(generator.poisson(rate * self.horizon))
        return np.sort(generator.uniform(0.0, self.horizon, count)), generator.choice([-1.0, 1.0], count)

    def on(self, since: np.ndarray, mean_on: float, mean_off: float) -> np.ndarray:
        """Whether an intermittent contact is on; it starts on, and the durations are exponentially distributed.

        Args:
            since: times since the onset [s]
            mean_on, mean_off: mean durations [s]
        """
        edges = self._remembered(("on", mean_on, mean_off), lambda: self._drawn_edges(mean_on, mean_off))
        return np.asarray(np.searchsorted(edges, since, side="right") % 2 == 0)

    def _drawn_edges(self, mean_on: float, mean_off: float) -> np.ndarray:
        generator = self.generator("on and off")
        pieces, end = [np.empty(0)], 0.0
        while end < self.horizon:
            count = int(0.6 * (self.horizon - end) / (mean_on + mean_off)) + 8
            spans = generator.standard_exponential((count, 2)) * [mean_on, mean_off]
            pieces.append(end + np.cumsum(spans.reshape(-1)))
            end = float(pieces[-1][-1])
        return np.concatenate(pieces)

    def _remembered(self, key: tuple[Any, ...], draw: Callable[[], Drawn]) -> Drawn:
        if key not in self._known:
            self._known[key] = draw()
        known: Drawn = self._known[key]
        return known


Amount = float | str
"""A number in SI units, or a text with a unit ("0.3 deg/s"), which is converted once the element is known."""

SIGNAL, LOOP, ACTUATOR, PARAMETER, SURROUNDING = "signal", "loop", "actuator", "parameter", "surrounding"
"""Kinds of elements: a recorded signal, a signal that the car's own control units read, an actuator, a parameter of the
car, or a quantity of its surroundings."""


Values = float | np.ndarray


class Change(NamedTuple):
    """Change of a value: held at its last value before the fault where `held` is true, then gain * value + offset."""

    gain: Values = 1.0
    offset: Values = 0.0
    held: bool | np.ndarray = False


def si(amount: Amount) -> float:
    """An amount as a number in SI units."""
    if isinstance(amount, str):
        raise ParameterError(f"'{amount}' has a unit, but its quantity is not known; give the number in SI units")
    return float(amount)


@dataclass(frozen=True)
class Behaviour:
    """Base class of the behaviours: frozen, with units and ranges in the annotations.

    `fits` contains the kinds of elements that can behave so, `main` names the field that is the fault magnitude, and
    `usual_duration` is the default duration [s], None until the end of the run.
    """

    fits: ClassVar[frozenset[str]] = frozenset()
    main: ClassVar[str | None] = None
    usual_duration: ClassVar[float | None] = None

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def core(self) -> Behaviour:
        return self

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        raise NotImplementedError

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        changed = values.copy()
        change = self.change(time[active] - chance.start, chance)
        # Held readings repeat the last one before the hold: its index is carried forward.
        source = np.arange(len(values))
        source[active] = np.where(change.held, 0, source[active])
        kept = values[np.maximum.accumulate(source)] if len(values) else values
        changed[active] = sensor.represented(change.gain * kept[active] + change.offset)
        return time, changed
