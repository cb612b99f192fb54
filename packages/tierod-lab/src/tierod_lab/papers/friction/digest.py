"""Digest of one drive: course of every estimator, windows of the baseline algorithm, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.graph import Result, scan
from tierod.core.recording import Aligned, Recording
from tierod.core.statuses import STATUSES, Status
from tierod_lab.papers.friction.cases import Case
from tierod_lab.papers.friction.estimators import BASELINES, DEFAULT, ESTIMATORS, monitor
from tierod_lab.papers.friction.warping import warped

RATE = 100.0
KEPT = 20  # Decimation of the stored estimates, to 5 Hz: far above the bandwidth of filters that settle in many seconds

ALIGNING_TRUTH = "truth_self_aligning_torque"

READY_SECONDS = 50.0  # Warm-up: enabled time before an estimate counts [s], as printed by Mohtat et al., section 5

ALARM = 3.0  # Alarm level of the running verdict from which friction counts as rising; a fault is one level higher

_LEVEL = {Status.NOT_READY: 0.0, Status.HEALTHY: 2.0, Status.RISING: ALARM, Status.FAULT: ALARM + 1.0}
LEVELS = np.array([_LEVEL.get(status, 1.0) for status in STATUSES])
"""Alarm level by status code: 0 not ready, 1 no verdict, 2 healthy, 3 rising, 4 fault."""


@dataclass(frozen=True)
class Course:
    """Course of an estimate over a drive, at 5 Hz."""

    friction: np.ndarray  # estimated friction [N*m]
    enabled_seconds: np.ndarray  # enabled time so far [s]
    # root mean square error of the self-aligning torque over the standard deviation of the true torque [-]; NaN where
    # none is estimated
    aligning_error: float = math.nan

    @property
    def settled(self) -> np.ndarray:
        """The estimates after the warm-up [N*m]."""
        return self.friction[self.enabled_seconds > READY_SECONDS]


@dataclass(frozen=True)
class Windows:
    """Windows of the baseline monitor over a drive."""

    variance: np.ndarray  # variance of every window, once a second [(N*m)**2]
    realigned: np.ndarray  # the same with the vehicle's torque delayed by `delay` [(N*m)**2]
    enabled_share: float  # share of the drive in which the monitor was enabled [-]
    delay: float  # lag of the observer's torque behind the vehicle's, at the peak of their correlation [s]
    warped: np.ndarray  # variance of every window after dynamic time warping of the vehicle's torque [(N*m)**2]


@dataclass(frozen=True)
class Verdict:
    """Verdict of the default monitor."""

    status: Status  # at the end of the drive
    worst: float  # highest alarm level of the running verdict, as in `LEVELS`
    ratios: tuple[float, float]  # lowest and highest ratio to the baseline while friction was judged [-]
    # enabled time from a step of friction to rising and to fault [s], infinite without the alarm
    delays: tuple[float, float]
    early: bool  # whether there was an alarm before the step; at any time in a drive without a step
    level: tuple[float, float] | None  # baseline and its standard deviation [N*m]; None where none was learnt


@dataclass(frozen=True)
class Digest:
    """Digest of one drive."""

    seconds: float  # duration [s]
    angle: np.ndarray  # steering wheel angle at 5 Hz [rad]
    courses: dict[str, Course] = field(default_factory=dict)  # course of every requested estimator, by name
    # windows of every requested form of the baseline monitor, by name
    windows: dict[str, Windows] = field(default_factory=dict)
    verdict: Verdict | None = None  # verdict of the default monitor

    def settled(self, estimator: str) -> np.ndarray:
        """Estimates of an estimator after the warm-up [N*m]."""
        return self.courses[estimator].settled

    def mean(self, estimator: str) -> float:
        """Mean of the settled estimates [N*m]; NaN where the estimator was not enabled for long enough."""
        values = self.settled(estimator)
        return float(values.mean()) if len(values) else math.nan


def digest(case: Case, names: Iterable[str], level: tuple[float, float] | None = None) -> Digest:
    """Simulates a drive, runs the estimators over it and returns their results.

    Args:
        names: estimators in `ESTIMATORS` and `BASELINES`; `DEFAULT` always runs
        level: baseline of the car and its standard deviation [N*m]; None learns it from this drive
    """
    recording = case.recording()
    wanted = list(names)
    blocks = {name: ESTIMATORS[name]() for name in wanted if name in ESTIMATORS}
    baselines = {name: BASELINES[name]() for name in wanted if name in BASELINES}
    judge = monitor(level)
    samples = _aligned(recording, [judge, *blocks.values(), *baselines.values()])
    truth = samples.values[:, samples.names.index(ALIGNING_TRUTH)]
    result = scan(judge, samples)
    courses = {DEFAULT: _course(result["estimate.friction_torque"], result["estimate.enabled"])}
    for name, block in blocks.items():
        run = scan(block, samples)
        error = _tracking(run["self_aligning_torque"], truth) if "self_aligning_torque" in run.names else math.nan
        courses[name] = _course(run["friction_torque"], run["enabled"], error)
    windows = {name: _windows(scan(block, samples)) for name, block in baselines.items()}
    angle = samples.values[::KEPT, samples.names.index("steering_wheel_angle")].astype(np.float32)
    verdict = _verdict(judge, result, _changed_at(case))
    return Digest(len(samples.values) / RATE, angle, courses, windows, verdict)


def _tracking(estimated: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean((estimated - truth) ** 2)) / np.nanstd(truth))


def _aligned(recording: Recording, blocks: Iterable[Any]) -> Aligned:
    names = dict.fromkeys(name for block in blocks for name, _ in leaves(skeleton(block.Sample)))
    return recording.align([*names, ALIGNING_TRUTH], RATE)


def _course(friction: np.ndarray, enabled: np.ndarray, aligning_error: float = math.nan) -> Course:
    seconds = np.cumsum(enabled)[::KEPT] / RATE
    return Course(friction[::KEPT].astype(np.float32), seconds.astype(np.float32), aligning_error)


def _windows(run: Result) -> Windows:
    once_a_second = slice(int(RATE) - 1, None, int(RATE))
    ready = run["ready"][once_a_second] > 0.0
    external, internal = run["external_torque"], run["internal_torque"]
    lag = round(lag_between(internal, external) * RATE)
    # The roll is cyclic, but by half a second at most, so it disturbs only windows at one end of the drive.
    delayed = np.roll(external, lag)
    return Windows(
        run["variance"][once_a_second][ready],
        _variance(internal - delayed)[ready],
        float(run["enabled"].mean()),
        lag / RATE,
        _warped(internal, external)[ready],
    )


WARPED_RATE, WARPED_BAND = 20.0, 0.5
"""Rate of the samples that are warped [Hz], and largest time shift between two matched samples [s]."""


def _warped(internal: np.ndarray, external: np.ndarray) -> np.ndarray:
    """Variance as in `_variance`, each window of 15 s warped alone; the shorter ones at the start are not warped."""
    thin = round(RATE / WARPED_RATE)
    second, length = round(WARPED_RATE), 15 * round(WARPED_RATE)
    pair = [values[thin - 1 :: thin] for values in (external, internal)]
    ends = np.arange(second, len(pair[0]) + 1, second)[: len(internal) // round(RATE)]
    found = np.array([(pair[1] - pair[0])[:end].var(ddof=1) for end in ends[ends < length]])
    whole = ends[ends >= length]
    if not len(whole):
        return found
    cut = [np.stack([values[end - length : end] for end in whole]) for values in pair]
    apart = cut[1] - warped(cut[0], cut[1], round(WARPED_BAND * WARPED_RATE))
    return np.concatenate([found, apart.var(axis=1, ddof=1)])


def _variance(difference: np.ndarray) -> np.ndarray:
    second = int(RATE)
    ends = np.arange(second, len(difference) + 1, second)
    return np.array([difference[max(end - 15 * second, 0) : end].var(ddof=1) for end in ends])


def lag_between(late: np.ndarray, early: np.ndarray, longest: float = 0.5) -> float:
    """Lag of one torque behind another [s]: the shift at the peak of their cross-correlation."""
    reach = min(round(longest * RATE), len(late) - 1)
    # Padded, since the correlation by FFT is cyclic: without it, the ends of the drive would correlate with each other.
    size = 1 << (len(late) + reach - 1).bit_length()
    spectra = (np.fft.rfft(values - values.mean(), size) for values in (late, early))
    products = np.fft.irfft(next(spectra) * np.conj(next(spectra)), size)
    shifts = np.arange(-reach, reach + 1)
    return float(shifts[int(np.argmax(products[shifts]))] / RATE)


def _changed_at(case: Case) -> float | None:
    """Time at which friction steps [s]; None where it does not."""
    course = case.friction
    return course.times[0] if not isinstance(course, float) and len(course.times) == 2 else None


def _verdict(judge: Any, result: Result, changed_at: float | None) -> Verdict:
    code, ratio = LEVELS[result["verdict.running"].astype(int)], result["verdict.ratio"]
    enabled = np.cumsum(result["estimate.enabled"]) / RATE
    judged = code >= 2.0
    change = len(code) if changed_at is None else round(changed_at * RATE)
    delays = [math.inf, math.inf]
    for kind in (0, 1):
        alarms = np.flatnonzero(code[change:] >= ALARM + kind)
        if len(alarms):
            delays[kind] = float(enabled[change + alarms[0]] - enabled[change])
    own = result.at(-1).verdict.baseline
    ratios = (float(ratio[judged].min()), float(ratio[judged].max())) if judged.any() else (math.nan, math.nan)
    return Verdict(
        status=judge.finding(result).status,
        worst=float(code.max()),
        ratios=ratios,
        delays=(delays[0], delays[1]),
        early=bool((code[:change] >= ALARM).any()),
        level=(own.level, own.deviation) if own.seconds > 0.0 else None,
    )
