"""One compiled step of a monitor at every tick of its grid, ahead of the pieces by which a drive is judged.

A piece is judged like a recording, with derived signals, stuck signals, the spread of parameters, and figures for the
report. It waits for late frames, and costs some milliseconds. A tick takes the newest value of every signal within its
maximum age, steps the monitor's block, and gives its verdict within one period of its grid. If the frames arrived in
order, both use the same samples, and the states agree to the last bit. Every piece is compared; where a late frame or a
stuck signal made a difference, the ticks continue from the state of the piece.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Memory, Scanner, Stream
from tierod.core.recording import Channel
from tierod.core.statement import STATUSES
from tierod.io.derive import RECIPES, Recipe
from tierod.live.newest import Newest
from tierod.monitors.harness.run import ROUNDING, Run
from tierod.monitors.harness.session import BlockSession, StatusChange

DERIVED = ("vehicle_speed", "steering_wheel_rate")
"""Signals that a tick can derive from others."""

STATED = "statement.status"
"""Output of a block that holds the status of its estimate."""

LEAP = 10.0
"""Time without a frame after which ticks are suspended until the next piece [s]."""

MOST = 40_000
"""Largest number of steps between two pieces: four seconds of the fastest monitor."""


def needed(run: Run) -> tuple[str, ...]:
    """Signals from which the derived signals of a run are made."""
    session = run.session
    derived = [name for name in getattr(session, "signals", ()) if name in DERIVED]
    return tuple(dict.fromkeys(need for name in derived for need in RECIPES[name].needs))


class Ticker:
    """Steps the block of one run.

    Args:
        run: run that has begun, with a session that runs a block
        newest: newest values of the signals

    `live` is whether its state continues that of the pieces, `status` is the current verdict with its start, and
    `changed` whether that is new; `corrected` counts pieces whose state differed.
    """

    def __init__(self, run: Run, newest: Newest):
        assert isinstance(run.session, BlockSession)
        self._session, self._run, self._newest = run.session, run, newest
        self.status: StatusChange | None = None
        self.changed = False
        self.live = False
        self.steps = self.corrected = 0
        self._index = -1
        self._stuck: list[int] = []
        self._rows: deque[tuple[float, ...]] = deque(maxlen=MOST)
        self._stream: Stream[Any, Any, Any] | None = None
        self._limit = run.monitor.maximum_age + min(0.5 / run.monitor.rate, ROUNDING)
        self._arrange()

    @staticmethod
    def suits(run: Run) -> bool:
        """Whether a run can be stepped: its session runs a block, and a tick can derive the signals it needs."""
        made = set(run.session.signals) & set(RECIPES)
        return isinstance(run.session, BlockSession) and made <= set(DERIVED)

    def _arrange(self) -> None:
        """Bind the block and the signals; repeated when the session has replaced its block."""
        session = self._session
        self._block = session.block
        self._scanner: Scanner[Any, Any, Any] = Scanner(session.block)
        self._names = self._scanner.names
        self._bind()
        self.live, self._stream = False, None
        self._rows.clear()
        self._index = -1

    def _bind(self) -> None:
        places = self._newest.places
        self._sources = [places.get(name, -1) for name in self._names]
        self._derived = [
            (column, RECIPES[name], tuple(self._newest.past[need] for need in RECIPES[name].needs))
            for column, name in enumerate(self._names)
            if name not in places and name in RECIPES and all(each in self._newest.past for each in RECIPES[name].needs)
        ]
        self._bound = len(places)

    def begin(self) -> None:
        """Start from the state of the piece that was judged last."""
        self._index = self._run.steps
        self.settle()

    def read(self, newest: Newest) -> None:
        """Take the signals from another source from now on."""
        self._newest = newest
        self._bind()

    @property
    def rate(self) -> float:
        """Rate of the ticks [Hz]."""
        return self._run.monitor.rate

    @property
    def due(self) -> float:
        """Time of the next step; frames with a later stamp do not belong to it [s]."""
        if self._index < 0:
            return -math.inf
        return self._time(self._index) + ROUNDING

    def _time(self, index: int) -> float:
        return float(self._run.start + index / self._run.monitor.rate)

    def advance(self, until: float) -> None:
        """Make all steps that no frame from this time on can change.

        Args:
            until: stamp of the next frame [s]
        """
        if self._index < 0 or until - self._time(self._index) > LEAP:
            self._leap(until)
        if len(self._newest.places) != self._bound:
            self._bind()
        while (time := self._time(self._index)) + ROUNDING < until:
            self._step(time)
            self._index += 1

    def _leap(self, until: float) -> None:
        self.live = False
        self._rows.clear()
        self._index = math.ceil((until - self._run.start) * self._run.monitor.rate)

    def _step(self, time: float) -> None:
        values, times, limit = self._newest.values, self._newest.times, self._limit
        row = [values[place] if place >= 0 and time - times[place] <= limit else math.nan for place in self._sources]
        for column, recipe, past in self._derived:
            row[column] = _derived(recipe, past, time, limit)
        for column in self._stuck:
            row[column] = math.nan
        self._rows.append(tuple(row))
        if self.live and self._stream is not None:
            self._stream.inputs[:] = row
            self._stream.advance()
            self.steps += 1
            self._follow(time)

    @property
    def _running(self) -> tuple[str, Sequence[Status]] | None:
        """Output with the code of the verdict, and statuses by code: the session's own, else that of the block."""
        if self._session.running is not None:
            return self._session.running
        return (STATED, STATUSES) if STATED in self._scanner.outputs else None

    def _follow(self, time: float) -> None:
        running = self._running
        if running is None or self._stream is None:
            return
        status = running[1][round(self._stream.outputs[self._code])]
        if self.status is None or status is not self.status.status:
            self.status, self.changed = StatusChange(time, status), True

    def settle(self) -> None:
        """Compare with a judged piece, and continue from its state where a late frame made a difference."""
        if self._session.block is not self._block:
            self._arrange()
        removed = self._run.removed
        self._stuck = [column for column, name in enumerate(self._names) if name in removed]
        memory = self._session.memory
        if memory is None or self._index < 0:
            return
        done = self._run.steps
        # The piece has judged these steps already.
        while self._rows and self._index - len(self._rows) < done:
            self._rows.popleft()
        # Rows are missing after a leap or an overflow: the state cannot be compared, nor continued.
        if self._index - len(self._rows) != done:
            self.live = False
            return
        expected = self._scanner.scan(np.array(self._rows), memory).state if self._rows else memory
        if self.live and self._stream is not None and _alike(self._stream.state, expected):
            return
        self.corrected += self.live
        self._stream, self.live = Stream(self._block, expected), True
        names = self._scanner.outputs
        running = self._running
        self._code = names.index(running[0]) if running is not None else 0
        self._places = {name: names.index(output) for name, output in self._session.shown_outputs.items()}
        if self._session.course:
            self.status = self._session.course[-1]

    def values(self) -> dict[str, float]:
        """Block outputs at the last tick by their names in the report, without deviations, which pieces widen."""
        if not self.live or self._stream is None or not self.steps:
            return {}
        outputs = self._stream.outputs
        return {name: float(outputs[at]) for name, at in self._places.items() if "deviation" not in name}


def _alike(first: Memory, second: Memory) -> bool:
    return first.count == second.count and np.array_equal(first.values, second.values, equal_nan=True)


def _derived(recipe: Recipe, past: Sequence[deque[tuple[float, float]]], time: float, limit: float) -> float:
    """The newest value of a derived signal; NaN where it is too old."""
    channels = []
    for name, samples in zip(recipe.needs, past, strict=True):
        table = np.array(samples, float).reshape(-1, 2)
        channels.append(Channel(name, table[:, 0], table[:, 1], ""))
    made = recipe.make(*channels)
    known = len(made.time) and time - made.time[-1] <= limit
    return float(made.values[-1]) if known else math.nan
