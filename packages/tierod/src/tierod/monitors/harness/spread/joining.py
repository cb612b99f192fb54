"""Conclusion of a session, joined with the effects of the vehicle parameters' spread."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from tierod.core.facts import Fact, Verdict
from tierod.core.findings import Estimate, ParameterEffect, Status
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.advice import baseline_command, first_to_measure
from tierod.monitors.harness.spread.effects import Effects, effects
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.monitors.harness.spread.turning import hidden_fault, most_important, turn, turn_by_estimate, turned
from tierod.vehicles.vehicle import Vehicle

DOMINANT = 0.5
"""Share of the parameters in an estimate's variance above which the most important one is named [-]."""


class Joined(NamedTuple):
    """Conclusion including the spread of the parameters.

    Args:
        conclusion: conclusion with wider bands, and the fact that guesses decide if the verdict is not robust
        effects: effects of the parameters, the largest first
    """

    conclusion: Conclusion
    effects: tuple[ParameterEffect, ...]


def joined(
    conclusion: Conclusion, outcome: Outcome | None, vehicle: Vehicle, may_turn: bool, learns: bool = False
) -> Joined:
    """Conclusion for a vehicle whose parameters are uncertain.

    Args:
        conclusion: conclusion for the unperturbed vehicle
        outcome: results of the perturbed vehicles; None if no parameter was perturbed
        vehicle: vehicle with the standard deviations of its parameters
        may_turn: whether the verdict depends on the parameters; with a baseline it does not, since the baseline has the
            same errors
        learns: whether the monitor learns a baseline, which would then decide
    """
    known = conclusion.parameter_variance
    found = Effects(0.0, ()) if outcome is None else effects(outcome, conclusion.verdict.estimate, vehicle, known)
    moves = outcome if found.each else None
    turning = turn(conclusion, moves) if moves is not None and may_turn else None
    if turning is None:
        rests = found if may_turn else Effects(0.0, ())
        turning = turn_by_estimate(conclusion.verdict, rests.variance, rests.each, vehicle)
    if turning is None and may_turn:
        turning = hidden_fault(conclusion.verdict, 0.0 if known is not None else found.variance, found.each)
    if moves is not None:
        conclusion = _with_effects(conclusion, moves, found, vehicle, advising=turning is None)
    if turning is None:
        # A verdict with a doubt of its own keeps the level that the user's word may make a baseline.
        doubtful = conclusion.verdict.status is Status.SUSPECT
        return Joined(conclusion if doubtful else replace(conclusion, unproven=None), found.each)
    return Joined(turned(conclusion, turning, vehicle, _baseline(conclusion, vehicle, learns and may_turn)), found.each)


def with_own_interval(conclusion: Conclusion, vehicle: Vehicle, may_turn: bool, learns: bool = False) -> Conclusion:
    """Conclusion for a vehicle whose parameters are taken as exact; not healthy where its own interval has a fault.

    Args:
        conclusion: conclusion of the session
        vehicle: vehicle of the recording
        may_turn, learns: as for `joined`
    """
    turning = hidden_fault(conclusion.verdict, 0.0, ()) if may_turn else None
    if turning is None:
        return conclusion
    return turned(conclusion, turning, vehicle, _baseline(conclusion, vehicle, learns))


def _baseline(conclusion: Conclusion, vehicle: Vehicle, learns: bool) -> str:
    return baseline_command(conclusion.verdict.monitor, vehicle) if learns else ""


def _with_effects(
    conclusion: Conclusion, outcome: Outcome, found: Effects, vehicle: Vehicle, advising: bool
) -> Conclusion:
    """Conclusion with the standard deviation of its estimate widened by the parameters."""
    verdict = conclusion.verdict
    if verdict.estimate is not None:
        included = conclusion.parameter_variance is not None
        verdict = _wider(verdict, verdict.estimate, found, vehicle, advising, included)
    if outcome.held is not None and "truth_within_band_share" in verdict.evidence:
        verdict = replace(verdict, evidence={**verdict.evidence, "truth_within_wider_band_share": outcome.held})
    return replace(conclusion, verdict=verdict, remarks=_remarks(conclusion.remarks, found))


def _wider(
    verdict: Verdict, estimate: Estimate, found: Effects, vehicle: Vehicle, advising: bool, included: bool
) -> Verdict:
    """Verdict with the standard deviation of parameters and estimator together; `included` where it has that."""
    own = estimate.standard_deviation
    deviation = own if included else math.sqrt(own**2 + found.variance)
    share = found.variance / deviation**2 if deviation > 0.0 else 0.0
    first, notes = first_to_measure(found.each), verdict.facts
    if share > DOMINANT and first is not None:
        cause = f"{most_important(first, vehicle)}{'; measure it first' if advising else ''}"
        notes = (*notes, Fact("parameter", cause))
    return replace(
        verdict,
        estimate=replace(estimate, standard_deviation=deviation),
        evidence={**verdict.evidence, "variance_from_parameters_share": share},
        facts=notes,
    )


def _remarks(remarks: Mapping[str, str], found: Effects) -> dict[str, str]:
    """Remarks with the note that histograms are those of the unperturbed vehicle."""
    histograms = f"Estimates with the parameters of the vehicle file; an error of {found.each[0].name} shifts them all."
    return {**remarks, "histograms": histograms}
