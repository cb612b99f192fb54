"""Limits between the hypotheses of the bank: designed on fault-free drives, kept in the vehicle file, read back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Recording
from tierod.monitors.condition.bank.weighing import Limits
from tierod.monitors.condition.calibration.healthy_ratios import BLOCK, watch
from tierod.monitors.condition.hypotheses import Hypothesis, hypotheses
from tierod.vehicles import Vehicle

NAME = "condition"
"""Of the thresholds in a vehicle file."""

FACTOR = 1.5
"""Least factor of a limit, however many false alarms are borne: no drive shows all that a healthy vehicle does."""
ABOVE, LEAST = (2.0, 1.0), (0.5, 0.3)
"""Of a limit, fast and slow: how far above the largest healthy ratio, and at all, it lies at least [nat]."""
GAP, MARGIN = 2.0, 1.0
"""By which a hypothesis must lead, fast and slow together, and two suspects explain more than one [nat].

With one nat a gain of the torque sensor is first called a weak motor; two cost 10 ms of delay.
"""
TAIL = 0.2
"""Share of the blocks, the largest, from which the rate of larger ones is estimated."""
LEAST_HOURS = 0.25
"""Of healthy driving, below which no limit is designed [h]; one hour is better."""


@dataclass(frozen=True)
class DesignedLimits:
    """Limits, and how they came about.

    Args:
        limits: of all hypotheses but healthy
        factor: of the limits over the largest fault-free ratios, with what they must lie above them [-]
        hours: of fault-free driving they were made on
        hours_between_alarms: designed mean time between false alarms, carried on from the tail of what was seen
        hours_at_least: the same, were the tail as long as so few blocks allow at 95 % [h]
        alarms_before: times that driving goes beyond limits without `factor` that come from other driving
    """

    limits: Limits
    factor: Annotated[float, ""]
    hours: Annotated[float, "h"]
    hours_between_alarms: Annotated[float, "h"]
    hours_at_least: Annotated[float, "h"]
    alarms_before: int


def design_limits(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Callable[[float], None] = lambda share: None,
) -> DesignedLimits:
    """Limits of a vehicle from fault-free drives, for a mean time between false alarms of the whole bank.

    Args:
        recordings: of fault-free driving, none of it used for the parameters; an hour or more
        vehicle: with calibrated parameters
        hours_between_alarms: wanted mean time between false alarms [h]
        progress: called with the share that is done

    Raises:
        InputError: less than a quarter of an hour
        ParameterError: no time above zero is wanted
    """
    _require_time(hours_between_alarms)
    watched = watch(recordings, vehicle, progress)
    blocks = np.concatenate([np.empty((0, 2 * len(hypotheses()) - 2)), *(each.blocks for each in watched)])
    return designed_on(blocks, hours_between_alarms, sum(each.hours for each in watched))


def designed_on(blocks: np.ndarray, hours_between_alarms: float, hours: float | None = None) -> DesignedLimits:
    """Limits from the largest ratios of fault-free driving.

    One factor for all limits is designed. Limits without it come from either half of the driving; the largest ratio of
    every block of the other half over its limit has a tail, taken as exponential, that is carried on to the wanted
    time. The limits are that factor times the mean of both halves' limits, and never below those of the whole.

    Args:
        blocks: of every ten seconds, (blocks, 2 x hypotheses), see `block_maxima`
        hours_between_alarms: wanted mean time between false alarms [h]
        hours: for which the vehicle moves; all the time of the blocks where not given [h]

    Raises:
        InputError: less than a quarter of an hour
        ParameterError: no time above zero is wanted
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
    """Refuse too little driving for limits.

    Args:
        hours: of driving that no parameters come from [h]

    Raises:
        InputError: less than a quarter of an hour
    """
    if hours < LEAST_HOURS:
        raise InputError(
            f"the recordings hold {60.0 * hours:.1f} minutes of driving; limits need {60.0 * LEAST_HOURS:.0f} minutes "
            "that the parameters were not fitted to, better an hour"
        )


class _Tail(NamedTuple):
    """Exponential tail of the largest ratios over their limits: where it starts, its mean, blocks in it, per hour."""

    start: float
    scale: float
    blocks: int
    per_hour: float

    def factor(self, hours: float) -> float:
        """Factor that is exceeded once in so many hours."""
        return self.start + self.scale * math.log(max(self.per_hour * hours, 1.0))

    def hours(self, factor: float, deviations: float = 0.0) -> float:
        """Between times beyond a factor, were the tail longer by so many standard deviations of its mean."""
        scale = self.scale * (1.0 + deviations / math.sqrt(self.blocks))
        return math.exp(min((factor - self.start) / scale, 100.0)) / self.per_hour


def _tail(ratios: np.ndarray, hours: float) -> _Tail:
    start = float(np.quantile(ratios, 1.0 - TAIL))
    beyond = ratios[ratios > start] - start
    if not len(beyond):
        return _Tail(start, 1e-3, 1, 1.0 / hours)
    return _Tail(start, float(np.mean(beyond)), len(beyond), float(len(beyond) / hours))


def _require_time(hours: float) -> None:
    if not hours > 0.0:
        raise ParameterError(f"{hours:g} h between false alarms were asked for; give a time above zero")


def _bare(blocks: np.ndarray) -> np.ndarray:
    """Limits of every column, without a factor, by the largest of some blocks."""
    count = blocks.shape[1] // 2
    above, least = (np.repeat(pair, count) for pair in (ABOVE, LEAST))
    return np.asarray(np.maximum(blocks.max(axis=0) + above, least))


def table_of(
    designed: DesignedLimits, source: str, explanations: Sequence[Hypothesis] | None = None
) -> dict[str, float | str | Mapping[str, float]]:
    """Limits as a vehicle file holds them.

    Args:
        designed: the limits
        source: of the drives
        explanations: hypotheses that they are of, healthy first; those of the whole vehicle if None
    """
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
    """Whether the limits of a vehicle file were designed on this very vehicle."""
    return vehicle.thresholds.get(NAME, {}).get("calibrated") == 1.0


def limits_of(vehicle: Vehicle, explanations: Sequence[Hypothesis] | None = None) -> Limits:
    """The limits that a vehicle file holds.

    Args:
        vehicle: its file
        explanations: hypotheses that they are of, healthy first; those of the whole vehicle if None

    Raises:
        ParameterError: there are none, or they are not those of the hypotheses
    """
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
            what = f"lacks '{missing[0]}'" if missing else "holds hypotheses that there are not"
            raise ParameterError(
                f"[thresholds.{NAME}.{key}] of the vehicle '{vehicle.name}' {what}; calibrate it anew with "
                "'tierod identify thresholds'"
            )
        columns.append(tuple(float(given[name]) for name in names))
    gap, margin = (table.get(key, usual) for key, usual in (("gap", GAP), ("margin", MARGIN)))
    if not (
        min(*columns[0], *columns[1]) > 0.0 and all(isinstance(each, float) and each > 0.0 for each in (gap, margin))
    ):
        raise ParameterError(
            f"[thresholds.{NAME}] of the vehicle '{vehicle.name}' must hold numbers above zero; calibrate it anew with "
            "'tierod identify thresholds'"
        )
    return Limits(columns[0], columns[1], gap, margin)
