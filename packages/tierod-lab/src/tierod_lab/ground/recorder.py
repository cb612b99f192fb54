"""Recording of a run: outputs of the plant, sampled as measured channels, and the true signals."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Collection, Mapping
from typing import get_type_hints

import numpy as np

from tierod.core.block import Block, Tree, units
from tierod.core.graph.trace import trace
from tierod.core.recording import Channel
from tierod.core.signals import SIGNALS
from tierod_lab.ground.sensors import Sensor

TRUTH_RATE = 100.0  # Rate of the channels prefixed `truth_` [Hz]
TRUTH = "truth_"
COMMANDS = "commands."  # Branch of a block's outputs that are inputs of a unit of another tool
SAME_INSTANT = 1e-6
"""Share of a sampling interval below which two instants are equal: times are products of rounded numbers."""


def channel_names(block: Block) -> dict[str, list[int]]:
    """Columns of every channel among a block's outputs, by the last part of the dotted name.

    A sub-sampled channel has several columns. Outputs that are inputs of another tool's unit are not channels.
    """
    found: dict[str, list[int]] = {}
    for column, path in enumerate(trace(block).output):
        if path.startswith(COMMANDS):
            continue
        parts = path.split(".")
        name = parts[-2] if parts[-1].isdigit() and len(parts) > 1 else parts[-1]
        found.setdefault(name, []).append(column)
    return found


class Recorder:
    """Collects the outputs of a run piece by piece and samples every channel at its own instants.

    Args:
        instants: sampling instants of every measured channel, at which the true value is taken [s]
        step_time: step of the plant [s]
        seconds: duration of the run [s]

    Every channel also gets its true values, `truth_NAME`, at 100 Hz.
    """

    BUFFER = 10_000  # Number of rows from which the channels are sampled

    def __init__(
        self, columns: Mapping[str, list[int]], instants: Mapping[str, np.ndarray], step_time: float, seconds: float
    ):
        count = int(np.floor(seconds * TRUTH_RATE + 1e-9))
        grid = np.arange(count) / TRUTH_RATE
        self.columns = columns
        self.wanted = {name: (name, times) for name, times in instants.items()}
        self.wanted |= {name if name.startswith(TRUTH) else TRUTH + name: (name, grid) for name in columns}
        self.step_time = step_time
        self.taken = {name: np.empty(len(times)) for name, (_, times) in self.wanted.items()}
        self.reached = dict.fromkeys(self.wanted, 0)
        self.rows: list[np.ndarray] = []
        self.first = self.held = 0

    def add(self, outputs: np.ndarray) -> None:
        """Append the next rows of outputs, one per step of the plant; there may be none."""
        if not len(outputs):
            return
        self.rows.append(outputs)
        self.held += len(outputs)
        if self.held >= self.BUFFER:
            self._sample(final=False)

    def truths(self) -> dict[str, np.ndarray]:
        """True values of all channels at their instants, empty if nothing was added; called once, at the end."""
        if self.rows:
            self._sample(final=True)
        return {name: values[: self.reached[name]] for name, values in self.taken.items()}

    def _sample(self, final: bool) -> None:
        values = np.concatenate(self.rows)
        for name, (source, times) in self.wanted.items():
            columns = self.columns[source]
            fine = self.step_time / len(columns)
            series = values[:, columns].reshape(-1) if len(columns) > 1 else values[:, columns[0]]
            before = self.first * len(columns)
            begin = self.reached[name]
            end = (before + len(series) - 1) * fine
            stop = len(times) if final else int(np.searchsorted(times, end, side="right"))
            place = times[begin:stop] / fine - before
            self.taken[name][begin:stop] = _interpolated(series, place)
            self.reached[name] = stop
        # The last row is kept: instants between it and the next row are interpolated with the next piece.
        self.rows, self.held = [values[-1:]], 1
        self.first += len(values) - 1


def _interpolated(series: np.ndarray, place: np.ndarray) -> np.ndarray:
    place = np.clip(place, 0.0, len(series) - 1)
    at = np.rint(place).astype(int)
    exact = np.abs(place - at) < SAME_INSTANT
    if exact.all():
        return np.asarray(series[at])
    below = np.minimum(place.astype(int), max(len(series) - 2, 0))
    after = np.minimum(below + 1, len(series) - 1)
    between = series[below] + (place - below) * (series[after] - series[below])
    return np.asarray(np.where(exact, series[at], between))


def channel(name: str, time: np.ndarray, values: np.ndarray, described: Mapping[str, str]) -> Channel:
    """A channel of the virtual car, with its unit from the catalogue of signals or else from the plant."""
    plain = name.removeprefix(TRUTH)
    unit = SIGNALS[plain].unit if plain in SIGNALS else described.get(plain, described.get(name, ""))
    return Channel(name, time, values, unit, "virtual car")


def declared_units(output: Tree) -> dict[str, str]:
    """Unit of every channel of a block's output, from the annotations of its NamedTuples."""
    found: dict[str, str] = {}
    if isinstance(output, tuple) and hasattr(output, "_fields"):
        hints = get_type_hints(type(output), include_extras=True)
        for name, below in zip(output._fields, output, strict=True):
            listed = set(units(hints[name]))
            found |= {name: listed.pop()} if len(listed) == 1 else {}
            found |= declared_units(below)
    return found


_STREAM = 2  # Number of the sensors' random stream


def generator(seed: int, stream: int, part: int = 0) -> np.random.Generator:
    """Random generator of one purpose, independent of those of all other purposes."""
    return np.random.default_rng([seed, stream, part])


Faulty = Callable[[str, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


class Readings:
    """Sensors of a run: sampling `instants` by channel [s], time stamps, and readings, each with a random stream."""

    def __init__(self, sensors: Mapping[str, Sensor], seconds: float, seed: int):
        self.sensors = sensors
        self._chance = {name: generator(seed, _STREAM, zlib.crc32(name.encode())) for name in sensors}
        both = {name: sensor.instants(seconds, self._chance[name]) for name, sensor in sensors.items()}
        self.instants = {name: taken for name, (taken, _) in both.items()}
        self._stamps = {name: stamps for name, (_, stamps) in both.items()}

    def channels(
        self, truths: Mapping[str, np.ndarray], faulty: Faulty, described: Mapping[str, str]
    ) -> dict[str, Channel]:
        """Measured channels, including the faults of recorded signals."""
        result = {}
        for name, sensor in self.sensors.items():
            values = sensor.read(truths[name], self._chance[name])
            stamps, values = faulty(name, self._stamps[name][: len(values)], values)
            result[name] = channel(name, stamps, values, described)
        return result


def true_channels(
    truths: Mapping[str, np.ndarray], measured: Collection[str], described: Mapping[str, str]
) -> dict[str, Channel]:
    """True values of every channel but the measured ones at `TRUTH_RATE`, from time zero on."""
    grids: dict[int, np.ndarray] = {}
    return {
        name: channel(name, grids.setdefault(len(v), np.arange(len(v)) / TRUTH_RATE), v, described)
        for name, v in truths.items()
        if name not in measured
    }
