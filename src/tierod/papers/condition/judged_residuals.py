"""A residual with all that judges it: sigma, distance, stopping rule."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.methods.detectors.stopping_rules import HoldRule, StoppingRule
from tierod.papers.condition.rules.calibration import ResidualCalibration
from tierod.papers.condition.rules.catalogue import Residual, residual
from tierod.papers.condition.rules.readings import Excitation, ResidualThreshold

USUAL = Excitation(8.0, 0.2, 2.0, 0.5)
"""Of a lively drive of the demonstrator, for which thresholds that adapt are told."""


@dataclass(frozen=True)
class JudgedResidual:
    """One residual and how it is judged.

    Args:
        residual: what it is: equation, signals, unit, condition, correction
        deviation: standard deviation while all is well, in its unit
        threshold: of it, fixed or widening
        rule: that stops: one value beyond the threshold, which then counts for the hold-on of the rules
    """

    residual: Residual
    deviation: Annotated[float, "unit of the signal"]
    threshold: ResidualThreshold
    rule: StoppingRule

    @property
    def distance(self) -> str:
        """What the rule sees, in words."""
        return "off its healthy median, in thresholds" if self.threshold.centre else "off zero, in thresholds"

    @property
    def sigmas(self) -> float:
        """The threshold at `USUAL` excitation, in standard deviations."""
        return float(self.threshold.at(USUAL)) / self.deviation

    @property
    def condition(self) -> str:
        """When it is judged, in words."""
        words = {
            "moving": "above walking speed",
            "gentle": "below 6 m/s2 across",
            "steady": "while the asked torque does not jump",
        }
        asked = [text for name, text in words.items() if getattr(self.residual, name)]
        return ", ".join(asked) or "always"


def judged(name: str, calibration: ResidualCalibration) -> JudgedResidual:
    """A residual as a calibration judges it.

    Args:
        name: of the residual
        calibration: from healthy drives

    Raises:
        ParameterError: there is no such residual
    """
    rule = HoldRule(sides="both", hold=1)
    return JudgedResidual(residual(name), calibration.deviations[name], calibration.thresholds[name], rule)
