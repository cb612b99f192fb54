"""Judging while driving: frames are ordered, decoded, and passed to every monitor that can run."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from tierod.core.errors import OutputError, TierodError
from tierod.core.findings import Diagnosis
from tierod.core.recording import Channel, Recording
from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.frames import Frames, taken
from tierod.io.readers.mapping import Plan as Mapping_
from tierod.io.readers.mapping import plan as mapping
from tierod.io.readers.reading import Doubts, completed, made_from
from tierod.live.clock import DriveClock, Frame, Gaps, frames_of, sentences
from tierod.live.decoding import Decoder
from tierod.live.judge import Judge, Plan, Shown

if TYPE_CHECKING:
    from cantools.database.can import Message

    from tierod.live.log import FrameLog
    from tierod.monitors.memory import MemoryFeed

Say = Callable[[str, Mapping[str, Any]], None]  # Function that receives an event: its kind and its content


@dataclass(frozen=True)
class Pace:
    """Periods and waiting times of the live engine."""

    # length of a piece that is judged; each piece costs a monitor some milliseconds
    period: Annotated[float, "s"] = 0.5
    order: Annotated[float, "s"] = 0.3  # frames that arrive later than this behind newer ones are not judged
    # time before the first judgement, in which the frames on the buses are registered
    listening: Annotated[float, "s"] = 3.0
    oldest: Annotated[float, "s"] = 0.5  # age beyond which a signal is reported as missing


PACE = Pace()


@dataclass
class _Stream:
    """Input of one monitor: its columns, and the previous piece."""

    names: tuple[str, ...]
    plan: Mapping_ | None = None
    version: int = -1
    doubts: Doubts = field(default_factory=Doubts)
    past: Recording | None = None


@dataclass(frozen=True)
class Piece:
    """Frames that are judged together."""

    frames: Sequence[Frame]
    until: float  # end of the piece in the time of the drive [s]
    rest: bool  # whether this is the last piece of the drive
    log: str


@dataclass
class Tally:
    """Counts of frames over the drive: received, and too late to be judged."""

    frames: int = 0
    too_late: int = 0


class Engine:
    """Judges one drive.

    Args:
        channel_map: conversion into canonical signals; None assigns them by their names
        log: log of the frames; None for none
        ignition: column of the databases ("Message.Signal") whose zero ends the drive; "" for none

    `heard` is called with the frames on arrival, with times of the drive.
    """

    def __init__(
        self,
        database: Sequence[Message],
        channel_map: ChannelMap | None,
        monitors: Sequence[str],
        plan: Plan,
        say: Say = lambda kind, content: None,
        pace: Pace = PACE,
        log: FrameLog | None = None,
        ignition: str = "",
    ):
        self.plan, self.pace, self.say, self.log = plan, pace, say, log
        self.judges = [Judge(name, plan) for name in monitors]
        self.clock, self.decoder, self.gaps, self.tally = DriveClock(), Decoder(database), Gaps(), Tally()
        self.ages: dict[str, float] = {}
        self.heard: Callable[[Sequence[Frame]], None] = lambda frames: None
        self.ignition = ignition
        self.ignition_off = False
        self._map = channel_map
        self._streams = {judge.name: _Stream(judge.needs) for judge in self.judges}
        self._waiting: list[Frame] = []
        self._ignition_on = False
        self._until = -np.inf
        self._first = np.inf
        self._newest: dict[str, float] = {}
        self._statuses: dict[str, tuple[str, str]] = {}
        self._problems: set[str] = set()

    def take(self, frames: Iterable[Frame], came: float | None = None, calendar: float | None = None) -> None:
        """Take frames as the buses deliver them.

        Args:
            came: time of arrival by the computer's clock [s]; now if not given
            calendar: calendar time of the computer [s]; now if not given
        """
        now, today = clock.monotonic() if came is None else came, clock.time() if calendar is None else calendar
        placed = [each for frame in frames if (each := self.clock.placed(frame, now, today)) is not None]
        if not placed:
            return
        self.heard(placed)
        self.tally.frames += len(placed)
        self._first = min(self._first, placed[0].time)
        self._waiting += placed
        if self.log is not None:
            try:
                self.log.append(placed)
            except OutputError as error:
                self.say("problem", {"text": f"{error}; monitoring goes on without a log"})
                self.log = None

    @property
    def due(self) -> bool:
        """Whether a piece is complete and can be judged."""
        begin = self._first + self.pace.listening if self._until == -np.inf else self._until + self.pace.period
        return self.clock.latest - self.pace.order >= begin

    def judge(self, rest: bool = False) -> None:
        """Judge the frames received so far in the calling thread.

        Args:
            rest: whether to include the last frame, at the end of a drive
        """
        piece = self.cut(rest)
        if piece is not None:
            self.work(piece)
            self.settle(piece)

    def cut(self, rest: bool = False) -> Piece | None:
        """Piece of the frames received so far that is to be judged; None where there are none.

        `work` judges it, in any thread; `settle` completes it, in the thread that takes frames, before the next is cut.

        Args:
            rest: whether to include the last frame, at the end of a drive
        """
        until = np.inf if rest else self.clock.latest - self.pace.order
        parts = [frame for frame in self._waiting if frame.time < until]
        self._waiting = [frame for frame in self._waiting if frame.time >= until]
        late = sum(frame.time < self._until for frame in parts)
        if late:
            self.tally.too_late += late
            parts = [frame for frame in parts if frame.time >= self._until]
        self._until = self.clock.latest if rest else until
        return (
            Piece(parts, self._until, rest, str(self.log.path) if self.log is not None else "live") if parts else None
        )

    def work(self, piece: Piece) -> None:
        """Judge a piece; shares no state with `take`, so that both may run in different threads."""
        frames = frames_of(piece.frames, self.clock.origin)
        frames = taken(frames, np.argsort(frames.time, kind="stable"))
        self.decoder.hear(frames)
        for text in sentences(self.gaps.add(frames)):
            self.say("silence", {"time": piece.until, "text": text})
        if self.decoder.known is None:
            for judge in self.judges:
                judge.reason = judge.reason if judge.broken else "no received frame is in the databases"
            return
        self._look_at_ignition(frames)
        for judge in self.judges:
            if not judge.broken:
                self._feed(judge, self._streams[judge.name], frames, piece)

    def settle(self, piece: Piece) -> None:
        """Report the verdicts that a judged piece changed."""
        if self.decoder.known is not None:
            self._note_changes()

    def _feed(self, judge: Judge, stream: _Stream, frames: Frames, cut: Piece) -> None:
        known = self.decoder.known
        assert known is not None
        if stream.plan is None or stream.version != self.decoder.version:
            try:
                stream.plan = mapping(known.columns, self._map, stream.names, known.silent)
            except TierodError as error:
                judge.reason = str(error)
                return
            stream.version = self.decoder.version
        if not stream.plan.picks:
            judge.reason = "none of its signals is received on the bus"
            return
        try:
            channels = made_from(stream.plan, self.decoder.channels(frames, stream.plan.columns), stream.doubts)
        except TierodError as error:
            judge.reason = str(error)
            return
        self._follow(channels, cut)
        if not any(len(channel.time) for channel in channels):
            return
        metadata = {"format": "live", "origin": self.clock.origin, "path": cut.log}
        piece = Recording({channel.name: channel for channel in channels}, metadata)
        piece = completed(piece.warned(*stream.plan.warnings), stream.past, stream.names)
        stream.past = piece
        judge.add(piece)
        if judge.memory_problem and judge.memory_problem not in self._problems:
            self._problems.add(judge.memory_problem)
            self.say("problem", {"text": f"{judge.memory_problem}; monitoring goes on without the fault memory"})

    def _look_at_ignition(self, frames: Frames) -> None:
        known = self.decoder.known
        if not self.ignition or known is None or self.ignition not in known.places:
            return
        (channel,) = self.decoder.channels(frames, [self.ignition])
        if len(channel.values):
            on = bool(channel.values[-1] > 0.5)
            self.ignition_off = self._ignition_on and not on
            self._ignition_on |= on

    def _follow(self, channels: Sequence[Channel], cut: Piece) -> None:
        # Ages refer to the time at which the piece was cut: further frames arrive while it is judged.
        now = cut.until if cut.rest else cut.until + self.pace.order
        for channel in channels:
            if len(channel.time):
                self._newest[channel.name] = max(self._newest.get(channel.name, -np.inf), float(channel.time[-1]))
        self.ages = {name: now - newest for name, newest in self._newest.items()}

    @property
    def missing(self) -> tuple[str, ...]:
        """Signals that were received before and are overdue now."""
        return tuple(name for name, age in self.ages.items() if age > self.pace.order + self.pace.oldest)

    def shown(self) -> list[Shown]:
        """States of all monitors for display."""
        return [judge.shown() for judge in self.judges]

    @property
    def delay(self) -> float:
        """Longest delay of a verdict [s]: a piece, and the time in which frames out of order are awaited."""
        return self.pace.period + self.pace.order

    def _note_changes(self) -> None:
        for each in self.shown():
            now = (str(each.status), each.reason)
            if self._statuses.get(each.monitor) != now:
                self._statuses[each.monitor] = now
                time = max(each.since, self._until)
                content = {"time": time, "monitor": each.monitor, **each.status.document(), "since": each.since}
                self.say("verdict", content | ({"reason": each.reason} if each.reason else {}))

    @property
    def identity(self) -> str:
        """Identity of this drive among all others: calendar time of its origin, and time of its first frame."""
        return f"live {self.clock.origin:.0f} {self._first:.6f}"

    def finish(self) -> list[tuple[Judge, Diagnosis, MemoryFeed | None]]:
        """Judge the rest and finish the log; diagnosis and memory feed of every monitor that ran."""
        self.judge(rest=True)
        ended = [(judge, own) for judge in self.judges if (own := judge.conclude()) is not None]
        found = []
        for judge, own in ended:
            if (done := judge.finish(own, [each for _, each in ended if each is not own])) is not None:
                found.append((judge, *done))
        if self.log is not None:
            try:
                self.log.finish()
            except OutputError as error:
                self.say("problem", {"text": str(error)})
        return found


class Judging:
    """Judges pieces in a thread, which delays neither log nor display; its scheduling does not change the result.

    Args:
        threaded: whether a thread judges; else `begin` does
    """

    def __init__(self, threaded: bool):
        self._pool = ThreadPoolExecutor(1, "judge") if threaded else None
        self._piece: Piece | None = None
        self._future: Future[None] | None = None

    @property
    def busy(self) -> bool:
        """Whether a piece is being judged, or was judged and is not settled yet."""
        return self._piece is not None

    def begin(self, engine: Engine) -> None:
        """Judge the frames received so far; must not be called while `busy`."""
        piece = self._piece = engine.cut()
        if piece is None:
            return
        if self._pool is None:
            engine.work(piece)
        else:
            self._future = self._pool.submit(engine.work, piece)

    def ended(self, engine: Engine, wait: bool = False) -> bool:
        """Whether a piece was judged since the last call.

        Args:
            wait: whether to wait for a piece that is being judged
        """
        if self._piece is None or (self._future is not None and not wait and not self._future.done()):
            return False
        if self._future is not None:
            self._future.result()
        piece, self._piece, self._future = self._piece, None, None
        engine.settle(piece)
        return True

    def close(self) -> None:
        """End the thread after its current work."""
        if self._pool is not None:
            self._pool.shutdown()
