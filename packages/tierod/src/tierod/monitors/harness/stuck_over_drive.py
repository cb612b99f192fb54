"""Stuck signals over a recording: removed from the input of a monitor, and named in warnings."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.facts import Fact
from tierod.core.graph import Memory, Scanner
from tierod.core.recording import Aligned, Recording
from tierod.core.series import Stride
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.methods.relations import witnesses
from tierod.monitors.harness.stuck_signals import StuckSignals

# Rate at which signals are checked [Hz]: enough, since a stuck signal repeats its value in every sample, and cheap even
# beside a monitor at 10 kHz
RATE = 20.0

MAXIMUM_AGE = 0.1  # Age from which a sample counts as missing [s], as in most monitors
NAMED = 3  # Most spans of one signal that a warning lists; further ones are counted


@dataclass(frozen=True)
class Stuck:
    """Span of time over which a signal was stuck."""

    name: str  # name of the signal
    start: float  # start of the equal values, in the time of the recording [s]
    found: float  # time of the detection [s]
    end: float | None  # time of the next change [s]; None if there is none
    value: float  # value of the stuck signal [unit of the signal]


class StuckOverDrive:
    """Checks the input signals of a monitor; the result does not depend on how the recording is cut into pieces.

    Args:
        names: input signals of the monitor; only canonical signals are checked
        rate: rate of the monitor's grid [Hz]
    """

    def __init__(self, names: Collection[str], rate: float, passed_on: Collection[str] = ()):
        self.names = tuple(name for name in names if name in SIGNALS)
        self.beside = witnesses(self.names)
        self.passed_on = frozenset(passed_on)
        self._stride = Stride(max(round(rate / RATE), 1))
        self._rate = rate / self._stride.step
        self._block = StuckSignals(self.names, self.beside, 1.0 / self._rate) if self.names else None
        self._scanner = Scanner(self._block) if self._block else None
        self._memory: Memory | None = None
        self._flags = np.zeros(len(self.names), bool)
        self._open: dict[str, Stuck] = {}
        self._closed: list[Stuck] = []

    def without(self, aligned: Aligned, recording: Recording) -> Aligned:
        """Next samples of the monitor with NaN where a signal is stuck."""
        watched = self._stride.over(len(aligned.time))
        if self._block is None:
            return aligned
        kept = aligned.time[watched]
        # Row 0 is the state at the end of the previous piece, for samples before the first one that is checked here.
        flags = np.empty((len(kept) + 1, len(self.names)), bool)
        flags[0] = self._flags
        if len(kept):
            flags[1:] = self._watch(kept, recording)
            self._flags = flags[-1]
        if not flags.any():
            return aligned
        place = (np.arange(len(aligned.time)) - watched.start) // watched.step + 1
        values = aligned.values.copy()
        for column, name in enumerate(self.names):
            if name in aligned.names and name not in self.passed_on:
                values[flags[place, column], aligned.names.index(name)] = np.nan
        return replace(aligned, values=values)

    def spans(self) -> tuple[Stuck, ...]:
        """Spans in which signals were stuck, in the order of time."""
        return tuple(sorted((*self._closed, *self._open.values()), key=lambda each: (each.start, each.name)))

    def lasting(self) -> Mapping[str, Stuck]:
        """Signals that are still stuck, by name."""
        return dict(self._open)

    def facts(self, units: Mapping[str, str]) -> tuple[Fact, ...]:
        """Stuck signals with their spans and values, each with the remedy where it was removed."""
        found = []
        for name in dict.fromkeys(each.name for each in self.spans()):
            times = [each for each in self.spans() if each.name == name]
            listed = ", ".join(_when(each, units.get(name, "")) for each in times[:NAMED])
            others = len(times) - NAMED
            more = "" if others < 1 else " and once more" if others == 1 else f" and {others} more times"
            passed = name in self.passed_on
            used = "other signals show that it should have moved" if passed else "not used there"
            cause = f"{name} is stuck {listed}{more}: {used}; check the sensor and its messages"
            spans = f"{', '.join(map(_span, times[:NAMED]))}{' and later' * (others > 0)}"
            action = "" if passed else f"repair or check {name}: it was stuck {spans}"
            found.append(Fact("stuck", cause, action=action, rests_on=(name,)))
        return tuple(found)

    def _watch(self, kept: np.ndarray, recording: Recording) -> np.ndarray:
        """Whether each signal is stuck at the given times, (times, signals); also updates the spans."""
        assert self._block is not None
        stop = float(kept[-1]) + 0.5 / self._rate
        seen = recording.align(
            self._block.all_names, self._rate, maximum_age=MAXIMUM_AGE, start=float(kept[0]), stop=stop
        )
        assert self._scanner is not None
        result = self._scanner.scan(seen, self._memory)
        self._memory = result.state
        flags = result.values > 0.0
        before = np.vstack([self._flags, flags[:-1]])
        for at, column in np.argwhere(flags != before).tolist():
            name, time = self.names[column], float(kept[at])
            if flags[at, column]:
                value = float(seen.values[at, column])
                self._open[name] = Stuck(name, time - float(result.values[at, column]), time, None, value)
            else:
                self._closed.append(replace(self._open.pop(name), end=time))
        return flags


def _span(each: Stuck) -> str:
    return f"from {each.start:.1f} s {'on' if each.end is None else f'to {each.end:.1f} s'}"


def _when(each: Stuck, unit: str) -> str:
    return f"at {in_words(each.value, unit, 4)} {_span(each)}"
