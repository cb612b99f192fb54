"""Pauses of a recording: so much of each is judged as a verdict may need, and the rest costs nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from tierod.monitors.pieces import refuse_leap

PAUSE = 2.0
"""Seconds without a sample from which on a stretch is a pause; all that a signal can mean is over by then."""

LONGEST = 600.0
"""Seconds of a pause that are judged as missing: uncertainty grows, verdicts lapse. Later nothing changes any more."""

MOST = 3600.0
"""Seconds of pauses beyond the time with samples that are judged at `LONGEST`; of further ones `PAUSE` each, so that
work follows the samples, whatever their stamps are."""


class Stretch(NamedTuple):
    """A stretch of time to be judged [s]: from where the last one ended, or where `skip_to` says, until `stop`."""

    skip_to: float
    stop: float


class Silence:
    """Follows the pauses of the signals of a monitor from piece to piece."""

    def __init__(self) -> None:
        self._first: float | None = None
        self._heard: float | None = None
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
        if self._first is None or self._heard is None:
            self._first = self._heard = begin
        resume = self._heard
        for pause, end in self._pauses(list(stamps), begin):
            refuse_leap(pause, end)
            limit = pause + self._allowed(pause)
            self._judged += min(limit, end) - pause
            self._paused += end - pause
            if limit < end:
                yield Stretch(resume, limit)
                resume = end
        yield Stretch(resume, min(stop, self._heard + self._allowed(self._heard)))

    def _allowed(self, pause: float) -> float:
        """Seconds of a pause that are judged."""
        assert self._first is not None
        heard = pause - self._first - self._paused
        return LONGEST if self._judged + LONGEST <= MOST + heard else PAUSE

    def _pauses(self, stamps: list[np.ndarray], begin: float) -> Iterator[tuple[float, float]]:
        """(last sample before, first sample after) of every pause that ends in a piece."""
        assert self._heard is not None
        parts = [each[np.searchsorted(each, begin) :] for each in stamps]
        parts = [each for each in parts if len(each)]
        if not parts:
            return
        last = max(float(each[-1]) for each in parts)
        gapless = (each for each in parts if each[0] - self._heard <= PAUSE and last - each[-1] <= PAUSE)
        if not any(float(np.diff(each).max(initial=0.0)) <= PAUSE for each in gapless):
            together = np.unique(np.concatenate([[self._heard], *parts]))
            at = np.flatnonzero(np.diff(together) > PAUSE)
            yield from zip(together[at].tolist(), together[at + 1].tolist(), strict=True)
        self._heard = last
