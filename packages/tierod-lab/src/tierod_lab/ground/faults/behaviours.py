"""Behaviours of faulty signals, actuators, parameters and surroundings, with their seeded random numbers."""

from __future__ import annotations

import dataclasses
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, ClassVar, NamedTuple, get_args

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range, check_ranges
from tierod.core.toml import SIGNAL_UNIT, kind_name
from tierod.physics.friction import share_reached
from tierod_lab.ground.sensors import Sensor

_BLOCK = 1024  # Number of random numbers that are drawn together


class Chance:
    """Random numbers of one fault in one run.

    A loop at 1 kHz and a recorded channel at 100 Hz get the same spikes, the same lost frames, and the same noise where
    their instants coincide. Random processes are drawn for a horizon [s] from the onset of the fault [s] on.
    """

    def __init__(self, key: tuple[int, ...], start: float, horizon: float, rate: float = 100.0):
        self.key, self.start, self.horizon, self.rate = key, start, horizon, rate
        self.tick = min(1e-3, 1.0 / rate)
        self._block = lru_cache(maxsize=8)(self._drawn_block)
        self.events = lru_cache(maxsize=8)(self._drawn_events)
        self._edges = lru_cache(maxsize=8)(self._drawn_edges)

    def generator(self, purpose: str, part: int = 0) -> np.random.Generator:
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

    def _drawn_events(self, rate: float) -> tuple[np.ndarray, np.ndarray]:
        """(times since the onset [s], signs) of the events of a Poisson process with this rate [Hz]."""
        generator = self.generator("events")
        count = int(generator.poisson(rate * self.horizon))
        return np.sort(generator.uniform(0.0, self.horizon, count)), generator.choice([-1.0, 1.0], count)

    def on(self, since: np.ndarray, mean_on: float, mean_off: float) -> np.ndarray:
        """Whether an intermittent contact is on; it starts on, and the durations are exponentially distributed.

        Args:
            since: times since the onset [s]
            mean_on, mean_off: mean durations [s]
        """
        return np.asarray(np.searchsorted(self._edges(mean_on, mean_off), since, side="right") % 2 == 0)

    def _drawn_edges(self, mean_on: float, mean_off: float) -> np.ndarray:
        generator = self.generator("on and off")
        pieces, end = [np.empty(0)], 0.0
        while end < self.horizon:
            count = int(0.6 * (self.horizon - end) / (mean_on + mean_off)) + 8
            spans = generator.standard_exponential((count, 2)) * [mean_on, mean_off]
            pieces.append(end + np.cumsum(spans.reshape(-1)))
            end = float(pieces[-1][-1])
        return np.concatenate(pieces)


Amount = float | str
"""A number in SI units, or a text with a unit ("0.3 deg/s"), which is converted once the element is known."""
SIGNAL, LOOP, ACTUATOR, PARAMETER, SURROUNDING = "signal", "loop", "actuator", "parameter", "surrounding"
"""Kinds of elements: a recorded signal, a signal that the car's own control units read, an actuator, a parameter of the
car, or a quantity of its surroundings."""

Array = np.ndarray
Values = float | Array
Readings = tuple[Array, Array]  # time stamps [s] and values


class Change(NamedTuple):
    """Change of a value: held at its last value before the fault where `held` is true, then gain * value + offset."""

    gain: Values = 1.0
    offset: Values = 0.0
    held: bool | np.ndarray = False


def si(amount: Amount) -> float:
    if isinstance(amount, str):
        raise ParameterError(f"'{amount}' has a unit, but its quantity is not known; give the number in SI units")
    return float(amount)


@dataclass(frozen=True)
class Behaviour:
    """Base class of the behaviours: frozen, with units and ranges in the annotations.

    `fits` contains the kinds of elements that can behave so, `main` names the field that is the fault magnitude (the
    first one), and `usual_duration` is the default duration [s], None until the end of the run.
    """

    fits: ClassVar[frozenset[str]] = frozenset()
    main: ClassVar[str | None] = None
    usual_duration: ClassVar[float | None] = None

    def __init_subclass__(cls, fits: Iterable[str] = (), sized: bool = True) -> None:
        cls.fits = frozenset(fits)
        cls.main = next(iter(cls.__annotations__), None) if sized else None

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def core(self) -> Behaviour:
        return self

    def change(self, since: Array, chance: Chance) -> Change:
        raise NotImplementedError

    def on_channel(self, time: Array, values: Array, active: Array, sensor: Sensor, chance: Chance) -> Readings:
        changed = values.copy()
        change = self.change(time[active] - chance.start, chance)
        # Held readings repeat the last one before the hold: its index is carried forward.
        source = np.arange(len(values))
        source[active] = np.where(change.held, 0, source[active])
        kept = values[np.maximum.accumulate(source)] if len(values) else values
        changed[active] = sensor.represented(change.gain * kept[active] + change.offset)
        return time, changed


_VALUES, _PARAMETERS = (SIGNAL, LOOP, ACTUATOR), (PARAMETER, SURROUNDING)
_ALL = (*_VALUES, *_PARAMETERS)


@dataclass(frozen=True)
class TotalLoss(Behaviour, fits=_VALUES):
    """The signal is zero."""

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(gain=0.0)


@dataclass(frozen=True)
class Stuck(Behaviour, fits=_VALUES):
    """The signal keeps its last value or a given value."""

    value: Annotated[Amount, SIGNAL_UNIT] | None = None  # constant value; the last one before the fault if None

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(held=True) if self.value is None else Change(gain=0.0, offset=si(self.value))


@dataclass(frozen=True)
class Offset(Behaviour, fits=_ALL):
    """A constant of either sign is added."""

    size: Annotated[Amount, SIGNAL_UNIT]

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(offset=si(self.size))


@dataclass(frozen=True)
class Gain(Behaviour, fits=_ALL):
    """The signal is multiplied by a factor: 1 is fault-free, -1 inverts the sign."""

    gain: Annotated[float, ""]

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(gain=self.gain)


@dataclass(frozen=True)
class Drift(Behaviour, fits=_ALL):
    """An offset that grows from zero is added."""

    rate: Annotated[Amount, "{signal}/s"]
    limit: Annotated[Amount, SIGNAL_UNIT] | None = None  # magnitude at which the growth stops; never if None

    def change(self, since: Array, chance: Chance) -> Change:
        offset = si(self.rate) * since
        if self.limit is None:
            return Change(offset=offset)
        limit = abs(si(self.limit))
        return Change(offset=np.clip(offset, -limit, limit))


@dataclass(frozen=True)
class Outlier(Behaviour, fits=_VALUES):
    """The signal is far off for one second: a multiple of itself, or a given value.

    Source: Li, Frey, Gauterin, Sensors 23 (2023) 887, section 5: "a large outlier in the sensor data over a very short
    time such as one second".
    """

    factor: Annotated[float, ""] = 3.0
    value: Annotated[Amount, SIGNAL_UNIT] | None = None  # value that replaces the signal, if not None
    usual_duration = 1.0

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(gain=self.factor) if self.value is None else Change(gain=0.0, offset=si(self.value))


@dataclass(frozen=True)
class Spikes(Behaviour, fits=_VALUES):
    """Short pulses of either sign are added at random instants."""

    size: Annotated[Amount, SIGNAL_UNIT]
    rate: Annotated[float, "Hz", POSITIVE] = 1.0
    # duration of each pulse; a channel with longer sampling intervals misses some
    width: Annotated[float, "s", POSITIVE] = 0.01

    def change(self, since: Array, chance: Chance) -> Change:
        times, signs = chance.events(self.rate)
        if not len(times):
            return Change()
        latest = np.searchsorted(times, since, side="right") - 1
        inside = (latest >= 0) & (since - times[latest] < self.width)
        return Change(offset=np.where(inside, si(self.size) * signs[latest], 0.0))


@dataclass(frozen=True)
class Noise(Behaviour, fits=_VALUES):
    """White noise is added: a new value every millisecond, or with every reading of a faster channel."""

    deviation: Annotated[Amount, SIGNAL_UNIT, NOT_NEGATIVE]

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(offset=si(self.deviation) * chance.normal(since))


@dataclass(frozen=True)
class Delay(Behaviour, fits=(SIGNAL,)):
    """Readings arrive late with unchanged time stamps. Recorded signals only: a control loop has no buffer."""

    time: Annotated[float, "s", POSITIVE]

    def on_channel(self, time: Array, values: Array, active: Array, sensor: Sensor, chance: Chance) -> Readings:
        old = np.searchsorted(time, time - self.time + 1e-9, side="right") - 1
        return time, np.where(active, values[np.maximum(old, 0)], values)


@dataclass(frozen=True)
class BitFlip(Behaviour, fits=(SIGNAL,)):
    """One bit of the raw number on the bus is inverted. Recorded signals only: the error depends on the value."""

    bit: Annotated[int, "", Range(0, 62)]
    bits: Annotated[int, "", Range(2, 63)] = 16
    # value of the least significant bit; that of the sensor if None
    quantum: Annotated[Amount, SIGNAL_UNIT, POSITIVE] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.bit >= self.bits:
            raise ParameterError(f"bit {self.bit} does not exist among {self.bits} bits; the last is {self.bits - 1}")

    def on_channel(self, time: Array, values: Array, active: Array, sensor: Sensor, chance: Chance) -> Readings:
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
class DropOut(Behaviour, fits=(SIGNAL, LOOP)):
    """Frames are lost. A control loop continues with the last value; so does a recording if `repeat` is set."""

    share: Annotated[float, "", Range(0.0, 1.0, open_low=True)] = 1.0
    repeat: bool = False

    def change(self, since: Array, chance: Chance) -> Change:
        # A control step between two frames uses the earlier one.
        frame = np.floor((since + chance.start) * chance.rate + 1e-6) / chance.rate
        return Change(held=self._lost(frame, chance))

    def on_channel(self, time: Array, values: Array, active: Array, sensor: Sensor, chance: Chance) -> Readings:
        if self.repeat:
            return super().on_channel(time, values, active, sensor, chance)
        lost = active.copy()
        lost[active] = self._lost(time[active], chance)
        return time[~lost], values[~lost]

    def _lost(self, time: np.ndarray, chance: Chance) -> np.ndarray:
        return chance.uniform(np.floor(time * chance.rate + 0.5).astype(int)) < self.share


@dataclass(frozen=True)
class TorqueLoss(Behaviour, fits=(ACTUATOR,)):
    """An actuator delivers less torque than requested."""

    # share of the torque that is lost; 1 is all of it
    share: Annotated[float, "", Range(0.0, 1.0, open_low=True)] = 1.0

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(gain=1.0 - self.share)


@dataclass(frozen=True)
class Sluggish(Behaviour, fits=(ACTUATOR,)):
    """An actuator follows its request with another time constant, which replaces that parameter of the car."""

    time_constant: Annotated[float, "s", POSITIVE]

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(gain=0.0, offset=self.time_constant)


@dataclass(frozen=True)
class Step(Behaviour, fits=_PARAMETERS):
    """A parameter jumps to another value."""

    to: Annotated[Amount, SIGNAL_UNIT]

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(gain=0.0, offset=si(self.to))


@dataclass(frozen=True)
class Ramp(Behaviour, fits=_PARAMETERS):
    """A parameter changes linearly to another value and stays there."""

    to: Annotated[Amount, SIGNAL_UNIT]
    over: Annotated[float, "s", POSITIVE]

    def change(self, since: Array, chance: Chance) -> Change:
        share = np.clip(since / self.over, 0.0, 1.0)
        return Change(gain=1.0 - share, offset=share * si(self.to))


@dataclass(frozen=True)
class Scale(Behaviour, fits=_PARAMETERS):
    """A parameter is multiplied by a factor, at once or along a ramp."""

    factor: Annotated[float, ""]
    over: Annotated[float, "s", NOT_NEGATIVE] = 0.0

    def change(self, since: Array, chance: Chance) -> Change:
        share = np.clip(since / self.over, 0.0, 1.0) if self.over > 0.0 else 1.0
        return Change(gain=1.0 + share * (self.factor - 1.0))


@dataclass(frozen=True)
class Course(Behaviour, fits=_PARAMETERS, sized=False):
    """A parameter follows given values, linear between them and constant before and after."""

    times: Annotated[tuple[float, ...], "s"]
    values: Annotated[tuple[Amount, ...], SIGNAL_UNIT]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.times or len(self.times) != len(self.values) or (np.diff(self.times) <= 0.0).any():
            raise ParameterError(
                f"a course needs as many values as times, and ascending times; given: {len(self.values)} values at "
                f"{list(self.times)} s"
            )

    def change(self, since: Array, chance: Chance) -> Change:
        return Change(gain=0.0, offset=np.interp(since, self.times, [si(value) for value in self.values]))


@dataclass(frozen=True)
class WithTemperature(Behaviour, fits=(PARAMETER,)):
    """A parameter depends linearly on a temperature, which approaches its final value exponentially.

    The parameter has its own value at the reference temperature. The default coefficient is that of the resistance of
    copper; the flux of neodymium magnets has about -0.0011 1/K.
    """

    temperature: Annotated[float, "K", POSITIVE]
    coefficient: Annotated[float, "1/K"] = 0.00393
    reference: Annotated[float, "K", POSITIVE] = 293.15
    time_constant: Annotated[float, "s", POSITIVE] = 300.0

    def change(self, since: Array, chance: Chance) -> Change:
        warmer = (self.temperature - self.reference) * share_reached(since / self.time_constant)
        return Change(gain=1.0 + self.coefficient * warmer)


@dataclass(frozen=True)
class Intermittent(Behaviour):
    """Another behaviour is switched on and off at random, as by a loose contact; it starts switched on."""

    behaviour: AnyBehaviour
    mean_on: Annotated[float, "s", POSITIVE] = 0.2
    mean_off: Annotated[float, "s", POSITIVE] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.behaviour, Intermittent):
            raise ParameterError("what comes and goes cannot itself be intermittent; give mean_on and mean_off once")

    @property
    def core(self) -> Behaviour:
        return self.behaviour

    def change(self, since: Array, chance: Chance) -> Change:
        there = chance.on(since, self.mean_on, self.mean_off)
        change = self.behaviour.change(since, chance)
        return Change(np.where(there, change.gain, 1.0), np.where(there, change.offset, 0.0), there & change.held)

    def on_channel(self, time: Array, values: Array, active: Array, sensor: Sensor, chance: Chance) -> Readings:
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
