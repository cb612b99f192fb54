"""Comparison of stopping rules, each with the constant that detects a given shift fastest."""

from __future__ import annotations

from dataclasses import dataclass

from tierod.core.errors import ParameterError
from tierod.methods.detectors.stopping_rules import AverageRule, CusumRule, HoldRule, SequentialRule, StoppingRule

WEIGHTS = (0.5, 0.3, 0.2, 0.12, 0.08, 0.05, 0.03, 0.02, 0.01, 0.005)
HOLDS = (2, 3, 5, 8, 12, 20, 30)
"""Candidate weights and hold counts; near the optimum the delay differs by a few per cent between neighbours."""

RULES = ("cusum", "average", "sequential", "hold", "threshold")
"""Names of the rules that a user can choose."""


@dataclass(frozen=True)
class Designed:
    """A rule with its threshold.

    Args:
        samples: wanted mean number of samples between false alarms
        delay: mean detection delay of the shift [samples]
    """

    rule: StoppingRule
    threshold: float
    samples: float
    delay: float

    def delay_at(self, change: float) -> float:
        """Mean detection delay [samples] of another shift, which is given in standard deviations."""
        return self.rule.run_length(self.threshold, change if self.rule.sides != "lower" else -change)


def designed(name: str, shift: float, samples: float, sides: str = "both") -> Designed:
    """A rule with the constant that minimises the detection delay, and the threshold for a time between false alarms.

    Args:
        shift: to be detected, in standard deviations, greater than zero
        sides: "both", "upper" or "lower"

    Raises:
        ParameterError: so few samples that no threshold is needed
    """
    found: list[Designed] = []
    refused: list[ParameterError] = []
    for rule in _candidates(name, shift, samples, sides):
        try:
            found.append(_with_threshold(rule, shift, samples))
        except ParameterError as error:
            refused.append(error)
    if not found:
        raise refused[0]
    return min(found, key=lambda each: each.delay)


def _candidates(name: str, shift: float, samples: float, sides: str) -> list[StoppingRule]:
    if name == "average":
        return [AverageRule(weight, sides=sides) for weight in WEIGHTS]
    if name == "hold":
        return [HoldRule(hold, sides=sides) for hold in HOLDS]
    sought = _sought(shift, samples)
    one: dict[str, StoppingRule] = {
        "cusum": CusumRule(0.5 * sought, sides=sides),
        "sequential": SequentialRule(sought, sides=sides),
        "threshold": AverageRule(1.0, sides=sides),
    }
    return [one[name]]


def _sought(shift: float, samples: float) -> float:
    """The shift that a rule is designed for, limited so that a drift of half of it still needs a positive threshold."""
    from scipy.special import ndtri

    return min(shift, 1.8 * float(-ndtri(1.0 / samples))) if samples > 10.0 else shift


def _with_threshold(rule: StoppingRule, shift: float, samples: float) -> Designed:
    threshold = rule.threshold_for(samples)
    change = -shift if rule.sides == "lower" else shift
    delay = rule.run_length(threshold, change)
    return Designed(rule, threshold, samples, delay)
