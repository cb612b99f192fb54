"""Running statistics of a drive that is fed piece by piece; no result depends on where the drive is cut."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.series import last_true


class Blocks:
    """Rows of a drive in blocks of equal length; rows that do not fill a block wait for the next piece."""

    def __init__(self, size: int, columns: int):
        self.size = size
        self._rest = np.empty((0, columns))

    def add(self, rows: np.ndarray) -> np.ndarray:
        """The blocks that the next rows (n, columns) complete, (blocks, size, columns)."""
        rows = np.vstack([self._rest, rows])
        count = len(rows) // self.size
        self._rest = rows[count * self.size :]
        return rows[: count * self.size].reshape(count, self.size, rows.shape[1])


class Share:
    """Share of the samples for which a flag holds, and the time of the last one [s]; None before the first."""

    def __init__(self) -> None:
        self.count = self.true = 0
        self.last: float | None = None

    def add(self, time: np.ndarray, flags: np.ndarray) -> None:
        self.count += len(flags)
        self.true += int(np.count_nonzero(flags))
        if (at := last_true(flags)) is not None:
            self.last = float(time[at])


class Span(NamedTuple):
    start: Annotated[float, "s"]
    end: Annotated[float, "s"]  # infinite while the flag holds
    samples: int

    @property
    def duration(self) -> float:
        return self.end - self.start


class Spans:
    """Spans of samples for which a flag holds; short ones are left out, and no more than `most` are kept."""

    def __init__(self, fewest: float = 0.0, most: int = 1000):
        self._fewest, self._most = fewest, most
        self._kept: list[Span] = []
        self._open: Span | None = None

    def add(self, time: np.ndarray, flags: np.ndarray) -> None:
        """Add the next samples (n,); the first one is compared with the end of the previous piece."""
        before = 0
        for place in np.flatnonzero(np.diff(flags, prepend=self._open is not None)).tolist():
            if self._open is None:
                self._open = Span(float(time[place]), math.inf, 0)
            else:
                closed = Span(self._open.start, float(time[place]), self._open.samples + place - before)
                self._open = None
                if closed.samples > self._fewest and len(self._kept) < self._most:
                    self._kept.append(closed)
            before = place
        if self._open is not None:
            self._open = self._open._replace(samples=self._open.samples + len(flags) - before)

    def found(self) -> list[Span]:
        return [*self._kept, *([self._open] if self._open is not None else ())]


class Moments:
    """Means of signals, and their products about the means, over the samples at which all are known."""

    def __init__(self, signals: int = 2):
        self.count = 0
        self.means = np.zeros(signals)
        self.products = np.zeros((signals, signals))

    def add(self, *signals: np.ndarray) -> Moments:
        """Add the next samples, (n,) each; NaN where missing."""
        rows = np.column_stack(signals)
        rows = rows[np.isfinite(rows).all(axis=1)]
        if len(rows):
            # About the means of this piece, so that a large mean causes no cancellation (Chan, Golub, LeVeque 1983).
            mean, total = rows.mean(axis=0), self.count + len(rows)
            away, step = rows - mean, mean - self.means
            self.products += away.T @ away + np.outer(step, step) * (self.count * len(rows) / total)
            self.means += step * (len(rows) / total)
            self.count = total
        return self

    def correlation(self, first: int = 0, second: int = 1) -> float:
        """Correlation coefficient; 0 where one of the two does not change."""
        power = self.products[first, first] * self.products[second, second]
        return float(self.products[first, second] / math.sqrt(power)) if power > 0.0 else 0.0

    def ratio(self, first: int = 0, second: int = 1) -> float:
        """Standard deviation of the second over that of the first; NaN where one of the two does not change."""
        least = min(self.products[first, first], self.products[second, second])
        return math.sqrt(self.products[second, second] / self.products[first, first]) if least > 0.0 else math.nan

    def deviation(self, signal: int = 0) -> float:
        return math.sqrt(self.products[signal, signal] / self.count) if self.count else math.nan


class Sizes:
    """Histogram of magnitudes in bins that grow by 5 %, whose quantiles do not depend on the order of the samples."""

    SMALLEST, GROWTH, BINS = 1e-6, math.log(1.05), 450

    def __init__(self) -> None:
        self.counts = np.zeros(self.BINS)

    def add(self, values: np.ndarray) -> None:
        places = np.log(np.maximum(np.abs(values), self.SMALLEST) / self.SMALLEST) / self.GROWTH
        self.counts += np.bincount(np.minimum(places.astype(int), self.BINS - 1), minlength=self.BINS)

    def quantile(self, share: float) -> float:
        """Magnitude below which a share of all lies: the middle of its bin."""
        at = int(np.searchsorted(np.cumsum(self.counts), share * self.counts.sum()))
        return self.SMALLEST * math.exp((at + 0.5) * self.GROWTH)


class OuterLevels:
    """Number of samples on the lowest and on the highest levels of a quantised signal, which shows clipping."""

    KEPT = 4  # an extreme level and the three next to it

    def __init__(self) -> None:
        self.low: dict[float, int] = {}
        self.high: dict[float, int] = {}

    def add(self, values: np.ndarray) -> None:
        """Add finite samples, rounded to levels."""
        self.low = self._outer(self.low, values, 1.0)
        self.high = self._outer(self.high, values, -1.0)

    def _outer(self, known: dict[float, int], values: np.ndarray, sign: float) -> dict[float, int]:
        # Once all levels are taken, samples inside them cannot matter: this leaves few to be sorted.
        if len(known) == self.KEPT:
            inner = max(known) if sign > 0.0 else min(known)
            values = values[values <= inner if sign > 0.0 else values >= inner]
            if not len(values):
                return known
        found = dict(known)
        for level, count in zip(*(part.tolist() for part in np.unique(values, return_counts=True)), strict=True):
            found[level] = found.get(level, 0) + count
        return {level: found[level] for level in sorted(found, key=lambda level: sign * level)[: self.KEPT]}

    def ends(self) -> tuple[tuple[str, float, int, list[int]], ...]:
        """(side, extreme level, samples on it, samples on each of the next levels) of both ends."""
        return tuple(
            (side, *next(iter(counts.items())), list(counts.values())[1:])
            for side, counts in (("lower", self.low), ("upper", self.high))
            if counts
        )


def piles_up(count: int, nearby: list[int]) -> bool:
    """Whether a signal has so many samples on its extreme level that it is clipped there.

    On the next levels (`nearby`) a free signal has at least a quarter as many: it stays at its extreme no longer.
    """
    return count > 4 * max(nearby, default=1)


RATE = 50.0  # of the comparison [Hz]: steering moves below 5 Hz, and the peak of the correlation is interpolated
BLOCK = 1024  # samples, 20 s: many turns of the wheel, while a missing sample discards no more than one block
LONGEST = 50  # largest delay that is searched [samples]: one second
SPAN = 20  # of the differences that are compared [samples], 0.4 s: emphasises 0.4 to 2 Hz, where drivers steer


class Lag(NamedTuple):
    """Lag and gain of a second signal against a first."""

    delay: Annotated[float, "s"]  # negative if the first is late
    deviation: Annotated[float, "s"]  # of the delay, from its scatter between blocks
    correlation: float  # of the differences at that delay
    gain: float  # regression of the second signal on the first, slow turns included
    gain_correlation: float  # of the signals themselves at zero delay


@dataclass
class LaggedCorrelation:
    """Delay and gain between two signals that follow each other, by cross-correlation block by block."""

    # Least root mean square of the first signal's differences in a block; below it the block would compare noise.
    smallest: float
    _cross: np.ndarray = field(default_factory=lambda: np.zeros(2 * LONGEST + 1))
    _powers: np.ndarray = field(default_factory=lambda: np.zeros(2))
    _slow: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))
    _delays: list[tuple[float, float]] = field(default_factory=list)

    def add(self, first: np.ndarray, second: np.ndarray, usable: np.ndarray | None = None) -> None:
        """Add one block of both signals, (BLOCK,) each; a block with missing samples is discarded.

        Args: usable: samples that are compared, (BLOCK,); all if None.
        """
        both = np.array([first, second])
        if not np.isfinite(both).all():
            return
        # Differences remove offsets, and steady turns, which contain no delay.
        first, second = both[:, SPAN:] - both[:, :-SPAN]
        if usable is not None:
            # The other samples of the second signal are kept beside those of the first, or the peak moves to zero.
            inside = usable[SPAN:] & usable[:-SPAN]
            first, near = np.where(inside, first, 0.0), np.convolve(inside, np.ones(2 * LONGEST + 1), "same") > 0.5
            second = np.where(near, second, 0.0)
        power = float(first @ first)
        if power < len(first) * self.smallest**2:
            return
        cross = cross_correlation(first, second, LONGEST)
        both -= both.mean(axis=1, keepdims=True)
        self._cross += cross
        self._powers += (power, float(second @ second))
        self._slow += both @ both.T
        self._delays.append((peak(cross)[0], power))

    def found(self) -> Lag | None:
        """Lag over the drive; None with fewer than two blocks, or if the second signal did not change."""
        norm, slow = math.sqrt(self._powers.prod()), self._slow
        if len(self._delays) < 2 or not norm > 0.0:
            return None
        lag, height = peak(self._cross)
        delays, weights = np.array(self._delays).T
        # Scatter between blocks with the weights of the sums; the interpolation is no better than a tenth of a sample.
        share = weights / weights.sum()
        spread = math.sqrt(float(share @ (delays - lag) ** 2) * float(share @ share))
        return Lag(
            lag / RATE,
            max(spread, 0.1) / RATE,
            height / norm,
            float(slow[0, 1] / slow[0, 0]),
            float(slow[0, 1] / math.sqrt(slow[0, 0] * slow[1, 1])),
        )


def cross_correlation(first: np.ndarray, second: np.ndarray, longest: int) -> np.ndarray:
    """Sums of first[i] second[i + k] for k from -longest to longest."""
    around = np.zeros(len(second) + 2 * longest)
    around[longest:-longest] = second
    return np.correlate(around, first)


def peak(cross: np.ndarray) -> tuple[float, float]:
    """(lag [samples] from the middle, value) of the peak of largest magnitude, by a parabola through its neighbours."""
    at, middle = int(np.argmax(np.abs(cross))), len(cross) // 2
    height = float(cross[at])
    if not 0 < at < len(cross) - 1:
        return float(at - middle), height
    left, right = float(cross[at - 1]), float(cross[at + 1])
    curvature = left - 2.0 * height + right
    shift = 0.5 * (left - right) / curvature if curvature != 0.0 else 0.0
    return at - middle + shift, height - 0.25 * (left - right) * shift
