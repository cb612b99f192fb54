"""The conclusion of a session with the effects of the vehicle parameters' spread on it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from tierod.core.findings import Estimate, Finding, ParameterEffect
from tierod.core.shown import shown
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.effects import Effects, effects
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.monitors.harness.spread.turning import most_important, turn, turn_by_estimate, turned
from tierod.vehicles.vehicle import Vehicle

DOMINANT = 0.5
"""Share of an estimate's variance from which on the parameters are named in the headline: they are the larger part."""


class Joined(NamedTuple):
    """A conclusion with the spread.

    Args:
        conclusion: with wider deviations, and another status where the verdict turns
        effects: of the parameters that move it, the one that moves it most first
    """

    conclusion: Conclusion
    effects: tuple[ParameterEffect, ...]


def joined(conclusion: Conclusion, outcome: Outcome | None, vehicle: Vehicle, may_turn: bool) -> Joined:
    """The conclusion for a vehicle whose parameters are uncertain.

    Args:
        conclusion: for the vehicle as it is
        outcome: for the moved ones; None where no parameter was moved
        vehicle: with the standard deviation of its parameters
        may_turn: whether the verdict rests on the parameters; it does not where they are in what it is judged against
    """
    found = Effects(0.0, ()) if outcome is None else effects(outcome, conclusion.finding.estimate, vehicle)
    moves = outcome if found.each else None
    if moves is not None:
        conclusion = _with_effects(conclusion, moves, found, vehicle)
    turning = turn(conclusion, moves) if moves is not None and may_turn else None
    if turning is None:
        rests = found if may_turn else Effects(0.0, ())
        turning = turn_by_estimate(conclusion.finding, rests.variance, rests.each, vehicle)
    return Joined(conclusion if turning is None else turned(conclusion, turning, vehicle), found.each)


def _with_effects(conclusion: Conclusion, outcome: Outcome, found: Effects, vehicle: Vehicle) -> Conclusion:
    """The conclusion with the deviation that the moved vehicles add to its estimate."""
    finding = conclusion.finding
    if finding.estimate is not None:
        finding = _wider(finding, finding.estimate, found, vehicle)
    if outcome.held is not None and "truth_within_band_share" in finding.evidence:
        finding = replace(finding, evidence={**finding.evidence, "truth_within_wider_band_share": outcome.held})
    return replace(conclusion, finding=finding, remarks=_remarks(conclusion.remarks, found))


def _wider(finding: Finding, estimate: Estimate, found: Effects, vehicle: Vehicle) -> Finding:
    """The finding with the deviation that parameters and estimator have together."""
    own = estimate.standard_deviation
    deviation = math.sqrt(own**2 + found.variance)
    share = found.variance / deviation**2 if deviation > 0.0 else 0.0
    headline = restated(finding.headline, own, deviation, estimate.unit)
    if share > DOMINANT:
        headline = f"{headline} {most_important(found.each[0], vehicle)}."
    return replace(
        finding,
        headline=headline,
        estimate=replace(estimate, standard_deviation=deviation),
        evidence={**finding.evidence, "variance_from_parameters_share": share},
    )


def restated(headline: str, own: float, deviation: float, unit: str) -> str:
    """A headline with the wider deviation in place of the estimator's own.

    Args:
        headline: that may give "± 0.11 degrees"
        own, deviation: in the unit
        unit: of the estimate
    """
    factor, _ = shown(unit)

    def wider(match: re.Match[str]) -> str:
        decimals = len(match[1].partition(".")[2])
        return f"± {factor * deviation:.{decimals}f}" if match[1] == f"{factor * own:.{decimals}f}" else match[0]

    return re.sub(r"± (\d+(?:\.\d+)?)", wider, headline)


def _remarks(remarks: Mapping[str, str], found: Effects) -> dict[str, str]:
    """Remarks with a note that histograms hold the estimates for the vehicle as it is."""
    histograms = f"Estimates for the vehicle as its file gives it; all move together with {found.each[0].name}."
    return {**remarks, "histograms": histograms}
