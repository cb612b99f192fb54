"""Quality of recorded data, channel by channel: figures of stretches, which join to those of the whole."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import ChannelQuality
from tierod.core.recording import Channel
from tierod.core.series import longest_run, runs
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS, levels_of, residue_between
from tierod.io.readings import LEAST_RATE, held_remark, median_rate, readings_of, too_slow
from tierod.methods.running import OuterLevels, piles_up

# Limits beyond which a channel deserves a remark.
LONG_GAP = 0.1  # [s]; ten missed messages of a 10 ms bus
MANY_MISSING = 0.01  # share of missing samples
SATURATED, SATURATED_SAMPLES = 0.3, 10  # time [s] at the extreme that indicates saturation, not driving; least samples
FEW_LEVELS = 50  # number of distinct values below which the quantisation deserves a remark
IMPOSSIBLE = 10.0  # multiple of the plausible range that no faulty sensor exceeds; degrees taken for radians stay below
APPROACH = 0.1  # time before and after a run at the extreme over which the change is taken [s]: a hand needs 0.3 s


class Pace(NamedTuple):
    """Sampling pace of a set of time stamps; NaN with fewer than two."""

    rate: Annotated[float, "Hz"]  # from the median sampling interval
    span: Annotated[float, "s"]
    gap: Annotated[float, "s"]  # longest interval

    @classmethod
    def of(cls, time: np.ndarray) -> Pace:
        several = len(time) > 1
        gap = float(np.diff(time).max()) if several else math.nan
        return cls(median_rate(time), float(time[-1] - time[0]) if several else 0.0, gap)


class Saturation(NamedTuple):
    end: str  # "upper" or "lower"
    samples: int  # in a row
    extreme: float


@dataclass(frozen=True)
class Figures:
    """Figures of a channel over one stretch, or over several that are joined."""

    name: str
    unit: str
    source: str
    note: str
    samples: int
    missing: int
    begin: float  # first and last stamp [s]
    end: float
    pace: Pace  # the span without pauses between the stretches
    gap: float  # longest interval between samples that are not missing [s]
    least: float
    most: float
    levels: np.ndarray | None  # distinct values; None where there are many
    saturations: tuple[Saturation, ...]

    @classmethod
    def of(cls, channel: Channel, pace: Pace | None = None) -> Figures:
        """Figures of a stretch, whose pace may be known from another channel with the same stamps."""
        time, values = channel.time, channel.values
        pace = pace or Pace.of(time)
        good = np.isfinite(values)
        seen, gap = (values, pace.gap) if good.all() else (values[good], math.nan)
        if len(seen) < len(values) and len(seen) > 1:
            gap = float(np.diff(time[good]).max())
        least, most = (float(seen.min()), float(seen.max())) if len(seen) else (math.nan, math.nan)
        residue = residue_between(least, most) if len(seen) else 0.0
        levels = None
        # A signal with many distinct values shows them at the beginning; then not all samples need to be sorted.
        if len(levels_of(seen[: 4 * FEW_LEVELS], residue)[0]) < FEW_LEVELS:
            levels = _few(levels_of(seen, residue)[0])
        begin, end = (float(time[0]), float(time[-1])) if len(time) else (math.nan, math.nan)
        about = (channel.name, channel.unit, channel.source, channel.note, len(values), len(values) - len(seen))
        saturations = _saturations(seen, (least, most), _mean(len(values), pace.span)) if most - least > residue else ()
        return cls(*about, begin, end, pace, gap, least, most, levels, saturations)

    def joined(self, after: Figures) -> Figures:
        if not after.samples:
            return replace(self, note=after.note)
        if not self.samples:
            return after
        pause, span = after.begin - self.end, self.pace.span + after.pace.span
        weight = after.pace.span / span if span > 0.0 else 0.5
        rates = [each.pace.rate for each in (self, after) if math.isfinite(each.pace.rate)]
        # Single samples so far apart that each is a stretch of its own: the pause between them is the interval.
        rates = rates or [1.0 / pause if pause > 0.0 else math.nan]
        rate = (1.0 - weight) * rates[0] + weight * rates[1] if len(rates) == 2 else rates[0]
        gap = float(np.fmax(np.fmax(self.gap, after.gap), pause))
        least, most = float(np.fmin(self.least, after.least)), float(np.fmax(self.most, after.most))
        levels = None
        if self.levels is not None and after.levels is not None:
            residue = residue_between(least, most) if math.isfinite(least) else 0.0
            levels = _few(levels_of(np.concatenate([self.levels, after.levels]), residue)[0])
        return replace(
            after,
            samples=self.samples + after.samples,
            missing=self.missing + after.missing,
            begin=self.begin,
            pace=Pace(rate, span, gap),
            gap=gap,
            least=least,
            most=most,
            levels=levels,
            saturations=(*self.saturations, *after.saturations),
        )

    @property
    def missing_share(self) -> float:
        return self.missing / self.samples if self.samples else 1.0

    @property
    def constant(self) -> bool:
        return self.most - self.least <= residue_between(self.least, self.most)

    def quality(self, rows: float = 1.0) -> ChannelQuality:
        """Quality with its remarks; `rows` is the number of rows that repeat one reading."""
        return ChannelQuality(
            self.name,
            self.unit,
            self.source,
            self.samples,
            self.pace.rate,
            self.missing_share,
            self.gap,
            self.least,
            self.most,
            (*self._remarks(rows), *([self.note] if self.note else ())),
        )

    def _remarks(self, rows: float) -> list[str]:
        if not self.samples:
            return ["holds no samples"]
        if self.missing == self.samples:
            return ["every sample is missing: check the sensor and the channel map"]
        mean = _mean(self.samples, self.pace.span)
        remarks = self._of_rate(mean)
        if self.missing_share > MANY_MISSING:
            remarks.append(f"{100.0 * self.missing_share:.3g} % of the samples are missing")
        if self.gap > max(LONG_GAP, 3.0 / mean if mean > 0.0 else 0.0):
            remarks.append(f"the longest gap lasts {f'{self.gap:.3g}' if self.gap < 1000.0 else f'{self.gap:.0f}'} s")
        remarks += filter(None, [self.implausible()])
        if self.constant:
            value = in_words(self.least, self.unit, 6)
            several = self.samples - self.missing > 1
            remarks.append(f"constant at {value} throughout" if several else "holds a single sample")
        else:
            remarks += self._of_levels()
        return [*remarks, *([held_remark(self.pace.rate, rows)] if rows > 1.0 else ())]

    def _of_rate(self, mean: float) -> list[str]:
        rate, remarks = self.pace.rate, []
        if too_slow(rate, LEAST_RATE):
            remarks.append(
                f"{rate:.3g} Hz is too slow for a steering monitor, which needs {LEAST_RATE:g} Hz: record faster"
            )
        if rate > 5.0 * mean and self.gap < 1.0:
            remarks.append(
                f"samples arrive in bursts ({mean:.3g} Hz on average, {rate:.3g} Hz within one): in Python, "
                "space them evenly with Recording.retime(period)"
            )
        return remarks

    def _of_levels(self) -> list[str]:
        remarks, residue = [], residue_between(self.least, self.most)
        for end, extreme in (("upper", self.most), ("lower", self.least)):
            runs_there = [
                each for each in self.saturations if each.end == end and abs(each.extreme - extreme) <= residue
            ]
            if runs_there:
                samples = max(each.samples for each in runs_there)
                value = in_words(extreme, self.unit, 4)
                remarks.append(f"saturated: {samples} samples in a row at the {end} end, {value}")
        if self.levels is not None and len(self.levels) > 1:
            apart = in_words(float(np.diff(self.levels).min()), self.unit)
            remarks.append(f"coarse: {len(self.levels)} distinct values, {apart} apart")
        return remarks

    def implausible(self) -> str:
        """A remark on values beyond the plausible range of the signal, as with a wrong unit; "" for none."""
        known = SIGNALS.get(self.name)
        if known is None or known.unit != self.unit or not self.most > self.least:
            return ""
        low, high = known.plausible
        if low <= self.least and self.most <= high:
            return ""
        first, last, lower, upper = (in_words(value, self.unit, 4) for value in (self.least, self.most, low, high))
        # A unit that the file or the map states is not called in question.
        advice = "check sensor, unit and factor"
        if "unit not given" in self.note:
            angular = self.unit.startswith("rad") and math.radians(max(-self.least, self.most)) <= max(-low, high)
            advice = "looks like degrees: check the unit" if angular else "check the unit"
        return f"{first} to {last} leaves the plausible {lower} to {upper}; {advice}"


def channel_quality(channel: Channel) -> ChannelQuality:
    return Figures.of(channel).quality(readings_of(channel.values).rows())


def impossible(name: str, values: np.ndarray) -> np.ndarray:
    """Whether each value is infinite, or so far beyond the plausible range that no sensor, faulty or not, gives it."""
    size = np.abs(values)
    return np.asarray(np.isinf(values) | (size > IMPOSSIBLE * max(map(abs, SIGNALS[name].plausible))))


def _mean(samples: int, span: float) -> float:
    return (samples - 1) / span if span > 0.0 else math.nan


def _few(levels: np.ndarray) -> np.ndarray | None:
    return levels if len(levels) < FEW_LEVELS else None


def _saturations(seen: np.ndarray, extremes: tuple[float, float], rate: float) -> tuple[Saturation, ...]:
    needed = max(SATURATED_SAMPLES, SATURATED * rate if rate > 0.0 else 0.0)
    residue = residue_between(*extremes)
    found = []
    for end, extreme in zip(("lower", "upper"), extremes, strict=True):
        at_end = np.abs(seen - extreme) <= residue
        if np.count_nonzero(at_end) < needed or abs(extreme) <= residue:
            continue
        run = longest_run(at_end)
        if (
            run >= needed
            and _is_clipped(seen, extreme, residue)
            and _stops_at(seen, at_end, extreme, run, rate, residue)
        ):
            found.append(Saturation(end, run, extreme))
    return tuple(found)


def _stops_at(seen: np.ndarray, at_end: np.ndarray, extreme: float, run: int, rate: float, residue: float) -> bool:
    """Whether the signal changes before and after the longest run at the extreme as fast as elsewhere.

    A signal that comes to rest there slows down before and starts slowly; a clipped signal does neither. A signal that
    moves by one or two of its quantisation steps at a time cannot show this.
    """
    width = max(round(APPROACH * rate), 1) if rate > 0.0 else 1
    moves = np.abs(seen[width:] - seen[:-width])
    moving = moves[moves > residue]
    if not len(moving):
        return False
    starts, stops = runs(at_end)
    first = int(starts[np.argmax(stops - starts >= run)])
    last = first + run - 1
    ends = [abs(seen[first - width] - extreme)] if first >= width else []
    ends += [abs(seen[last + width] - extreme)] if last + width < len(seen) else []
    step = float(np.diff(levels_of(seen, residue)[0]).min(initial=np.inf))
    return bool(ends) and min(ends) >= max(0.5 * float(np.median(moving)), 2.5 * step)


def _is_clipped(seen: np.ndarray, extreme: float, residue: float) -> bool:
    """Whether samples accumulate at the extreme: a free signal stays there no longer than on the levels beside it."""
    levels, counts = levels_of(seen, residue)
    if abs(extreme - levels[0]) <= residue:
        counts = counts[::-1]
    return piles_up(int(counts[-1]), counts[-OuterLevels.KEPT : -1].tolist())
