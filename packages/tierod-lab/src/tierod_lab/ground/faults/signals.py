"""Faults of signals: in a recording, in a control loop of the car, and on the bus."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range
from tierod.core.toml import SIGNAL_UNIT
from tierod_lab.ground.faults.behaviour import (
    ACTUATOR,
    LOOP,
    PARAMETER,
    SIGNAL,
    SURROUNDING,
    Amount,
    Behaviour,
    Chance,
    Change,
    si,
)
from tierod_lab.ground.sensors import Sensor

_VALUES = frozenset({SIGNAL, LOOP, ACTUATOR})
_ALL = _VALUES | {PARAMETER, SURROUNDING}


@dataclass(frozen=True)
class TotalLoss(Behaviour):
    """The signal is zero."""

    fits: ClassVar[frozenset[str]] = _VALUES

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=0.0)


@dataclass(frozen=True)
class Stuck(Behaviour):
    """The signal keeps its last value or a given value."""

    value: Annotated[Amount, SIGNAL_UNIT] | None = None  # constant value; the last one before the fault if None
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "value"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(held=True) if self.value is None else Change(gain=0.0, offset=si(self.value))


@dataclass(frozen=True)
class Offset(Behaviour):
    """A constant of either sign is added."""

    size: Annotated[Amount, SIGNAL_UNIT]
    fits: ClassVar[frozenset[str]] = _ALL
    main: ClassVar[str | None] = "size"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(offset=si(self.size))


@dataclass(frozen=True)
class Gain(Behaviour):
    """The signal is multiplied by a factor: 1 is fault-free, -1 inverts the sign."""

    gain: Annotated[float, ""]
    fits: ClassVar[frozenset[str]] = _ALL
    main: ClassVar[str | None] = "gain"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=self.gain)


@dataclass(frozen=True)
class Drift(Behaviour):
    """An offset that grows from zero is added."""

    rate: Annotated[Amount, "{signal}/s"]
    limit: Annotated[Amount, SIGNAL_UNIT] | None = None  # magnitude at which the growth stops; never if None
    fits: ClassVar[frozenset[str]] = _ALL
    main: ClassVar[str | None] = "rate"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        offset = si(self.rate) * since
        if self.limit is None:
            return Change(offset=offset)
        limit = abs(si(self.limit))
        return Change(offset=np.clip(offset, -limit, limit))


@dataclass(frozen=True)
class Outlier(Behaviour):
    """The signal is far off for one second: a multiple of itself, or a given value.

    Source: Li, Frey, Gauterin, Sensors 23 (2023) 887, section 5: "a large outlier in the sensor data over a very short
    time such as one second".
    """

    factor: Annotated[float, ""] = 3.0
    value: Annotated[Amount, SIGNAL_UNIT] | None = None  # value that replaces the signal, if not None
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "factor"
    usual_duration: ClassVar[float | None] = 1.0

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=self.factor) if self.value is None else Change(gain=0.0, offset=si(self.value))


@dataclass(frozen=True)
class Spikes(Behaviour):
    """Short pulses of either sign are added at random instants."""

    size: Annotated[Amount, SIGNAL_UNIT]
    rate: Annotated[float, "Hz", POSITIVE] = 1.0
    # duration of each pulse; a channel with longer sampling intervals misses some
    width: Annotated[float, "s", POSITIVE] = 0.01
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "size"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        times, signs = chance.events(self.rate)
        if not len(times):
            return Change()
        latest = np.searchsorted(times, since, side="right") - 1
        inside = (latest >= 0) & (since - times[latest] < self.width)
        return Change(offset=np.where(inside, si(self.size) * signs[latest], 0.0))


@dataclass(frozen=True)
class Noise(Behaviour):
    """White noise is added: a new value every millisecond, or with every reading of a faster channel."""

    deviation: Annotated[Amount, SIGNAL_UNIT, NOT_NEGATIVE]
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "deviation"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(offset=si(self.deviation) * chance.normal(since))


@dataclass(frozen=True)
class Delay(Behaviour):
    """Readings arrive late with unchanged time stamps. Recorded signals only: a control loop has no buffer."""

    time: Annotated[float, "s", POSITIVE]
    fits: ClassVar[frozenset[str]] = frozenset({SIGNAL})
    main: ClassVar[str | None] = "time"

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        old = np.searchsorted(time, time - self.time + 1e-9, side="right") - 1
        return time, np.where(active, values[np.maximum(old, 0)], values)


@dataclass(frozen=True)
class BitFlip(Behaviour):
    """One bit of the raw number on the bus is inverted. Recorded signals only: the error depends on the value."""

    bit: Annotated[int, "", Range(0, 62)]
    bits: Annotated[int, "", Range(2, 63)] = 16
    # value of the least significant bit; that of the sensor if None
    quantum: Annotated[Amount, SIGNAL_UNIT, POSITIVE] | None = None
    fits: ClassVar[frozenset[str]] = frozenset({SIGNAL})
    main: ClassVar[str | None] = "bit"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.bit >= self.bits:
            raise ParameterError(f"bit {self.bit} does not exist among {self.bits} bits; the last is {self.bits - 1}")

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
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
    """Frames are lost. A control loop continues with the last value; so does a recording if `repeat` is set."""

    share: Annotated[float, "", Range(0.0, 1.0, open_low=True)] = 1.0
    repeat: bool = False
    fits: ClassVar[frozenset[str]] = frozenset({SIGNAL, LOOP})
    main: ClassVar[str | None] = "share"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        # A control step between two frames uses the earlier one.
        frame = np.floor((since + chance.start) * chance.rate + 1e-6) / chance.rate
        return Change(held=self._lost(frame, chance))

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        if self.repeat:
            return super().on_channel(time, values, active, sensor, chance)
        lost = active.copy()
        lost[active] = self._lost(time[active], chance)
        return time[~lost], values[~lost]

    def _lost(self, time: np.ndarray, chance: Chance) -> np.ndarray:
        return chance.uniform(np.floor(time * chance.rate + 0.5).astype(int)) < self.share
