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


def effects(outcome: Outcome, estimate: Estimate | None, vehicle: Vehicle, included: float | None = None) -> Effects:
    """Effects of the parameters on an estimate, or on the result over time if there is no estimate.

    Args:
        outcome: results of the perturbed vehicles
        estimate: estimate for the unperturbed vehicle; None if nothing is estimated
        vehicle: vehicle with the standard deviations of its parameters
        included: variance by the parameters that the estimate's deviation has already [unit squared]; None without it
    """
    if estimate is not None and included is not None:
        return _shared(outcome, estimate, vehicle, included)
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


def _shared(outcome: Outcome, estimate: Estimate, vehicle: Vehicle, variance: float) -> Effects:
    """Effects that together have a known variance, shared out by the changes of the result over the recording."""
    size = math.sqrt(sum(each * each for each in outcome.moves.values()))
    if not (size > 0.0 and variance > 0.0):
        return Effects(0.0, ())
    found = {name: math.sqrt(variance) * move / size for name, move in outcome.moves.items()}
    own = math.sqrt(max(estimate.standard_deviation**2 - variance, 0.0))
    ranked = sorted((name for name in found if abs(found[name]) > SMALLEST * own), key=lambda name: -abs(found[name]))
    return Effects(variance, tuple(_row(vehicle, name, found[name], estimate.unit, variance) for name in ranked))


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
    return estimate if outcome.reference is None else outcome.reference.verdict.estimate


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
    found = other.conclusion.verdict.estimate
    if found is None or not math.isfinite(found.value):
        return None
    return found.value - estimate.value
