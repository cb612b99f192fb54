"""Behaviours of faulty signals, actuators, parameters and surroundings, with their seeded random numbers."""

from __future__ import annotations

import dataclasses
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, ClassVar, NamedTuple, TypeVar, get_args

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range, check_ranges
from tierod.core.toml import SIGNAL_UNIT, kind_name
from tierod.physics.lag import share_reached
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


_PARAMETERS = frozenset({PARAMETER, SURROUNDING})


@dataclass(frozen=True)
class TorqueLoss(Behaviour):
    """An actuator delivers less torque than requested."""

    # share of the torque that is lost; 1 is all of it
    share: Annotated[float, "", Range(0.0, 1.0, open_low=True)] = 1.0
    fits: ClassVar[frozenset[str]] = frozenset({ACTUATOR})
    main: ClassVar[str | None] = "share"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=1.0 - self.share)


@dataclass(frozen=True)
class Sluggish(Behaviour):
    """An actuator follows its request with another time constant, which replaces that parameter of the car."""

    time_constant: Annotated[float, "s", POSITIVE]
    fits: ClassVar[frozenset[str]] = frozenset({ACTUATOR})
    main: ClassVar[str | None] = "time_constant"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=0.0, offset=self.time_constant)


@dataclass(frozen=True)
class Step(Behaviour):
    """A parameter jumps to another value."""

    to: Annotated[Amount, SIGNAL_UNIT]
    fits: ClassVar[frozenset[str]] = _PARAMETERS
    main: ClassVar[str | None] = "to"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=0.0, offset=si(self.to))


@dataclass(frozen=True)
class Ramp(Behaviour):
    """A parameter changes linearly to another value and stays there."""

    to: Annotated[Amount, SIGNAL_UNIT]
    over: Annotated[float, "s", POSITIVE]
    fits: ClassVar[frozenset[str]] = _PARAMETERS
    main: ClassVar[str | None] = "to"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        share = np.clip(since / self.over, 0.0, 1.0)
        return Change(gain=1.0 - share, offset=share * si(self.to))


@dataclass(frozen=True)
class Scale(Behaviour):
    """A parameter is multiplied by a factor, at once or along a ramp."""

    factor: Annotated[float, ""]
    over: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    fits: ClassVar[frozenset[str]] = _PARAMETERS
    main: ClassVar[str | None] = "factor"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        share = np.clip(since / self.over, 0.0, 1.0) if self.over > 0.0 else 1.0
        return Change(gain=1.0 + share * (self.factor - 1.0))


@dataclass(frozen=True)
class Course(Behaviour):
    """A parameter follows given values, linear between them and constant before and after."""

    times: Annotated[tuple[float, ...], "s"]
    values: Annotated[tuple[Amount, ...], SIGNAL_UNIT]
    fits: ClassVar[frozenset[str]] = _PARAMETERS

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.times or len(self.times) != len(self.values) or (np.diff(self.times) <= 0.0).any():
            raise ParameterError(
                f"a course needs as many values as times, and ascending times; given: {len(self.values)} values at "
                f"{list(self.times)} s"
            )

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=0.0, offset=np.interp(since, self.times, [si(value) for value in self.values]))


@dataclass(frozen=True)
class WithTemperature(Behaviour):
    """A parameter depends linearly on a temperature, which approaches its final value exponentially.

    The parameter has its own value at the reference temperature. The default coefficient is that of the resistance of
    copper; the flux of neodymium magnets has about -0.0011 1/K.
    """

    temperature: Annotated[float, "K", POSITIVE]
    coefficient: Annotated[float, "1/K"] = 0.00393
    reference: Annotated[float, "K", POSITIVE] = 293.15
    time_constant: Annotated[float, "s", POSITIVE] = 300.0
    fits: ClassVar[frozenset[str]] = frozenset({PARAMETER})
    main: ClassVar[str | None] = "temperature"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        warmer = (self.temperature - self.reference) * share_reached(since / self.time_constant)
        return Change(gain=1.0 + self.coefficient * warmer)


@dataclass(frozen=True)
class Intermittent(Behaviour):
    """Another behaviour is switched on and off at random, as by a loose contact; it starts switched on."""

    behaviour: AnyBehaviour
    mean_on: Annotated[float, "s", POSITIVE] = 0.2
    mean_off: Annotated[float, "s", POSITIVE] = 1.0
    main: ClassVar[str | None] = "behaviour"

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.behaviour, Intermittent):
            raise ParameterError("what comes and goes cannot itself be intermittent; give mean_on and mean_off once")

    @property
    def core(self) -> Behaviour:
        return self.behaviour

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        there = chance.on(since, self.mean_on, self.mean_off)
        change = self.behaviour.change(since, chance)
        return Change(np.where(there, change.gain, 1.0), np.where(there, change.offset, 0.0), there & change.held)

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        there = active.copy()
        there[active] = chance.on(time[active] - chance.start, self.mean_on, self.mean_off)
        return self.behaviour.on_channel(time, values, there, sensor, chance)


AnyBehaviour = (
    TotalLoss
    | Stuck
    | Offset
    | Gain
    | Drift
    | Outlier
    | Spikes
    | Noise
    | Delay
    | BitFlip
    | DropOut
    | TorqueLoss
    | Sluggish
    | Step
    | Ramp
    | Scale
    | Course
    | WithTemperature
    | Intermittent
)
"""Union of all behaviours of a fault."""
BEHAVIOURS: dict[str, type[Behaviour]] = {kind_name(each): each for each in get_args(AnyBehaviour)}
"""Every behaviour by its name in files."""


def described(behaviour: Behaviour) -> dict[str, Any]:
    """A behaviour as a table of numbers, texts and tables."""
    table: dict[str, Any] = {"kind": kind_name(type(behaviour))}
    for field in dataclasses.fields(behaviour):
        value = getattr(behaviour, field.name)
        table[field.name] = described(value) if isinstance(value, Behaviour) else value
    return table
