"""Contradictions between several estimates of one quantity: a wrong sign, a delay, or a wrong scale of one of them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np

from tierod.monitors.condition.recording_checks.witnesses import OVER_SPEED, TIMES_SPEED, YAW_SENSOR, Witness
from tierod.monitors.condition.signals import WHEELS
from tierod.monitors.harness.related_signals import Pair, odd_ones_out

STEP = 0.04
"""Sampling interval of the comparison [s]."""
LATEST = 1.0
"""Largest shift in time that is searched, in either direction [s]."""
CLEAR, TIGHT = 0.6, 0.95
"""Correlation from which signs are compared, and from which shifts and scales are compared [-]."""


class Problem(NamedTuple):
    """Defect of the recording or of the vehicle file.

    Args:
        kind: "sign", "time", "scale" or "rate"
        elements: sensors that it concerns
        cause: description
        action: remedy
    """

    kind: str
    elements: tuple[str, ...]
    cause: str
    action: str


def turned(estimates: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness]) -> tuple[Problem, ...]:
    """Problem that one estimate has the wrong sign; empty if none or several may have it.

    Args:
        estimates: estimates by name of the witness; NaN where one is not valid
        witnesses: witnesses by name
    """
    found = {pair: _correlation(estimates[pair[0]], estimates[pair[1]]) for pair in combinations(estimates, 2)}
    odd = odd_ones_out(tuple(estimates), {pair: value > 0.0 for pair, value in found.items() if abs(value) > CLEAR})
    if len(odd) != 1:
        return ()
    witness = witnesses[odd[0]]
    return (Problem("sign", witness.elements, witness.turned, "correct the channel map"),)


def late(estimates: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness], limit: float) -> tuple[Problem, ...]:
    """Problem that one estimate is delayed, or early, against the others; empty if none or several may be.

    Args:
        estimates: estimates by name of the witness, one value every `STEP`
        witnesses: witnesses by name
        limit: shift in time from which an estimate is wrong [s]
    """
    shifts = {}
    for one, other in combinations(estimates, 2):
        shift = _shift(estimates[one], estimates[other])
        if shift is not None:
            shifts[one, other] = shift - (witnesses[one].lead - witnesses[other].lead)
    odd = odd_ones_out(tuple(estimates), {pair: abs(shift) < limit for pair, shift in shifts.items()})
    if len(odd) != 1:
        return ()
    by = [(-shift if pair[0] == odd[0] else shift) for pair, shift in shifts.items() if odd[0] in pair]
    delay = float(np.median(by))
    cause = f"{odd[0]}: {abs(delay):.2f} s {'late' if delay > 0.0 else 'early'} relative to the other signals"
    action = "check the time stamps: the channel may come from another bus with a clock of its own"
    return (Problem("time", witnesses[odd[0]].elements, cause, action),)


def _shift(one: np.ndarray, other: np.ndarray) -> float | None:
    """Delay of the second signal against the first [s]; None if they do not correlate at any shift."""
    most = round(LATEST / STEP)
    inner = one[most : len(one) - most]
    shifts = range(-most, most + 1)
    values = [_correlation(inner, other[most + shift : len(other) - most + shift]) for shift in shifts]
    best = int(np.argmax(values))
    return (shifts[best] + _vertex(values, best)) * STEP if values[best] > TIGHT else None


def _vertex(values: list[float], best: int) -> float:
    """Vertex of a parabola through the highest value and its neighbours, in steps from the highest."""
    if not 0 < best < len(values) - 1:
        return 0.0
    before, top, after = values[best - 1 : best + 2]
    bend = before - 2.0 * top + after
    return 0.5 * (before - after) / bend if bend < 0.0 else 0.0


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    both = np.isfinite(one) & np.isfinite(other)
    x, y = one[both], other[both]
    size = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / size if size > 0.0 else 0.0


def scaled(estimates: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness], limit: float) -> tuple[Problem, ...]:
    """Problem that one estimate has the wrong scale; empty if none or several may have it.

    Args:
        estimates: estimates by name of the witness, with their mean removed
        witnesses: witnesses by name
        limit: ratio of amplitudes from which an estimate is wrong
    """
    found = {pair: _ratio(estimates[pair[0]], estimates[pair[1]]) for pair in combinations(estimates, 2)}
    ratios: dict[Pair, float] = {pair: ratio for pair, ratio in found.items() if np.isfinite(ratio)}
    odd = odd_ones_out(tuple(estimates), {pair: 1.0 / limit < ratio < limit for pair, ratio in ratios.items()})
    if len(odd) != 1:
        return ()
    witness = witnesses[odd[0]]
    by = [(ratio if pair[0] == odd[0] else 1.0 / ratio) for pair, ratio in ratios.items() if odd[0] in pair]
    cause = f"{witness.scaled}: it is {np.median(by):.3g} times the value from the others"
    return (Problem("scale", witness.elements, cause, "correct the vehicle file or the channel map"),)


def _ratio(one: np.ndarray, other: np.ndarray) -> float:
    """Ratio of the amplitudes of both estimates; NaN if they do not correlate."""
    if _correlation(one, other) <= TIGHT:
        return np.nan
    both = np.isfinite(one) & np.isfinite(other)
    return float(np.sqrt((one[both] @ one[both]) / (other[both] @ other[both])))


def misread_speed(estimates: Mapping[str, np.ndarray], limit: float) -> tuple[Problem, ...]:
    """Problem that the wheel speeds have the wrong scale; all estimates of the yaw rate but its sensor use them.

    If they read k times the truth, wheels and steering angle give k times the yaw rate, and the lateral acceleration
    gives it over k.

    Args:
        estimates: estimates of the yaw rate by name of the witness, with their mean removed
        limit: ratio of amplitudes from which an estimate is wrong
    """
    if not {YAW_SENSOR, *TIMES_SPEED, OVER_SPEED} <= set(estimates):
        return ()
    sizes = [_ratio(estimates[name], estimates[YAW_SENSOR]) for name in TIMES_SPEED]
    sizes.append(_ratio(estimates[YAW_SENSOR], estimates[OVER_SPEED]))
    least, most = min(sizes), max(sizes)
    if not (np.isfinite(sizes).all() and most < limit * least and (least > limit or most < 1.0 / limit)):
        return ()
    cause = (
        f"the wheel speeds have the wrong unit or scale: they are {np.median(sizes):.3g} times the values from the "
        "others"
    )
    return (Problem("scale", WHEELS, cause, "correct their unit in the channel map; 1 m/s is 3.6 km/h"),)
