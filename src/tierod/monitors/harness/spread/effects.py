"""Effects of the parameters on the conclusion of a monitor."""

from __future__ import annotations

import math
from typing import NamedTuple

from tierod.core.findings import Estimate, ParameterEffect
from tierod.monitors.harness.spread.carried import REACH
from tierod.monitors.harness.spread.directions import SMALLEST, Direction
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.monitors.harness.spread.points import Concluded
from tierod.vehicles.vehicle import Vehicle


class Effects(NamedTuple):
    """Effects of the parameters on a result.

    Args:
        variance: variance that they add to the result [unit squared]
        each: effect of each parameter, the largest first
    """

    variance: float
    each: tuple[ParameterEffect, ...]


def effects(outcome: Outcome, estimate: Estimate | None, vehicle: Vehicle) -> Effects:
    """Effects of the parameters on an estimate, or on the result over time if there is no estimate.

    Args:
        outcome: results of the perturbed vehicles
        estimate: estimate for the unperturbed vehicle; None if nothing is estimated
        vehicle: vehicle with the standard deviations of its parameters
    """
    found = {} if estimate is None else _of_estimate(outcome, estimate)
    if estimate is None or not found:
        size = math.sqrt(sum(each * each for each in outcome.moves.values()))
        deviations = 1.0 if estimate is None else estimate.standard_deviation
        scale = outcome.deviation / size if size > 0.0 and outcome.deviation > 0.0 else deviations
        found = {name: scale * move for name, move in outcome.moves.items()}
        own = scale if estimate is None else estimate.standard_deviation
        unit = (outcome.unit if outcome.deviation > 0.0 else "") if estimate is None else estimate.unit
    else:
        own, unit = estimate.standard_deviation, estimate.unit
    total = sum(each * each for each in found.values())
    counted = {name: move for name, move in found.items() if abs(move) > SMALLEST * own}
    ranked = sorted(counted, key=lambda name: -abs(counted[name]))
    rows = [_row(vehicle, name, counted[name], unit, total) for name in ranked]
    variance = total if outcome.alone or not outcome.along else _along(outcome, estimate) or total
    return Effects(variance if counted else 0.0, tuple(rows))


def _row(vehicle: Vehicle, name: str, move: float, unit: str, total: float) -> ParameterEffect:
    parameter = vehicle.parameters[name]
    spread = parameter.standard_deviation or 0.0
    return ParameterEffect(name, parameter.value, spread, parameter.unit, move, unit, move * move / total)


def _of_estimate(outcome: Outcome, estimate: Estimate) -> dict[str, float]:
    """Change of the estimate by one standard deviation of each parameter; empty without perturbed estimates."""
    if outcome.alone:
        moves = {name: _move(estimate, each) for name, each in outcome.alone.items()}
        return {name: move for name, move in moves.items() if move is not None}
    found: dict[str, float] = {}
    base = _base(outcome, estimate)
    for direction, concluded in outcome.along if base is not None else ():
        assert base is not None
        each_move = [(each, _move(base, each)) for each in concluded]
        along = [move / _way(direction, each) for each, move in each_move if move is not None]
        if along:
            size = math.copysign(math.sqrt(sum(move * move for move in along) / len(along)), sum(along))
            for name, part in direction.by.items():
                found[name] = found.get(name, 0.0) + part * size
    return found


def _base(outcome: Outcome, estimate: Estimate) -> Estimate | None:
    """Reference for the estimates along the directions: that of the unperturbed session which began with them."""
    return estimate if outcome.reference is None else outcome.reference.finding.estimate


def _way(direction: Direction, each: Concluded) -> float:
    """Perturbation of a vehicle along its direction, in standard deviations with sign."""
    name = max(direction.by, key=lambda part: abs(direction.by[part]))
    return each.by[name] / direction.by[name]


def _along(outcome: Outcome, estimate: Estimate | None) -> float:
    """Variance that the directions add to an estimate; 0 without perturbed estimates."""
    base = None if estimate is None else _base(outcome, estimate)
    if base is None:
        return 0.0
    variance, captured = 0.0, sum(direction.share for direction, _ in outcome.along)
    for _, concluded in outcome.along:
        moves = [move for each in concluded if (move := _move(base, each)) is not None]
        if moves:
            variance += sum((move / REACH) ** 2 for move in moves) / len(moves)
    return variance / captured


def _move(estimate: Estimate, other: Concluded) -> float | None:
    """Difference of a perturbed vehicle's estimate; None if it has none."""
    found = other.conclusion.finding.estimate
    if found is None or not math.isfinite(found.value):
        return None
    # The largest value of a drive has the sign of the side on which it occurred, which a perturbation may change.
    if estimate.quantity.startswith("largest"):
        return abs(found.value) - abs(estimate.value)
    return found.value - estimate.value
