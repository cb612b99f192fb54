"""Limits of the bank's log-likelihood ratios: design on fault-free drives, and their table in the vehicle file."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Tree
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import Bank, JudgeSample, Verdict, scan
from tierod.core.recording import Aligned, Channel, Recording
from tierod.monitors.condition.coverage import TargetPace
from tierod.monitors.condition.decision import Decision, DecisionState
from tierod.monitors.condition.signals import WHEELS, ConditionSample, Hypothesis, hypotheses
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.monitors.condition.weighing import Limits, Weighing
from tierod.vehicles import Vehicle

RATE = 100.0  # rate of the grid [Hz]; filters and limits are designed for its steps
SLOWEST = 10.0  # rate of wheel speeds below which a recording is refused, as by the monitor [Hz]
MAXIMUM_AGE = 0.0099
"""Age from which a reading counts as missing [s]; just below the step of the grid, so that every reading is used only
once, whatever the clock of its bus."""
HELD = 0.5
"""Time for which a wheel speed is held after its last reading [s]; readings come less often than the grid's steps, or
fail."""
MOVING = 1.0  # speed of a wheel from which the vehicle counts as moving [m/s]


def sampled(recording: Recording, rate: float = RATE) -> Aligned:
    return recording.align(ConditionSample._fields, rate, maximum_age=MAXIMUM_AGE)


def aligned(recording: Recording, rate: float = RATE) -> np.ndarray:
    return sampled(recording, rate).values


def moving(rows: np.ndarray, rate: float = RATE) -> np.ndarray:
    """Whether the vehicle moves, forwards or backwards, according to the available rear wheels, (n,)."""
    place, found = np.arange(len(rows)), np.zeros(len(rows), bool)
    for speed in rows[:, : len(WHEELS)].T:
        last = np.maximum.accumulate(np.where(np.isfinite(speed), place, -1))
        fresh = (last >= 0) & (place - last <= HELD * rate)
        found |= fresh & (np.abs(speed[np.maximum(last, 0)]) > MOVING)
    return found


def wheel_of(name: str, recording: Recording) -> str:
    """Name of the wheel speed signal of a recording, that of the rear left wheel if it has both rear wheels."""
    there = [each for each in WHEELS if each in recording and len(recording[each].time)]
    if not there:
        raise InputError(
            f"{name} has neither {WHEELS[0]} nor {WHEELS[1]}: calibration needs one of them; 'tierod inspect' shows "
            "which signals it has"
        )
    time = recording[there[0]].time
    rate = 1.0 / float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    if rate < 0.99 * SLOWEST:
        raise InputError(
            f"{name} has {there[0]} at {rate:.3g} Hz; calibration needs {SLOWEST:g} Hz, better the {RATE:g} Hz of the "
            "monitor: record it faster"
        )
    return there[0]


LONGEST_GAP = 5.0  # gap in the wheel speeds from which the rest counts as another drive [s]


class HealthyDrive(NamedTuple):
    """Fault-free drive without long gaps."""

    name: str  # name of the recording that it comes from
    recording: Recording  # signals of `ConditionSample` on one grid
    driven: Annotated[float, "s"]  # time for which the vehicle moves [s]


def healthy_drives(recordings: Mapping[str, Recording]) -> list[HealthyDrive]:
    drives: list[HealthyDrive] = []
    seen: dict[bytes, str] = {}
    for name, recording in recordings.items():
        wheel = wheel_of(name, recording)
        content = _digest(recording)
        if content in seen:
            raise InputError(f"{seen[content]} and {name} hold the same drive; it counts once: leave one out")
        seen[content] = name
        gridded = [_on_grid(name, piece) for piece in _unbroken(recording[wheel].time, recording)]
        _refuse_slow_targets(name, gridded)
        drives += gridded
    return drives


def _refuse_slow_targets(name: str, drives: Sequence[HealthyDrive]) -> None:
    pace = TargetPace(RATE)
    for drive in drives:
        pace.add(aligned(drive.recording))
    if problems := pace.problems():
        raise InputError(f"{name}: {problems[0].cause}, in calibration as in the monitor; {problems[0].action}")


def parted(
    drives: Sequence[HealthyDrive], seconds: float
) -> tuple[list[HealthyDrive], list[HealthyDrive], Annotated[float, "s"]]:
    """Split drives after a given time of driving."""
    first: list[HealthyDrive] = []
    rest: list[HealthyDrive] = []
    driven = 0.0
    for drive in drives:
        left = seconds - driven
        if left <= 0.0:
            rest.append(drive)
        elif drive.driven <= left:
            first.append(drive)
            driven += drive.driven
        else:
            # Half a step of the grid keeps rounding errors from moving the cut by a whole step.
            driven_until = np.cumsum(_moving(drive.recording)) / RATE
            place = int(np.searchsorted(driven_until, left - 0.5 / RATE))
            cut = float(drive.recording[wheel_of(drive.name, drive.recording)].time[place]) + 0.5 / RATE
            first.append(HealthyDrive(drive.name, drive.recording.slice(stop=cut), left))
            rest.append(HealthyDrive(drive.name, drive.recording.slice(cut), drive.driven - left))
            driven = seconds
    return first, rest, driven


def _digest(recording: Recording) -> bytes:
    return hashlib.sha256(b"".join(recording[each].values.tobytes() for each in WHEELS if each in recording)).digest()


def _unbroken(time: np.ndarray, recording: Recording) -> Iterator[Recording]:
    """Pieces of a recording between gaps that are too long for a filter to continue."""
    after = np.flatnonzero(np.diff(time) > LONGEST_GAP) + 1
    bounds = [0, *after.tolist(), len(time)]
    for begin, end in pairwise(bounds):
        if time[end - 1] - time[begin] > LONGEST_GAP:
            yield recording.slice(float(time[begin]), float(time[end - 1]) + 0.5 / RATE)


def _on_grid(name: str, recording: Recording) -> HealthyDrive:
    samples = sampled(recording)
    columns = zip(samples.names, samples.values.T, strict=True)
    channels = {
        each: Channel(each, samples.time, np.ascontiguousarray(values), recording[each].unit)
        for each, values in columns
        if each in recording
    }
    gridded = Recording(channels, recording.metadata)
    return HealthyDrive(name, gridded, float(np.count_nonzero(_moving(gridded))) / RATE)


def _moving(recording: Recording) -> np.ndarray:
    return moving(np.column_stack([recording[each].values for each in WHEELS if each in recording]))


SETTLING = 2.0  # warm-up at the beginning of every drive that is ignored [s]
BLOCK = 10.0
"""Length of a block, of which only the largest ratio counts [s]; the ratios are autocorrelated over some seconds."""
PIECE = 15  # blocks that are processed at once, which takes some 50 MB with all outputs
_NEVER = 1e6  # limit that no ratio exceeds [nat]


@dataclass(frozen=True)
class Watching:
    """Judge whose outputs are the smoothed ratios instead of decisions."""

    decision: Decision  # decision with limits that no ratio exceeds

    def feedback(self) -> Tree:
        return self.decision.feedback()

    def init(self) -> DecisionState:
        return self.decision.init()

    def step(self, state: DecisionState, sample: JudgeSample) -> tuple[DecisionState, Verdict]:
        after, verdict = self.decision.step(state, sample)
        return after, verdict._replace(output=after.weights)


class Watched(NamedTuple):
    """Outputs of the bank on a fault-free drive."""

    blocks: np.ndarray  # largest ratios of every block in which the vehicle moves, see `block_maxima`
    hours: Annotated[float, "h"]  # time for which it moves


def watch(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    progress: Callable[[float], None] = lambda share: None,
    bank: Bank | None = None,
) -> list[Watched]:
    """Ratios of all hypotheses on fault-free drives, without any declaration; by the bank of the whole vehicle."""
    if bank is None:
        base, faults = LeaveOutFilter.of_vehicle(vehicle), hypotheses()
        decision = Decision(Weighing(faults, unreachable(faults)))
        bank = Bank(tuple(base.leaving_out(each) for each in faults), Watching(decision))
    watched = []
    for place, recording in enumerate(recordings):
        watched.append(_watched(bank, aligned(recording)))
        progress((place + 1) / len(recordings))
    return watched


def _watched(bank: Bank, drive: np.ndarray) -> Watched:
    """Ratios of one drive, processed in pieces, since the outputs of an hour would fill the memory."""
    width, skipped = round(BLOCK * RATE), round(SETTLING * RATE)
    end = skipped + max((len(drive) - skipped) // width, 0) * width
    explanations = bank.judge.decision.weighing.hypotheses
    found, state = [np.empty((0, 2 * len(explanations) - 2))], scan(bank, drive[:skipped]).state
    for begin in range(skipped, end, PIECE * width):
        result = scan(bank, drive[begin : min(begin + PIECE * width, end)], state)
        found.append(block_maxima(result.values, 0.0))
        state = result.state
    driven = moving(drive[skipped:end]).reshape(-1, width)
    return Watched(np.concatenate(found)[driven.any(axis=1)], float(np.count_nonzero(driven)) / (3600.0 * RATE))


def unreachable(explanations: Sequence[Hypothesis]) -> Limits:
    count = len(explanations) - 1
    return Limits((_NEVER,) * count, (_NEVER,) * count, 1.0, 1.0)


def block_maxima(ratios: np.ndarray, settling: float = SETTLING) -> np.ndarray:
    """Largest ratio of every block without the fault-free hypothesis, (blocks, 2 x hypotheses).

    Only ratios that last for three samples count, since the judge decides nothing earlier.
    """
    count = ratios.shape[1] // 2
    width, skipped = round(BLOCK * RATE), round(settling * RATE)
    whole = max((len(ratios) - skipped) // width, 0)
    split = ratios[skipped : skipped + whole * width].reshape(whole, width, -1)
    return np.delete(lasting(split).max(axis=1), (0, count), axis=1)


def lasting(ratios: np.ndarray) -> np.ndarray:
    """Minimum over three consecutive samples, (..., samples - 2, ratios)."""
    return np.asarray(np.minimum(np.minimum(ratios[..., 2:, :], ratios[..., 1:-1, :]), ratios[..., :-2, :]))


NAME = "condition"  # name of the table of thresholds in a vehicle file

FACTOR = 1.5
"""Least factor on a limit, whatever false alarm rate is accepted [-]; no drive shows all fault-free behaviour."""
ABOVE, LEAST = (2.0, 1.0), (0.5, 0.3)
"""Least distance of a limit from the largest fault-free ratio, and least limit; fast and slow mean each [nat]."""
GAP, MARGIN = 2.0, 1.0
"""Least lead of a hypothesis, fast and slow mean together, and least additional ratio for a second suspect [nat].

With a gap of one nat a gain of the torque sensor is first called a weak motor; two nat cost 10 ms of detection delay.
"""
TAIL = 0.2  # share of the blocks with the largest ratios, from which the tail is estimated [-]
LEAST_HOURS = 0.25  # least time of fault-free driving for the design of limits [h]; one hour is better


@dataclass(frozen=True)
class DesignedLimits:
    """Limits with the data of their design."""

    limits: Limits  # limits of all hypotheses but the fault-free one
    factor: Annotated[float, ""]  # factor of the limits over the largest fault-free ratios plus `ABOVE` [-]
    hours: Annotated[float, "h"]  # time of fault-free driving of the design
    # mean time between false alarms, extrapolated from the tail of the ratios
    hours_between_alarms: Annotated[float, "h"]
    hours_at_least: Annotated[float, "h"]  # lower 95 % bound of it, given the number of blocks in the tail [h]
    alarms_before: int  # number of blocks that exceed the limits without `factor` of the other half of the driving


def designed_on(blocks: np.ndarray, hours_between_alarms: float, hours: float | None = None) -> DesignedLimits:
    """Design limits on the block maxima of fault-free driving.

    One factor applies to all limits. Limits without factor are computed on each half of the driving and tested on the
    other half (cross-validation): the largest ratio of every block over its limit has a tail, modelled as exponential,
    which is extrapolated to the required time. The limits are that factor times the mean of both halves' limits, and
    not below the limits without factor of the whole driving.
    """
    _require_time(hours_between_alarms)
    hours = len(blocks) * BLOCK / 3600.0 if hours is None else hours
    require_hours(hours)
    half = len(blocks) // 2
    bare = [_bare(blocks[:half]), _bare(blocks[half:])]
    ratios = np.concatenate([(blocks[:half] / bare[1]).max(axis=1), (blocks[half:] / bare[0]).max(axis=1)])
    tail = _tail(ratios, hours)
    factor = max(tail.factor(hours_between_alarms), FACTOR)
    both = np.maximum(factor * 0.5 * (bare[0] + bare[1]), _bare(blocks)).tolist()
    count = len(both) // 2
    return DesignedLimits(
        Limits(tuple(both[:count]), tuple(both[count:]), GAP, MARGIN),
        factor,
        hours,
        tail.hours(factor),
        tail.hours(factor, 1.645),
        int(np.count_nonzero(ratios > 1.0)),
    )


def require_hours(hours: float) -> None:
    if hours < LEAST_HOURS:
        raise InputError(
            f"the recordings hold {60.0 * hours:.1f} minutes of driving; limits need {60.0 * LEAST_HOURS:.0f} minutes "
            "that the parameters were not fitted to, better an hour"
        )


class _Tail(NamedTuple):
    """Exponential tail of the ratios over their limits: start, mean excess, number of blocks, and blocks per hour."""

    start: float
    scale: float
    blocks: int
    per_hour: float

    def factor(self, hours: float) -> float:
        """Factor that is exceeded once in the given time [h]."""
        return self.start + self.scale * math.log(max(self.per_hour * hours, 1.0))

    def hours(self, factor: float, deviations: float = 0.0) -> float:
        """Mean time between exceedances of a factor [h], with the mean excess raised by some standard deviations."""
        scale = self.scale * (1.0 + deviations / math.sqrt(self.blocks))
        # Bounded, since the exponential of a very large factor would overflow.
        return math.exp(min((factor - self.start) / scale, 100.0)) / self.per_hour


def _tail(ratios: np.ndarray, hours: float) -> _Tail:
    start = float(np.quantile(ratios, 1.0 - TAIL))
    beyond = ratios[ratios > start] - start
    # Equal ratios in all blocks have no excess: take a very narrow tail.
    if not len(beyond):
        return _Tail(start, 1e-3, 1, 1.0 / hours)
    return _Tail(start, float(np.mean(beyond)), len(beyond), float(len(beyond) / hours))


def _require_time(hours: float) -> None:
    if not hours > 0.0:
        raise ParameterError(f"{hours:g} h between false alarms were asked for; give a time above zero")


def _bare(blocks: np.ndarray) -> np.ndarray:
    """Limits of every column without a factor, from the largest ratios of some blocks."""
    count = blocks.shape[1] // 2
    above, least = (np.repeat(pair, count) for pair in (ABOVE, LEAST))
    return np.asarray(np.maximum(blocks.max(axis=0) + above, least))


def table_of(
    designed: DesignedLimits, source: str, explanations: Sequence[Hypothesis] | None = None
) -> dict[str, float | str | Mapping[str, float]]:
    names = [each.name for each in (explanations or hypotheses())[1:]]
    return {
        "source": source,
        "calibrated": 1.0,
        "hours": designed.hours,
        "hours_between_alarms": designed.hours_between_alarms,
        "hours_at_least": designed.hours_at_least,
        "factor": designed.factor,
        "gap": designed.limits.gap,
        "margin": designed.limits.margin,
        "fast": dict(zip(names, designed.limits.fast, strict=True)),
        "slow": dict(zip(names, designed.limits.slow, strict=True)),
    }


def has_own_limits(vehicle: Vehicle) -> bool:
    """Whether the limits of a vehicle file were designed on this individual vehicle."""
    return vehicle.thresholds.get(NAME, {}).get("calibrated") == 1.0


def limits_of(vehicle: Vehicle, explanations: Sequence[Hypothesis] | None = None) -> Limits:
    table = vehicle.thresholds.get(NAME)
    if table is None:
        raise ParameterError(
            f"the vehicle '{vehicle.name}' has no limits of the condition monitor; 'tierod identify thresholds' finds "
            "them on healthy drives"
        )
    names = [each.name for each in (explanations or hypotheses())[1:]]
    columns = []
    for key in ("fast", "slow"):
        given = table.get(key)
        if not isinstance(given, Mapping) or set(given) != set(names):
            missing = [name for name in names if not isinstance(given, Mapping) or name not in given]
            what = f"lacks '{missing[0]}'" if missing else "holds unknown hypotheses"
            raise ParameterError(
                f"[thresholds.{NAME}.{key}] of the vehicle '{vehicle.name}' {what}; calibrate it again with 'tierod "
                "identify thresholds'"
            )
        columns.append(tuple(float(given[name]) for name in names))
    gap, margin = (table.get(key, usual) for key, usual in (("gap", GAP), ("margin", MARGIN)))
    if not (
        min(*columns[0], *columns[1]) > 0.0 and all(isinstance(each, float) and each > 0.0 for each in (gap, margin))
    ):
        raise ParameterError(
            f"[thresholds.{NAME}] of the vehicle '{vehicle.name}' must hold numbers above zero; calibrate it again "
            "with 'tierod identify thresholds'"
        )
    return Limits(columns[0], columns[1], gap, margin)
