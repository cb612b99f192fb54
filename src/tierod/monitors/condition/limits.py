"""Limits between the hypotheses of the bank: designed on healthy drives, kept in the vehicle file, read back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from tierod.errors import InputError, ParameterError
from tierod.graph import Bank, scan
from tierod.monitors.condition.calibration import aligned
from tierod.monitors.condition.decision import Decision, judge
from tierod.monitors.condition.lane import LeaveOutFilter, leaving_out
from tierod.monitors.condition.signals import Hypothesis, hypotheses
from tierod.monitors.condition.weighing import Limits
from tierod.recording import Recording
from tierod.vehicles import Vehicle

NAME = "condition"
"""Of the thresholds in a vehicle file."""

FACTOR = 1.5
"""Least factor of a limit over the largest healthy ratio; with 1.0 the virtual demonstrator alarms by the hour."""
ABOVE, LEAST = (2.0, 1.0), (0.5, 0.3)
"""Of a limit, fast and slow: how far above the largest healthy ratio, and at all, it lies at least [nat]."""
GAP, MARGIN = 2.0, 1.0
"""By which a hypothesis must lead, fast and slow together, and two suspects explain more than one [nat].

With one nat a gain of the torque sensor is first called a weak motor; two cost 10 ms of delay.
"""
SETTLING = 2.0
"""Not looked at, at the beginning of every drive [s]."""
BLOCK = 10.0
"""Ratios are correlated over some seconds; of every such time the largest counts [s]."""
TAIL = 0.2
"""Share of the blocks, the largest, that tell how seldom larger ones are."""
LEAST_HOURS = 0.25
"""Of healthy driving, below which no limit is designed [h]; one hour is better."""


@dataclass(frozen=True)
class DesignedLimits:
    """Limits, and how they came about.

    Args:
        limits: of all hypotheses but healthy
        factor: of the limits over the largest healthy ratios [-]
        hours: of healthy driving they were made on
        hours_between_alarms: designed mean time between false alarms, carried on from the tail of what was seen
        alarms_before: times that driving which the largest ratios were not taken from exceeds them, `FACTOR` left aside
    """

    limits: Limits
    factor: Annotated[float, ""]
    hours: Annotated[float, "h"]
    hours_between_alarms: Annotated[float, "h"]
    alarms_before: int


@dataclass(frozen=True)
class Watching:
    """A judge that tells the smoothed ratios instead of what it decides.

    Args:
        decision: with limits that nothing exceeds
    """

    decision: Decision

    def feedback(self) -> Any:
        """What lanes are told."""
        return self.decision.feedback()

    def init(self) -> Any:
        """Healthy."""
        return self.decision.init()

    def step(self, state: Any, sample: Any) -> Any:
        """One sample on."""
        after, verdict = self.decision.step(state, sample)
        return after, verdict._replace(output=after.weights)


def design_limits(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Callable[[float], None] = lambda share: None,
) -> DesignedLimits:
    """Limits of a vehicle from healthy drives, for a mean time between false alarms of the whole bank.

    One factor for all limits is designed: the largest ratio of every ten seconds over what the other half of the drives
    showed at most has a tail, taken as exponential, that is carried on to the wanted time.

    Args:
        recordings: of healthy driving, none of it used for the parameters; an hour or more
        vehicle: with calibrated parameters
        hours_between_alarms: wanted mean time between false alarms [h]
        progress: called with the share that is done

    Raises:
        InputError: less than a quarter of an hour
        ParameterError: no time above zero is wanted
    """
    _require_time(hours_between_alarms)
    bank = _watching(LeaveOutFilter.of_vehicle(vehicle), hypotheses())
    maxima = []
    for place, recording in enumerate(recordings):
        maxima.append(block_maxima(scan(bank, aligned(recording)).values))
        progress((place + 1) / len(recordings))
    return designed_on(np.concatenate(maxima), hours_between_alarms)


def designed_on(blocks: np.ndarray, hours_between_alarms: float) -> DesignedLimits:
    """Limits from the largest ratios of healthy driving.

    Args:
        blocks: of every ten seconds, (blocks, 2 x hypotheses), see `block_maxima`
        hours_between_alarms: wanted mean time between false alarms [h]

    Raises:
        InputError: less than a quarter of an hour
        ParameterError: no time above zero is wanted
    """
    _require_time(hours_between_alarms)
    hours = len(blocks) * BLOCK / 3600.0
    if hours < LEAST_HOURS:
        raise InputError(
            f"the recordings hold {60.0 * hours:.0f} minutes of driving; limits need {60.0 * LEAST_HOURS:.0f} minutes "
            "that the parameters were not fitted to, better an hour"
        )
    ratios, alarms = _held_out(blocks)
    factor, designed = _factor(ratios, hours_between_alarms)
    return DesignedLimits(_limits(blocks.max(axis=0), factor), factor, hours, designed, alarms)


def _require_time(hours: float) -> None:
    if not hours > 0.0:
        raise ParameterError(f"{hours:g} h between false alarms were asked for; give a time above zero")


def _watching(base: LeaveOutFilter, explanations: tuple[Hypothesis, ...]) -> Bank:
    count = len(explanations) - 1
    never = Limits((1e6,) * count, (1e6,) * count, GAP, MARGIN)
    return Bank(tuple(leaving_out(each, base) for each in explanations), Watching(judge(explanations, never)))


def block_maxima(ratios: np.ndarray) -> np.ndarray:
    """The largest ratio of every block, healthy left out, (blocks, 2 x hypotheses).

    Args:
        ratios: smoothed fast and slowly, the healthy hypothesis first in both, sample by sample
    """
    count = ratios.shape[1] // 2
    ratios = np.delete(ratios, (0, count), axis=1)
    width, skipped = round(BLOCK * 100.0), round(SETTLING * 100.0)
    whole = max((len(ratios) - skipped) // width, 0)
    return ratios[skipped : skipped + whole * width].reshape(whole, width, -1).max(axis=1)


def _largest(blocks: np.ndarray, factor: float) -> np.ndarray:
    """Limits of every column by the largest of some blocks."""
    count = blocks.shape[1] // 2
    above, least = (np.repeat(pair, count) for pair in (ABOVE, LEAST))
    top = blocks.max(axis=0)
    return np.maximum.reduce([factor * top, top + above, least])


def _limits(top: np.ndarray, factor: float) -> Limits:
    both = _largest(top[None, :], factor)
    count = len(both) // 2
    return Limits(tuple(both[:count].tolist()), tuple(both[count:].tolist()), GAP, MARGIN)


def _held_out(blocks: np.ndarray) -> tuple[np.ndarray, int]:
    """The largest ratio over its limit of every block, limits from the other half; and how often that is above one."""
    half = len(blocks) // 2
    parts = [(blocks[:half], blocks[half:]), (blocks[half:], blocks[:half])]
    ratios = np.concatenate([(judged / _largest(known, 1.0)).max(axis=1) for known, judged in parts])
    return ratios, int(np.count_nonzero(ratios > 1.0))


def _factor(ratios: np.ndarray, hours: float) -> tuple[float, float]:
    """Factor of the limits for a mean time between alarms [h], and the time that `FACTOR` at least gives."""
    start = float(np.quantile(ratios, 1.0 - TAIL))
    scale = float(np.mean(ratios[ratios > start] - start))
    per_hour = TAIL * 3600.0 / BLOCK
    wanted = start + scale * math.log(max(per_hour * hours, 1.0))
    factor = max(wanted, FACTOR)
    return factor, math.exp((factor - start) / scale) / per_hour


def table_of(designed: DesignedLimits, source: str) -> dict[str, float | str | Mapping[str, float]]:
    """Limits as a vehicle file holds them.

    Args:
        designed: the limits
        source: of the drives
    """
    names = [each.name for each in hypotheses()[1:]]
    return {
        "source": source,
        "calibrated": 1.0,
        "hours": designed.hours,
        "hours_between_alarms": designed.hours_between_alarms,
        "factor": designed.factor,
        "gap": designed.limits.gap,
        "margin": designed.limits.margin,
        "fast": dict(zip(names, designed.limits.fast, strict=True)),
        "slow": dict(zip(names, designed.limits.slow, strict=True)),
    }


def is_calibrated(vehicle: Vehicle) -> bool:
    """Whether the limits of a vehicle file were designed on this very vehicle."""
    return vehicle.thresholds.get(NAME, {}).get("calibrated") == 1.0


def limits_of(vehicle: Vehicle) -> Limits:
    """The limits that a vehicle file holds.

    Raises:
        ParameterError: there are none, or they are not those of the hypotheses
    """
    table = vehicle.thresholds.get(NAME)
    if table is None:
        raise ParameterError(
            f"the vehicle '{vehicle.name}' has no limits of the condition monitor; 'tierod identify thresholds' finds "
            "them on healthy drives"
        )
    names = [each.name for each in hypotheses()[1:]]
    columns = []
    for key in ("fast", "slow"):
        given = table.get(key)
        if not isinstance(given, Mapping) or set(given) != set(names):
            missing = [name for name in names if not isinstance(given, Mapping) or name not in given]
            what = f"lacks '{missing[0]}'" if missing else "holds hypotheses that there are not"
            raise ParameterError(
                f"[thresholds.{NAME}.{key}] of the vehicle '{vehicle.name}' {what}; calibrate it anew with "
                "'tierod identify thresholds'"
            )
        columns.append(tuple(float(given[name]) for name in names))
    gap, margin = (table.get(key, usual) for key, usual in (("gap", GAP), ("margin", MARGIN)))
    if not (min(*columns[0], *columns[1]) > 0.0 and isinstance(gap, float) and isinstance(margin, float)):
        raise ParameterError(f"[thresholds.{NAME}] of the vehicle '{vehicle.name}' must hold numbers above zero")
    return Limits(columns[0], columns[1], gap, margin)
