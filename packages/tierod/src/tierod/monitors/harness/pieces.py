"""Reading a recording in pieces, and joining the pieces so that the cuts do not affect any result."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Aligned, Recording
from tierod.io.readers import SHARE_READ
from tierod.io.readers.reading import measured
from tierod.vehicles import Vehicle
from tierod.vehicles.reading import read_by

CHUNK = 120.0  # Duration of one piece in memory [s]; the outputs of a monitor over ten minutes would take 120 MB more

# Longest pause of a recording [s], a night between two drives; a longer leap means that the clock was set
LEAP = 86400.0

# Duration of the previous piece that is kept [s]: longer than any maximum age and any memory of a derived signal
OVERLAP = 1.0


def pieces_of(
    source: Recording | str | Path,
    needs: Iterable[str] | None,
    vehicle: Vehicle,
    dbc: Any = None,
    channel_map: Any = None,
    seconds: float = CHUNK,
) -> Iterator[Recording]:
    """Pieces of a recording in the order of time; a recording in memory is a single piece.

    Args:
        needs: channels to be read; None for all
        seconds: duration of a piece [s]
    """
    if isinstance(source, Recording):
        yield measured(source)
        return
    from tierod.io.readers import open_chunks

    databases, used = read_by(vehicle, dbc, channel_map)
    yield from open_chunks(source, seconds=seconds, names=needs, dbc=databases, channel_map=used)


def refuse_leap(last: float, following: float) -> None:
    """Refuse a pause in which the clock was set.

    Args:
        last: time of the last sample before the pause [s]
        following: time of the first sample after it [s]
    """
    if following - last > LEAP:
        raise InputError(
            f"the time jumps ahead from about {last:.6g} s by {(following - last) / 86400.0:.3g} days; cut the "
            "recording there and judge the parts one by one"
        )


def share_read(piece: Recording) -> float:
    """Share of the recording that has been read at the end of a piece, 0 to 1."""
    return float(piece.metadata.get(SHARE_READ, 1.0))


def joined(before: Recording | None, piece: Recording) -> Recording:
    """Piece with the end of the previous one in front of it."""
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
            if key not in clocks:  # channels of one message go on sharing one array, so that it is searched only once
                clocks[key] = np.concatenate([old.time, new.time])
            channels[name] = dataclasses.replace(new, time=clocks[key], values=np.concatenate([old.values, new.values]))
    return Recording(channels, piece.metadata)


def together(parts: Sequence[Aligned]) -> Aligned:
    """Join consecutive parts of one grid."""
    if len(parts) == 1:
        return parts[0]
    time, values = (np.concatenate(each) for each in zip(*((p.time, p.values) for p in parts), strict=True))
    return Aligned(time, values, parts[0].names)


PAUSE = 2.0  # Time without a sample from which a stretch counts as a pause [s]; all held values have expired by then

# Longest part of a pause that a monitor receives as missing samples [s]: variances grow and verdicts lapse in that
# time, and nothing changes afterwards
LONGEST = 600.0

# Total time of pauses, beyond the time with samples, that is judged with up to `LONGEST` each [s]; further pauses get
# `PAUSE` each, so that the work grows with the samples and not with their time stamps
MOST = 3600.0


class Stretch(NamedTuple):
    """Stretch of time to be judged [s]: from `skip_to`, or the end of the previous stretch if later, until `stop`."""

    skip_to: float
    stop: float


class Silence:
    """Follows the pauses in the signals of a monitor from piece to piece."""

    def __init__(self) -> None:
        self._first: float | None = None
        self._last_sample: float | None = None
        self._paused = 0.0
        self._judged = 0.0

    def stretches(self, stamps: Iterable[np.ndarray], begin: float, stop: float) -> Iterator[Stretch]:
        """Stretches of a piece to be judged, in the order of time.

        Args:
            stamps: time stamps of every signal of the piece [s]
            begin: begin of the piece [s]
            stop: end of the piece [s]
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
        """Time after the begin of a pause that is still judged [s]."""
        assert self._first is not None
        sampled = pause - self._first - self._paused
        return LONGEST if self._judged + LONGEST <= MOST + sampled else PAUSE

    def _pauses(self, stamps: list[np.ndarray], begin: float) -> Iterator[tuple[float, float]]:
        """Last sample before and first sample after every pause that ends in a piece [s]."""
        assert self._last_sample is not None
        parts = [each[np.searchsorted(each, begin) :] for each in stamps]
        parts = [each for each in parts if len(each)]
        if not parts:
            return
        last = max(float(each[-1]) for each in parts)
        # Shortcut: a single signal without a gap rules out any pause, and spares the merging of all time stamps.
        gapless = (each for each in parts if each[0] - self._last_sample <= PAUSE and last - each[-1] <= PAUSE)
        if not any(float(np.diff(each).max(initial=0.0)) <= PAUSE for each in gapless):
            together = np.unique(np.concatenate([[self._last_sample], *parts]))
            at = np.flatnonzero(np.diff(together) > PAUSE)
            yield from zip(together[at].tolist(), together[at + 1].tolist(), strict=True)
        self._last_sample = last
