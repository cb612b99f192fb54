"""Quality of recorded data, judged for each channel by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import ChannelQuality
from tierod.core.recording import Channel
from tierod.core.residues import levels_of, residue_between
from tierod.core.series import longest_run, runs
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.io.readings import LEAST_RATE, held_remark, median_rate, rows_per_reading, too_slow
from tierod.methods.running import OuterLevels, piles_up


@dataclass(frozen=True)
class QualityLimits:
    """Limits beyond which a channel deserves a remark."""

    slow: Annotated[float, "Hz"] = LEAST_RATE
    gap: Annotated[float, "s"] = 0.1  # pause [s] that counts as a gap; ten missed messages of a 10 ms bus
    missing: Annotated[float, ""] = 0.01  # share of missing samples that deserves a remark
    # time [s] at the extreme value that indicates a saturated sensor, not driving
    saturation: Annotated[float, "s"] = 0.3
    saturation_samples: int = 10  # smallest number of equal samples in that time
    steps: int = 50  # number of distinct values below which the quantisation deserves a remark


LIMITS = QualityLimits()

# Multiple of the plausible range that not even a faulty sensor exceeds [-]; degrees taken for radians stay below
IMPOSSIBLE = 10.0

# Time before and after a run at the extreme over which the change is taken [s]: a hand stops a wheel in 0.3 s
APPROACH = 0.1


_MISSING, _GAP, _PLAUSIBLE = "% of the samples are missing", "the longest gap lasts", "leaves the plausible"


def mean_rate(time: np.ndarray) -> float:
    """Mean sampling rate over the whole span [Hz]; NaN with fewer than two stamps."""
    span = time[-1] - time[0] if len(time) > 1 else 0.0
    return float((len(time) - 1) / span) if span > 0.0 else float("nan")


class Pace(NamedTuple):
    """Sampling pace of a set of time stamps."""

    rate: Annotated[float, "Hz"]  # rate from the median sampling interval [Hz]
    mean: Annotated[float, "Hz"]  # mean rate over the whole span [Hz]
    gap: Annotated[float, "s"]  # longest interval [s]; NaN with fewer than two stamps

    @classmethod
    def of(cls, time: np.ndarray) -> Pace:
        """The pace of time stamps [s], (n,)."""
        gap = float(np.diff(time).max()) if len(time) > 1 else float("nan")
        return cls(median_rate(time), mean_rate(time), gap)


def channel_quality(channel: Channel, limits: QualityLimits = LIMITS, pace: Pace | None = None) -> ChannelQuality:
    """Rate, gaps, missing share, range and remarks of one channel."""
    time, values = channel.time, channel.values
    pace = pace or Pace.of(time)
    good = np.isfinite(values)
    seen = values if good.all() else values[good]
    gap = pace.gap
    if len(seen) < len(values):
        gap = float(np.diff(time[good]).max()) if len(seen) > 1 else float("nan")
    missing = 1.0 - len(seen) / len(values) if len(values) else 1.0
    least, most = (float(seen.min()), float(seen.max())) if len(seen) else (float("nan"), float("nan"))
    assumed = assumes_unit(channel.note)
    remarks = [
        *_rate_remarks(pace, len(time), gap, len(seen), limits),
        *figure_remarks(channel.name, channel.unit, missing, gap, pace.mean, (least, most), assumed, limits),
        *_value_remarks(channel, seen, (least, most), pace.mean, limits),
        *([held_remark(pace.rate, rows)] if (rows := rows_per_reading(seen)) > 1.0 else ()),
    ]
    if channel.note:
        remarks.append(channel.note)
    return ChannelQuality(
        channel.name,
        channel.unit,
        channel.source,
        len(values),
        pace.rate,
        missing,
        gap,
        least,
        most,
        tuple(remarks),
    )


def figure_remarks(
    name: str,
    unit: str,
    missing: float,
    gap: float,
    mean: float,
    extremes: tuple[float, float],
    assumed: bool,
    limits: QualityLimits = LIMITS,
) -> list[str]:
    """The remarks that follow from summary figures alone, so that they can be made for several pieces together.

    Args:
        gap: its longest gap [s]
        mean: its mean rate [Hz]
        extremes: its smallest and largest value [unit]
    """
    if missing == 1.0 or not np.isfinite(extremes).all():
        return []
    remarks = []
    if missing > limits.missing:
        remarks.append(f"{100.0 * missing:.3g} {_MISSING}")
    if gap > max(limits.gap, 3.0 / mean if mean > 0.0 else 0.0):
        remarks.append(f"{_GAP} {gap:.3g} s" if gap < 1000.0 else f"{_GAP} {gap:.0f} s")
    return remarks + _range_remark(name, unit, *extremes, assumed)


def assumes_unit(note: str) -> bool:
    """Whether a note states that the file gives no unit, so that the signal's unit was assumed."""
    return "unit not given" in note


def follows_from_figures(remark: str) -> bool:
    """Whether a remark is one of `figure_remarks`."""
    return any(part in remark for part in (_MISSING, _GAP, _PLAUSIBLE))


def is_about_implausible_values(remark: str) -> bool:
    """Whether a remark states that the values leave the plausible range of their signal."""
    return _PLAUSIBLE in remark


def impossible(name: str, values: np.ndarray) -> np.ndarray:
    """Whether each value is infinite, or so far beyond the plausible range that no sensor, faulty or not, gives it."""
    size = np.abs(values)
    return np.asarray(np.isinf(values) | (size > IMPOSSIBLE * max(map(abs, SIGNALS[name].plausible))))


def _rate_remarks(pace: Pace, count: int, gap: float, seen: int, limits: QualityLimits) -> list[str]:
    if not count:
        return ["holds no samples"]
    if not seen:
        return ["every sample is missing: check the sensor and the channel map"]
    remarks = []
    rate, mean, _ = pace
    if too_slow(rate, limits.slow):
        remarks.append(
            f"{rate:.3g} Hz is too slow for a steering monitor, which needs {limits.slow:g} Hz: record faster"
        )
    if rate > 5.0 * mean and gap < 1.0:
        remarks.append(
            f"samples arrive in bursts ({mean:.3g} Hz on average, {rate:.3g} Hz within one): in Python, "
            "space them evenly with Recording.retime(period)"
        )
    return remarks


def _value_remarks(
    channel: Channel, seen: np.ndarray, extremes: tuple[float, float], rate: float, limits: QualityLimits
) -> list[str]:
    if not len(seen):
        return []
    least, most = extremes
    residue = residue_between(least, most)
    if most - least <= residue:
        value = in_words(least, channel.unit, 6)
        return [f"constant at {value} throughout" if len(seen) > 1 else "holds a single sample"]
    remarks = []
    remarks += _saturation_remark(channel, seen, extremes, rate, limits)
    # A signal with many distinct values shows them at the beginning; then not all samples need to be sorted.
    first = levels_of(seen[: 4 * limits.steps], residue)[0]
    if len(first) < limits.steps and 1 < len(values := levels_of(seen, residue)[0]) < limits.steps:
        apart = in_words(float(np.diff(values).min()), channel.unit)
        remarks.append(f"coarse: {len(values)} distinct values, {apart} apart")
    return remarks


def _range_remark(name: str, unit: str, least: float, most: float, assumed: bool) -> list[str]:
    known = SIGNALS.get(name)
    if known is None or known.unit != unit or least == most:
        return []
    low, high = known.plausible
    if low <= least and most <= high:
        return []
    first, last, lower, upper = (in_words(value, unit, 4) for value in (least, most, low, high))
    # A unit that the file or the map states is not called in question.
    advice = "check sensor, unit and factor"
    if assumed:
        in_degrees = unit.startswith("rad") and math.radians(max(-least, most)) <= max(-low, high)
        advice = "looks like degrees: check the unit" if in_degrees else "check the unit"
    return [f"{first} to {last} {_PLAUSIBLE} {lower} to {upper}; {advice}"]


def _saturation_remark(
    channel: Channel, seen: np.ndarray, extremes: tuple[float, float], rate: float, limits: QualityLimits
) -> list[str]:
    needed = max(limits.saturation_samples, limits.saturation * rate if rate > 0.0 else 0.0)
    residue = residue_between(*extremes)
    remarks = []
    for end, extreme in (("lower", extremes[0]), ("upper", extremes[1]))[::-1]:
        at_end = np.abs(seen - extreme) <= residue
        if np.count_nonzero(at_end) < needed:
            continue
        run = longest_run(at_end)
        if not (run >= needed and abs(extreme) > residue):
            continue
        if _is_clipped(seen, extreme, residue) and _stops_at(seen, at_end, extreme, run, rate, residue):
            remarks.append(f"saturated: {run} samples in a row at the {end} end, {in_words(extreme, channel.unit, 4)}")
    return remarks


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
