"""One drive: estimates of the paper's filters, windows of its baseline, and the verdict of the default monitor."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.graph import scan
from tierod.core.recording import Aligned, Recording
from tierod.core.statuses import STATUSES, Status
from tierod.models.steering_column import FrictionParameters
from tierod_lab.papers.friction.presets import linearised, printed, printed_open, unscented
from tierod_lab.papers.friction.reported import monitor, vehicle
from tierod_lab.papers.friction.variance_method import VarianceFrictionMonitor, VarianceGate, VarianceParameters

RATE = 100.0
KEPT = 20  # Decimation of the stored estimates, to 5 Hz: far above the bandwidth of filters that settle in many seconds
READY = 50.0  # Enabled time before an estimate counts [s], as printed by Mohtat et al., section 5
INITIAL = 3.0  # Initial friction estimate of the paper's filter [N*m]
ALIGNING_TRUTH = "truth_self_aligning_torque"
GRAVITY = 9.81

FOUND = (Status.RISING, Status.FAULT)
_ALARMS = np.array([status in FOUND for status in STATUSES])  # by status code

DEFAULT = "default"  # tierod's own estimator, with its verdict
PRINTED = "as printed"
POSTERIOR = "operating point estimated"
PER_SAMPLE = "virtual rows of G one"
PNEUMATIC = "rows of G one, pneumatic trail alone"
OPEN = "aligning torque open"
UNSCENTED = "unscented"


def _parameters(trail: float = 1.0) -> FrictionParameters:
    """Parameters of the vehicle file, with a share of its trail."""
    known = vehicle().parameters_for(FrictionParameters)
    return replace(known, trail=trail * known.trail)


READINGS: Mapping[str, Callable[[float], Any]] = {
    PRINTED: lambda start: printed(_parameters(), initial_friction_variance=start),
    PER_SAMPLE: lambda start: printed(_parameters(), virtual_noise="per sample", initial_friction_variance=start),
    # The pneumatic trail alone, as the paper words it: half of the trail that acts.
    PNEUMATIC: lambda start: printed(_parameters(0.5), virtual_noise="per sample", initial_friction_variance=start),
    OPEN: lambda start: printed_open(_parameters(), initial_friction_variance=start),
}
"""Maker of each reading of the printed filter from P0 of friction [(N*m)**2]."""

FILTERS: Mapping[str, Callable[[], Any]] = {
    **{name: partial(READINGS[name], 1.0) for name in (PRINTED, PER_SAMPLE, OPEN)},
    POSTERIOR: lambda: printed(_parameters(), operating_point="estimate"),
    UNSCENTED: lambda: unscented(_parameters()),
}
"""Filters that run over the paper's drives, by name."""


def with_terms(growth: float, ratio_slope: float, sign_slope: float) -> Any:
    """The printed filter with terms of eq (19) on (1) or off (0), and a growth of the steering ratio [1/rad**2]."""
    terms = {"with_ratio_slope": ratio_slope, "with_sign_slope": sign_slope}
    return linearised(_parameters(), steering_ratio_growth=growth, **terms)


def _baseline(gate: VarianceGate | None = None, literal_sign: bool = False) -> VarianceFrictionMonitor:
    parameters = vehicle().parameters_for(VarianceParameters)
    return VarianceFrictionMonitor(parameters, math.inf, gate=gate, literal_sign=literal_sign)


CORRECTED, SIGNED, GATED, GATED_IN_G = "eq (1) corrected", "eq (1), printed sign", "printed gate", "printed gate, in g"
BASELINES: Mapping[str, Callable[[], VarianceFrictionMonitor]] = {
    CORRECTED: _baseline,
    SIGNED: lambda: _baseline(literal_sign=True),
    GATED: lambda: _baseline(VarianceGate()),
    GATED_IN_G: lambda: _baseline(VarianceGate(minimum_acceleration=0.1 * GRAVITY, maximum_acceleration=0.5 * GRAVITY)),
}
"""Forms of the baseline monitor, whose feature is a variance over 15 s."""


@dataclass(frozen=True)
class Course:
    """Course of an estimate over a drive, at 5 Hz."""

    friction: np.ndarray  # estimated friction [N*m]
    enabled: np.ndarray  # enabled time so far [s]
    aligning_error: float  # rms error of the self-aligning torque over the spread of the true one; NaN where unknown

    @property
    def settled(self) -> np.ndarray:
        """The estimates after the warm-up [N*m]."""
        return self.friction[self.enabled > READY]

    @property
    def mean(self) -> float:
        """Mean of the settled estimates [N*m]; NaN where the estimator was not enabled for long enough."""
        return float(self.settled.mean()) if len(self.settled) else math.nan


class Verdict(NamedTuple):
    """Verdict of the default monitor."""

    status: Status  # at the end of the drive
    early: bool  # whether there was an alarm before friction changed; at any time in a drive without a change
    delay: float  # enabled time from the change to an alarm [s], infinite without one
    level: tuple[float, float] | None  # baseline and its standard deviation [N*m]; None where none was learnt


def aligned(recording: Recording, *blocks: Any, more: tuple[str, ...] = ()) -> Aligned:
    """Samples for some blocks at 100 Hz, with the true self-aligning torque and further channels."""
    names = dict.fromkeys(name for block in blocks for name, _ in leaves(skeleton(block.Sample)))
    return recording.align([*names, ALIGNING_TRUTH, *more], RATE)


def course(block: Any, samples: Aligned) -> Course:
    """Run a filter of the paper over a drive."""
    run = scan(block, samples)
    truth = samples.values[:, samples.names.index(ALIGNING_TRUTH)]
    error = float(np.sqrt(np.nanmean((run["self_aligning_torque"] - truth) ** 2)) / np.nanstd(truth))
    return _course(run["friction_torque"], run["enabled"], error)


def _course(friction: np.ndarray, enabled: np.ndarray, aligning_error: float = math.nan) -> Course:
    seconds = np.cumsum(enabled)[::KEPT] / RATE
    return Course(friction[::KEPT].astype(np.float32), seconds.astype(np.float32), aligning_error)


def windows(block: VarianceFrictionMonitor, samples: Aligned) -> tuple[np.ndarray, float]:
    """Variance of every window of the baseline, once a second [(N*m)**2], and share of the drive that counts."""
    run = scan(block, samples)
    once_a_second = slice(int(RATE) - 1, None, int(RATE))
    ready = run["ready"][once_a_second] > 0.0
    return run["variance"][once_a_second][ready], float(run["enabled"].mean())


def judged(
    samples: Aligned, level: tuple[float, float] | None = None, changed_at: float | None = None
) -> tuple[Course, Verdict]:
    """Run the default monitor over a drive.

    Args:
        level: baseline of the car and its standard deviation [N*m]; None learns it from this drive
        changed_at: time at which friction changes [s]; None where it does not
    """
    judge = monitor(level)
    result = scan(judge, samples)
    alarms = _ALARMS[result["verdict.running"].astype(int)]
    change = len(alarms) if changed_at is None else round(changed_at * RATE)
    after = np.flatnonzero(alarms[change:])
    enabled = np.cumsum(result["estimate.enabled"]) / RATE
    delay = float(enabled[change + after[0]] - enabled[change]) if len(after) else math.inf
    own = result.at(-1).verdict.baseline
    learnt = (own.level, own.deviation) if own.seconds > 0.0 else None
    verdict = Verdict(judge.finding(result).status, bool(alarms[:change].any()), delay, learnt)
    return _course(result["estimate.friction_torque"], result["estimate.enabled"]), verdict


def reached(each: Course, true: float, share: float = 0.8) -> tuple[float, float]:
    """Enabled and total time [s] until an estimate has gone a share of the way to the truth; infinite if never.

    Args:
        true: friction at the end of the way, which begins at the initial 3 N*m [N*m]
    """
    short = each.friction < INITIAL + share * (true - INITIAL)
    if short.all():
        return math.inf, math.inf
    place = int(np.argmin(short))
    return float(each.enabled[place]), place * KEPT / RATE


BINS = 40  # Number of bins of the histograms whose overlap is measured


def shares(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Share of the values in every bin [-]."""
    counted: np.ndarray = np.histogram(values, at)[0] / max(len(values), 1)
    return counted


def overlap(one: np.ndarray, other: np.ndarray, logarithmic: bool) -> float:
    """Overlap of the histograms of two groups: 0 disjoint, 1 identical; NaN where a group is empty."""
    if not (len(one) and len(other)):
        return math.nan
    values = np.concatenate([one, other])
    low, high = float(values.min()), float(values.max())
    # The margins keep the largest value inside the last bin despite rounding, and the bins wide where all are equal.
    if logarithmic:
        at = np.geomspace(max(low, 1e-9), max(high, low + 1e-9) * (1.0 + 1e-9), BINS + 1)
    else:
        at = np.linspace(low, high + 1e-9 + 1e-9 * abs(high), BINS + 1)
    return float(np.minimum(shares(one, at), shares(other, at)).sum())


def right_side(low: np.ndarray, high: np.ndarray, threshold: float) -> float:
    """Balanced accuracy of a threshold: mean over both groups of the share on their side; NaN where one is empty."""
    if not (len(low) and len(high)):
        return math.nan
    return 0.5 * (float(np.mean(low < threshold)) + float(np.mean(high > threshold)))


def best_accuracy(low: np.ndarray, high: np.ndarray) -> float:
    """Balanced accuracy at the best threshold; NaN where a group is empty."""
    if not (len(low) and len(high)):
        return math.nan
    low, high = np.sort(low), np.sort(high)
    at = np.concatenate([low, high])
    below = np.searchsorted(low, at, side="right") / len(low)
    above = 1.0 - np.searchsorted(high, at, side="right") / len(high)
    return float(np.max(0.5 * (below + above)))
