"""Pauses of a recording: the beginning of each is judged as missing samples, the rest is skipped."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from tierod.monitors.harness.pieces import refuse_leap

PAUSE = 2.0
"""Time without a sample from which on a stretch is a pause [s]; every held value has expired by then."""

LONGEST = 600.0
"""Time of a pause that is judged as missing [s]: uncertainty grows, verdicts lapse; later nothing changes any more."""

MOST = 3600.0
"""Time of pauses beyond the time with samples that is judged at `LONGEST` [s]; of further ones `PAUSE` each, so that
work grows with the samples, not with their stamps."""


class Stretch(NamedTuple):
    """A stretch of time to be judged [s]: from where the last one ended, or where `skip_to` says, until `stop`."""

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
        """What of a piece is judged, in the order of time; the result does not depend on how the recording is cut.

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
