"""Recording of a run: sampled outputs of the plant as measured channels, and the truth beside them."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Collection, Mapping
from typing import get_type_hints

import numpy as np

from tierod.core.block import Block, Tree, units
from tierod.core.graph.trace import trace
from tierod.core.recording import Channel
from tierod.core.signals import SIGNALS
from tierod.proving_ground.sensors import Sensor

TRUTH_RATE = 100.0
"""Rate of the channels prefixed `truth_` [Hz]."""
TRUTH = "truth_"
COMMANDS = "commands."
"""Branch of the outputs of a block that go to a unit of another tool."""
SAME_INSTANT = 1e-6
"""Share of a sample below which two instants are one: the clock of a run is a product of rounded numbers."""


def channel_names(block: Block) -> dict[str, list[int]]:
    """Channel -> its columns among a block's outputs: the last part of the dotted name; several where sub-sampled.

    What a block gives a unit that computes the vehicle is no channel.
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
    """Collects the outputs of a run in pieces and samples every channel at its own instants.

    Args:
        columns: from `channel_names`
        instants: of every measured channel: when the truth is taken [s]
        step_time: of the plant [s]
        seconds: duration [s]

    Every channel also gets its truth, `truth_NAME`, at 100 Hz.
    """

    BUFFER = 10_000

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
        """The next rows of outputs, one per step of the plant, perhaps none."""
        if not len(outputs):
            return
        self.rows.append(outputs)
        self.held += len(outputs)
        if self.held >= self.BUFFER:
            self._sample(final=False)

    def truths(self) -> dict[str, np.ndarray]:
        """True signals of all channels at their instants, empty where nothing was added; called once, at the end."""
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
        self.rows, self.held = [values[-1:]], 1
        self.first += len(values) - 1


def _interpolated(series: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Values between the samples of a series, at places counted in samples; at a sample, that sample itself."""
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
    """A channel of the virtual car; units from the catalogue of signals, else from the plant."""
    plain = name.removeprefix(TRUTH)
    unit = SIGNALS[plain].unit if plain in SIGNALS else described.get(plain, described.get(name, ""))
    return Channel(name, time, values, unit, "virtual car")


def declared_units(output: Tree) -> dict[str, str]:
    """Unit of every channel of a block's output, from the annotations of its NamedTuples."""
    found: dict[str, str] = {}
    stack = [output]
    while stack:
        branch = stack.pop()
        if isinstance(branch, tuple) and hasattr(branch, "_fields"):
            for below in branch:
                if isinstance(below, tuple):
                    stack.append(below)
            own = dict(zip(branch._fields, _own_units(type(branch)), strict=True))
            found |= {name: unit for name, unit in own.items() if unit is not None}
    return found


def _own_units(kind: type) -> list[str | None]:
    hints = get_type_hints(kind, include_extras=True)
    result: list[str | None] = []
    for name in kind._fields:  # type: ignore[attr-defined]  # a NamedTuple
        listed = units(hints[name])
        result.append(listed[0] if listed and len(set(listed)) == 1 else None)
    return result


_STREAM = 2
"""The stream of chance of sensors."""


def generator(seed: int, stream: int, part: int = 0) -> np.random.Generator:
    """A source of chance of its own for every purpose, so that one does not move the other."""
    return np.random.default_rng([seed, stream, part])


Faulty = Callable[[str, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


class Readings:
    """The sensors of a run: when each takes the truth, what stamps it writes, and what it makes of the truth.

    Args:
        sensors: by channel
        seconds: duration of the run [s]
        seed: of the run; every sensor draws from a stream of its own

    Attributes:
        instants: by channel, when the truth is taken [s]
    """

    def __init__(self, sensors: Mapping[str, Sensor], seconds: float, seed: int):
        self.sensors = sensors
        self._chance = {name: generator(seed, _STREAM, zlib.crc32(name.encode())) for name in sensors}
        both = {name: sensor.instants(seconds, self._chance[name]) for name, sensor in sensors.items()}
        self.instants = {name: taken for name, (taken, _) in both.items()}
        self._stamps = {name: stamps for name, (_, stamps) in both.items()}

    def channels(
        self, truths: Mapping[str, np.ndarray], faulty: Faulty, described: Mapping[str, str]
    ) -> dict[str, Channel]:
        """The measured channels, with the faults of recorded signals.

        Args:
            truths: true signal of every sensor at its instants
            faulty: (channel, time stamps, readings) to both with the faults of recorded signals
            described: units that the plant gives
        """
        result = {}
        for name, sensor in self.sensors.items():
            values = sensor.read(truths[name], self._chance[name])
            stamps, values = faulty(name, self._stamps[name][: len(values)], values)
            result[name] = channel(name, stamps, values, described)
        return result


def true_channels(
    truths: Mapping[str, np.ndarray], measured: Collection[str], described: Mapping[str, str]
) -> dict[str, Channel]:
    """The truth of every channel, from zero on at its own rate.

    Args:
        truths: by channel, those of the measured ones left aside
        measured: names of the measured channels
        described: units that the plant gives
    """
    grids: dict[int, np.ndarray] = {}
    return {
        name: channel(name, grids.setdefault(len(v), np.arange(len(v)) / TRUTH_RATE), v, described)
        for name, v in truths.items()
        if name not in measured
    }
