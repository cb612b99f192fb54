"""A recording piece by piece, and the joining of the pieces so that no cut has an effect."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Aligned, Recording
from tierod.io.readers import SHARE_READ
from tierod.vehicles import Vehicle
from tierod.vehicles.reading import read_by

CHUNK = 120.0
"""Seconds of recording in memory at a time: what a monitor gives over ten minutes takes 120 MB more."""

LEAP = 86400.0
"""Seconds that a recording may be silent, a night between two drives; a clock that leaps further was set."""

OVERLAP = 1.0
"""Seconds kept of the piece before: longer than any sample may be old and any derived signal looks back."""


def pieces_of(
    source: Recording | str | Path, needs: Iterable[str], vehicle: Vehicle, dbc: Any, channel_map: Any
) -> Iterator[Recording]:
    """The pieces of a file, one after the other; a recording in memory is a single one.

    Args:
        source: a recording, or the path of one
        needs: channels that are read
        vehicle: whose CAN databases and channel map are taken where none are given
        dbc: path(s) of CAN databases
        channel_map: path of a channel map

    Raises:
        InputError: the file cannot be read
    """
    if isinstance(source, Recording):
        yield source
        return
    from tierod.io.readers import open_chunks

    databases, used = read_by(vehicle, dbc, channel_map)
    yield from open_chunks(source, seconds=CHUNK, names=needs, dbc=databases, channel_map=used)


def refuse_leap(last: float, following: float) -> None:
    """Refuse a pause in which a clock was set.

    Args:
        last: time of the last sample before the pause [s]
        following: time of the first sample after it [s]

    Raises:
        InputError: more than `LEAP` lies between
    """
    if following - last > LEAP:
        raise InputError(
            f"the time leaps ahead from about {last:.6g} s by {(following - last) / 86400.0:.3g} days; "
            "cut the recording there and judge the parts one by one"
        )


def share_read(piece: Recording) -> float:
    """Share of the recording up to the end of a piece, 0 to 1."""
    return float(piece.metadata.get(SHARE_READ, 1.0))


def joined(before: Recording | None, piece: Recording) -> Recording:
    """The piece with the end of the one before in front of it."""
    if before is None:
        return piece
    channels = dict(piece.channels)
    clocks: dict[tuple[int, int], np.ndarray] = {}
    for name, old in before.channels.items():
        new = channels.get(name)
        if new is None:
            channels[name] = old
        else:
            key = id(old.time), id(new.time)
            if key not in clocks:  # stamps that channels share stay shared, so that they are searched once
                clocks[key] = np.concatenate([old.time, new.time])
            channels[name] = dataclasses.replace(new, time=clocks[key], values=np.concatenate([old.values, new.values]))
    return Recording(channels, piece.metadata)


def together(parts: Sequence[Aligned]) -> Aligned:
    """Consecutive parts of one grid as one.

    Args:
        parts: at least one
    """
    if len(parts) == 1:
        return parts[0]
    time, values = (np.concatenate(each) for each in zip(*((p.time, p.values) for p in parts), strict=True))
    return Aligned(time, values, parts[0].names)


PAUSE = 2.0
"""Time without a sample from which on a stretch is a pause [s]; every held value has expired by then."""

LONGEST = 600.0
"""Time of a pause that is judged as missing [s]: uncertainty grows, verdicts lapse; later nothing changes any more."""

MOST = 3600.0
"""Time of pauses beyond the time with samples that is judged at `LONGEST` [s]; of further ones `PAUSE` each, so that
work grows with the samples, not with their stamps."""


class Stretch(NamedTuple):
    """A stretch of time to be judged [s]: from the end of the last one, or from `skip_to`, until `stop`."""

    skip_to: float
    stop: float


class Silence:
    """Follows the pauses of the signals of a monitor from piece to piece."""

    def __init__(self) -> None:
        self._first: float | None = None
        self._last_sample: float | None = None
        self._paused = 0.0
        self._judged = 0.0

    def stretches(self, stamps: Iterable[np.ndarray], begin: float, stop: float) -> Iterator[Stretch]:
        """Stretches of a piece to judge, in the order of time; the result does not depend on how the recording is cut.

        Args:
            stamps: of every signal of the piece [s]
            begin: of the piece [s]
            stop: of the piece [s]

        Raises:
            InputError: a pause is so long that a clock was set
        """
        if self._first is None or self._last_sample is None:
            self._first = self._last_sample = begin
        resume = self._last_sample
        for pause, end in self._pauses(list(stamps), begin):
            refuse_leap(pause, end)
            limit = pause + self._allowed(pause)
            self._judged += min(limit, end) - pause
            self._paused += end - pause
            if limit < end:
                yield Stretch(resume, limit)
                resume = end
        yield Stretch(resume, min(stop, self._last_sample + self._allowed(self._last_sample)))

    def _allowed(self, pause: float) -> float:
        """Time of a pause that is judged [s]."""
        assert self._first is not None
        sampled = pause - self._first - self._paused
        return LONGEST if self._judged + LONGEST <= MOST + sampled else PAUSE

    def _pauses(self, stamps: list[np.ndarray], begin: float) -> Iterator[tuple[float, float]]:
        """(last sample before, first sample after) of every pause that ends in a piece."""
        assert self._last_sample is not None
        parts = [each[np.searchsorted(each, begin) :] for each in stamps]
        parts = [each for each in parts if len(each)]
        if not parts:
            return
        last = max(float(each[-1]) for each in parts)
        gapless = (each for each in parts if each[0] - self._last_sample <= PAUSE and last - each[-1] <= PAUSE)
        if not any(float(np.diff(each).max(initial=0.0)) <= PAUSE for each in gapless):
            together = np.unique(np.concatenate([[self._last_sample], *parts]))
            at = np.flatnonzero(np.diff(together) > PAUSE)
            yield from zip(together[at].tolist(), together[at + 1].tolist(), strict=True)
        self._last_sample = last
