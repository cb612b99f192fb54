"""Sensors: noise, resolution, delay and rate of one, and the sets of test and production cars."""

from __future__ import annotations

import math
from collections.abc import ItemsView, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range, check_ranges
from tierod.core.signals import SIGNALS
from tierod.core.toml import SIGNAL_UNIT, Document, Location, build


def gauss_markov(count: int, correlation: float, generator: np.random.Generator) -> np.ndarray:
    """A stationary first-order Gauss-Markov series of unit standard deviation, shape (count,).

    Source: A. Gelb (ed.), Applied Optimal Estimation, MIT Press (1974), section 3.8.
    """
    from scipy.signal import lfilter

    kept = math.exp(-1.0 / correlation)
    driving = generator.standard_normal(count)
    # The first value keeps unit variance, so that the series is stationary from its start.
    driving[1:] *= math.sqrt(1.0 - kept * kept)
    return np.asarray(lfilter([1.0], [1.0, -kept], driving))


def random_walk(count: int, step_time: float, generator: np.random.Generator) -> np.ndarray:
    """A random walk that starts at zero, with standard deviation sqrt(time), shape (count,).

    Args:
        step_time: sampling interval [s]
    """
    steps = math.sqrt(step_time) * generator.standard_normal(count)
    steps[:1] = 0.0
    return np.cumsum(steps)


def lost_frames(count: int, share: float, mean_run: float, generator: np.random.Generator) -> np.ndarray:
    """Mask of the lost ones among a number of frames, shape (count,).

    Source: E. N. Gilbert, Capacity of a burst-noise channel, Bell System Technical Journal 39 (1960): a chain of two
    states, here with no loss in the good one and no frame in the bad one.
    """
    mean_good = mean_run * (1.0 - share) / share
    bad = generator.random() < share
    pieces: list[np.ndarray] = []
    total = 0
    while total < count:
        expected = max(16, int(1.2 * (count - total) / (mean_good + mean_run)))
        runs = np.empty(2 * expected, dtype=int)
        runs[int(not bad) :: 2] = generator.geometric(1.0 / mean_run, expected)
        runs[int(bad) :: 2] = generator.geometric(1.0 / mean_good, expected)
        states = np.arange(2 * expected) % 2 == int(not bad)
        pieces.append(np.repeat(states, runs))
        total += len(pieces[-1])
    return np.concatenate([*pieces, np.zeros(0, dtype=bool)])[:count]


AT_MOST = 0.45  # Maximum jitter as a share of the sampling interval, so that readings keep their order


@dataclass(frozen=True)
class Sensor:
    """One sensor: reading = rounded(limited(wrapped(gain * truth + bias + drift + noise))).

    Args:
        gain: scale factor; 1 is exact
        quantum: resolution of the reading; 0 is continuous
        wrap: range beyond which the reading overflows, a whole number of quanta; (low, high)
        saturation: range beyond which the transducer saturates; (low, high)
    """

    noise: Annotated[float, SIGNAL_UNIT, NOT_NEGATIVE] = 0.0
    bias: Annotated[float, SIGNAL_UNIT] = 0.0
    gain: Annotated[float, ""] = 1.0
    quantum: Annotated[float, SIGNAL_UNIT, NOT_NEGATIVE] = 0.0
    delay: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    rate: Annotated[float, "Hz", POSITIVE] = 100.0
    jitter: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    stamp_jitter: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    loss: Annotated[float, "", Range(0.0, 0.99)] = 0.0
    loss_run: Annotated[float, "", Range(1.0)] = 1.0
    repeats: Annotated[float, "", Range(0.0, 0.99)] = 0.0
    instability: Annotated[float, SIGNAL_UNIT, NOT_NEGATIVE] = 0.0
    instability_time: Annotated[float, "s", POSITIVE] = 100.0
    random_walk: Annotated[float, "{signal}/s**0.5", NOT_NEGATIVE] = 0.0
    wrap: Annotated[tuple[float, float], SIGNAL_UNIT] | None = None
    saturation: Annotated[tuple[float, float], SIGNAL_UNIT] | None = None

    def __post_init__(self) -> None:
        check_ranges(self)
        for name in ("wrap", "saturation"):
            limits = getattr(self, name)
            if limits is not None and not limits[0] < limits[1]:
                raise ParameterError(f"the {name} of a sensor needs a lower limit below the upper one, not {limits}")
        if self.loss / (1.0 - self.loss) > self.loss_run:
            raise ParameterError(
                f"a loss of {self.loss:g} means runs of more than {self.loss / (1.0 - self.loss):.3g} frames; "
                f"raise loss_run from {self.loss_run:g}"
            )

    def instants(self, seconds: float, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Times at which the sensor reads, and its time stamps, without lost frames.

        Args:
            seconds: duration of the run [s]
            generator: random generator; it is spawned, so that its own stream remains unused for `read`

        Returns:
            (instants at which the true value is taken [s], time stamps [s]), both ascending; a reading that is older
            than the start of the run takes the value at the start
        """
        reading, writing, losing = generator.spawn(3)
        stamps = np.arange(math.floor(seconds * self.rate + 1e-9)) / self.rate
        taken = stamps - self.delay + self._jitter(self.jitter, len(stamps), reading)
        stamps = stamps + self._jitter(self.stamp_jitter, len(stamps), writing)
        if self.loss > 0.0:
            kept = ~lost_frames(len(stamps), self.loss, self.loss_run, losing)
            taken, stamps = taken[kept], stamps[kept]
        return np.maximum(taken, 0.0), np.maximum(stamps, 0.0)

    def _jitter(self, deviation: float, count: int, generator: np.random.Generator) -> np.ndarray | float:
        if deviation == 0.0:
            return 0.0
        limit = AT_MOST / self.rate
        return np.clip(deviation * generator.standard_normal(count), -limit, limit)

    def read(self, truth: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """Readings of a true signal at the sensor's instants, in the unit of the signal, shape (n,).

        A drift advances with the number of readings: it stands still over lost frames.
        """
        slow, walking, repeating = generator.spawn(3)
        reading = self.gain * truth + self.bias + self.noise * generator.standard_normal(len(truth))
        if self.instability > 0.0:
            reading += self.instability * gauss_markov(len(truth), self.instability_time * self.rate, slow)
        if self.random_walk > 0.0:
            reading += self.random_walk * random_walk(len(truth), 1.0 / self.rate, walking)
        reading = self.represented(reading)
        if self.repeats > 0.0:
            fresh = repeating.random(len(truth)) >= self.repeats
            fresh[:1] = True
            reading = reading[np.maximum.accumulate(np.where(fresh, np.arange(len(truth)), 0))]
        return reading

    def represented(self, values: np.ndarray) -> np.ndarray:
        """Values as the bus represents them: wrapped, saturated and rounded."""
        values = self._run_over(values)
        if self.saturation is not None:
            values = np.clip(values, *self.saturation)
        if self.quantum > 0.0:
            # A value rounded up to the upper limit wraps to the lower one.
            values = self._run_over(np.round(values / self.quantum) * self.quantum)
        return values

    def _run_over(self, values: np.ndarray) -> np.ndarray:
        if self.wrap is None:
            return values
        low, high = self.wrap
        values = values - (high - low) * np.floor((values - low) / (high - low))
        return np.where(values >= high - 1e-9 * (high - low), low, values)


PRESETS = ("production", "ideal", "bench", "worn")  # Names of the shipped sets of sensors


@dataclass(frozen=True)
class SensorSet:
    """The sensors of a car by canonical signal; sensors of signals that a car lacks have no effect."""

    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    description: str = ""

    def __post_init__(self) -> None:
        for name in self.sensors:
            if name not in SIGNALS:
                raise ParameterError(f"a sensor cannot measure '{name}'{nearest(name, SIGNALS)}")

    def items(self) -> ItemsView[str, Sensor]:
        return self.sensors.items()

    def __contains__(self, name: str) -> bool:
        return name in self.sensors

    def __getitem__(self, name: str) -> Sensor:
        if name not in self.sensors:
            raise ParameterError(f"no sensor measures '{name}'{nearest(name, self.sensors)}")
        return self.sensors[name]

    def with_sensors(self, sensors: Mapping[str, Sensor]) -> SensorSet:
        return replace(self, sensors={**self.sensors, **sensors})

    def without(self, names: Iterable[str]) -> SensorSet:
        left_out = {name: self[name] for name in names}
        return replace(self, sensors={name: each for name, each in self.items() if name not in left_out})

    def only(self, names: Iterable[str]) -> SensorSet:
        return replace(self, sensors={name: self[name] for name in names})

    def at_rate(self, rate: float) -> SensorSet:
        """The set with all sensors at one rate [Hz]."""
        return replace(self, sensors={name: replace(each, rate=rate) for name, each in self.items()})

    @classmethod
    def production(cls) -> SensorSet:
        return _shipped("production")

    @classmethod
    def bench(cls) -> SensorSet:
        """Sensors of a test bench or a well equipped test car."""
        return _shipped("bench")

    @classmethod
    def worn(cls) -> SensorSet:
        """Sensors of a production car after long use, on a busy bus."""
        return _shipped("worn")

    @classmethod
    def ideal(cls, rate: float = 100.0) -> SensorSet:
        """Sensors without errors of all canonical signals, at this rate [Hz]."""
        return cls(dict.fromkeys(SIGNALS, Sensor(rate=rate)), "Every signal as it is.")

    @classmethod
    def preset(cls, name: str) -> SensorSet:
        if name not in PRESETS:
            raise ParameterError(f"no set of sensors is called '{name}'{nearest(name, PRESETS)}")
        return cls.ideal() if name == "ideal" else _shipped(name)

    @classmethod
    def from_table(
        cls, table: Mapping[str, Any], document: Document, location: Location = (), base: SensorSet | None = None
    ) -> SensorSet:
        """The set of a table.

        Args:
            table: `preset` (a shipped name, or a file beside the document), `rate` of all, `without` (names), and one
                table per channel with changes of the preset; a channel that the preset lacks is added
            base: set to start from where the table names no preset; "production" if None
        """
        own = ("preset", "rate", "without", "description")
        start = _start(table, document, location, base)
        if "rate" in table:
            start = start.at_rate(build(Sensor, {"rate": table["rate"]}, document, location).rate)
        left_out = table.get("without", [])
        if not (isinstance(left_out, list) and all(isinstance(name, str) for name in left_out)):
            raise document.error((*location, "without"), "'without' has to be a list of names")
        for number, name in enumerate(left_out):
            if name not in start:
                near = nearest(name, start.sensors)
                raise document.error((*location, "without", number), f"no sensor measures '{name}'{near}")
        start = start.without(left_out)
        changed = {}
        for name, given in table.items():
            if name in own:
                continue
            place, known = (*location, name), [*own, *SIGNALS]
            if name not in SIGNALS:
                raise document.error(place, f"a sensor cannot measure '{name}'{nearest(name, known)}")
            unit, usual = SIGNALS[name].unit, start.sensors.get(name)
            changed[name] = build(Sensor, given, document, place, base=usual, signal=unit)
        description = table.get("description", start.description)
        if not isinstance(description, str):
            raise document.error((*location, "description"), "'description' has to be a text")
        return replace(start.with_sensors(changed), description=description)


def _start(table: Mapping[str, Any], document: Document, location: Location, base: SensorSet | None) -> SensorSet:
    if "preset" not in table:
        return SensorSet.production() if base is None else base
    name = table["preset"]
    if name in PRESETS:
        return SensorSet.preset(name)
    path = document.path.parent / str(name)
    if not (str(name).endswith(".toml") and path.is_file()):
        known = f"{nearest(str(name), PRESETS)} A file of your own is named by its path"
        raise document.error((*location, "preset"), f"no set of sensors is called '{name}'{known}")
    try:
        file = document.beside(path.absolute(), "sensor")
    except ParameterError as error:
        raise document.error((*location, "preset"), str(error)) from None
    return SensorSet.from_table(file.content, file)


@cache
def _shipped(name: str) -> SensorSet:
    document = Document.read(Path(__file__).with_name(f"{name}.toml"), "sensor")
    return SensorSet.from_table(document.content, document, base=SensorSet())
