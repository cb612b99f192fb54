"""Limits of the bank's log-likelihood ratios: design on fault-free drives, and their table in the vehicle file."""

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
"""Name of the table of thresholds in a vehicle file."""

FACTOR = 1.5
"""Least factor on a limit, whatever false alarm rate is accepted [-]; no drive shows all fault-free behaviour."""
ABOVE, LEAST = (2.0, 1.0), (0.5, 0.3)
"""Least distance of a limit from the largest fault-free ratio, and least limit; fast and slow mean each [nat]."""
GAP, MARGIN = 2.0, 1.0
"""Least lead of a hypothesis, fast and slow mean together, and least additional ratio for a second suspect [nat].

With a gap of one nat a gain of the torque sensor is first called a weak motor; two nat cost 10 ms of detection delay.
"""
TAIL = 0.2
"""Share of the blocks with the largest ratios, from which the tail is estimated [-]."""
LEAST_HOURS = 0.25
"""Least time of fault-free driving for the design of limits [h]; one hour is better."""


@dataclass(frozen=True)
class DesignedLimits:
    """Limits with the data of their design.

    Args:
        limits: limits of all hypotheses but the fault-free one
        factor: factor of the limits over the largest fault-free ratios plus `ABOVE` [-]
        hours: time of fault-free driving of the design
        hours_between_alarms: mean time between false alarms, extrapolated from the tail of the ratios
        hours_at_least: lower 95 % bound of it, given the number of blocks in the tail [h]
        alarms_before: number of blocks that exceed the limits without `factor` of the other half of the driving
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
    """Design the limits of a vehicle on fault-free drives, for a mean time between false alarms of the whole bank.

    Args:
        recordings: recordings of fault-free driving, one hour or more, not used for the estimation of the parameters
        vehicle: vehicle with calibrated parameters
        hours_between_alarms: required mean time between false alarms [h]
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: less than a quarter of an hour of driving
        ParameterError: the required time is not above zero
    """
    _require_time(hours_between_alarms)
    watched = watch(recordings, vehicle, progress)
    blocks = np.concatenate([np.empty((0, 2 * len(hypotheses()) - 2)), *(each.blocks for each in watched)])
    return designed_on(blocks, hours_between_alarms, sum(each.hours for each in watched))


def designed_on(blocks: np.ndarray, hours_between_alarms: float, hours: float | None = None) -> DesignedLimits:
    """Design limits on the block maxima of fault-free driving.

    One factor applies to all limits. Limits without factor are computed on each half of the driving and tested on the
    other half (cross-validation): the largest ratio of every block over its limit has a tail, modelled as exponential,
    which is extrapolated to the required time. The limits are that factor times the mean of both halves' limits, and
    not below the limits without factor of the whole driving.

    Args:
        blocks: block maxima, (blocks, 2 x hypotheses), see `block_maxima`
        hours_between_alarms: required mean time between false alarms [h]
        hours: time for which the vehicle moves; None takes the whole time of the blocks [h]

    Raises:
        InputError: less than a quarter of an hour of driving
        ParameterError: the required time is not above zero
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
    """Refuse too little driving for the design of limits.

    Args:
        hours: time of driving that is not used for the estimation of parameters [h]

    Raises:
        InputError: less than a quarter of an hour of driving
    """
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
    """Table of the limits for a vehicle file.

    Args:
        designed: limits with the data of their design
        source: source of the drives
        explanations: hypotheses of the limits, the fault-free one first; None takes those of the whole vehicle
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
    """Whether the limits of a vehicle file were designed on this individual vehicle."""
    return vehicle.thresholds.get(NAME, {}).get("calibrated") == 1.0


def limits_of(vehicle: Vehicle, explanations: Sequence[Hypothesis] | None = None) -> Limits:
    """Limits of a vehicle file.

    Args:
        vehicle: vehicle with its table of thresholds
        explanations: hypotheses of the limits, the fault-free one first; None takes those of the whole vehicle

    Raises:
        ParameterError: the file has no limits, or they do not match the hypotheses
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
