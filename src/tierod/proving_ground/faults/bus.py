"""How a bus fails a signal: late, with a wrong bit, or not at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import POSITIVE, Range
from tierod.core.toml_builder import SIGNAL_UNIT
from tierod.proving_ground.faults.behaviour import LOOP, SIGNAL, Amount, Behaviour, Change, si
from tierod.proving_ground.faults.chance import Chance
from tierod.proving_ground.sensors import Sensor


@dataclass(frozen=True)
class Delay(Behaviour):
    """Readings come late, while their stamps do not tell. Recorded signals only: a loop has no memory to delay by."""

    time: Annotated[float, "s", POSITIVE]
    fits: ClassVar[frozenset[str]] = frozenset({SIGNAL})
    main: ClassVar[str | None] = "time"

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        """The latest reading that is old enough; the first one where none is."""
        old = np.searchsorted(time, time - self.time + 1e-9, side="right") - 1
        return time, np.where(active, values[np.maximum(old, 0)], values)


@dataclass(frozen=True)
class BitFlip(Behaviour):
    """One bit of the raw number on the bus is the wrong one. Recorded signals only: what it adds depends on the value.

    Args:
        bit: which, from 0 for the least significant
        bits: of the number, which is signed (two's complement)
        quantum: value of the last bit; that of the sensor if None
    """

    bit: Annotated[int, "", Range(0, 62)]
    bits: Annotated[int, "", Range(2, 63)] = 16
    quantum: Annotated[Amount, SIGNAL_UNIT, POSITIVE] | None = None
    fits: ClassVar[frozenset[str]] = frozenset({SIGNAL})
    main: ClassVar[str | None] = "bit"

    def __post_init__(self):
        super().__post_init__()
        if self.bit >= self.bits:
            raise ParameterError(f"bit {self.bit} does not exist among {self.bits} bits; the last is {self.bits - 1}")

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        """The readings with the bit turned over."""
        quantum = sensor.quantum if self.quantum is None else si(self.quantum)
        if quantum == 0.0:
            raise ParameterError("a bit flip needs the value of the last bit: the sensor has no quantum, so give one")
        raw = np.round(values[active] / quantum).astype(np.int64) & ((1 << self.bits) - 1)
        raw ^= 1 << self.bit
        negative = raw >> (self.bits - 1) == 1
        changed = values.copy()
        changed[active] = quantum * (raw - np.where(negative, 1 << self.bits, 0))
        return time, changed


@dataclass(frozen=True)
class DropOut(Behaviour):
    """Frames do not come. A loop goes on with what came last; so does a recording if `repeat` is set.

    Args:
        share: of the frames that do not come, at random
        repeat: whether the bus repeats the last value instead
    """

    share: Annotated[float, "", Range(0.0, 1.0, open_low=True)] = 1.0
    repeat: bool = False
    fits: ClassVar[frozenset[str]] = frozenset({SIGNAL, LOOP})
    main: ClassVar[str | None] = "share"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """Held while frames are lost."""
        # A step between two frames goes by the one before it.
        frame = np.floor((since + chance.start) * chance.rate + 1e-6) / chance.rate
        return Change(held=self._lost(frame, chance))

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        """The frames that come."""
        if self.repeat:
            return super().on_channel(time, values, active, sensor, chance)
        lost = active.copy()
        lost[active] = self._lost(time[active], chance)
        return time[~lost], values[~lost]

    def _lost(self, time: np.ndarray, chance: Chance) -> np.ndarray:
        """Whether the latest frame was lost; stamps may jitter by nearly half of the time between two."""
        return chance.uniform(np.floor(time * chance.rate + 0.5).astype(int)) < self.share
