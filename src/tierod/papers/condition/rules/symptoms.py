"""Symptom tables: which residuals a fault makes abnormal, which it leaves normal, and with which sign."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Annotated

from tierod.core.fields import NOT_NEGATIVE


@dataclass(frozen=True)
class Timing:
    """Times of symptoms and rules.

    Args:
        confirm_time: a rule must hold so long without a break until its fault is named
        hold_on: a residual stays abnormal for so long after it was
        fault_free_after: time after its own rule last held from which a fault counts as absent in other rules [s]
    """

    confirm_time: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    hold_on: Annotated[float, "s", NOT_NEGATIVE] = 0.1
    fault_free_after: Annotated[float, "s", NOT_NEGATIVE] = 0.0


@dataclass(frozen=True)
class SymptomRule:
    """Symptoms of one fault in the residuals.

    Args:
        fault: name of the element that is faulty
        abnormal, normal: residuals beyond and within their thresholds
        positive, negative: residuals that are abnormal with this sign
        larger: pairs of residuals, the first of which is more thresholds away from zero
        fault_free: other faults of the table whose rules must not hold
        weights: of residuals in the score, where they are not 1
    """

    fault: str
    abnormal: tuple[str, ...] = ()
    normal: tuple[str, ...] = ()
    positive: tuple[str, ...] = ()
    negative: tuple[str, ...] = ()
    larger: tuple[tuple[str, str], ...] = ()
    fault_free: tuple[str, ...] = ()
    weights: tuple[tuple[str, float], ...] = ()

    @property
    def residuals(self) -> tuple[str, ...]:
        """Every residual that it names, once."""
        named = [*self.abnormal, *self.normal, *self.positive, *self.negative]
        return tuple(dict.fromkeys([*named, *(each for pair in self.larger for each in pair)]))

    @property
    def raised(self) -> frozenset[str]:
        """Residuals that must be abnormal, of whatever sign."""
        return frozenset((*self.abnormal, *self.positive, *self.negative))

    def implies(self, other: SymptomRule) -> bool:
        """Whether the other rule holds wherever this one does."""
        signed = set(self.positive) >= set(other.positive) and set(self.negative) >= set(other.negative)
        inside = set(self.normal) >= set(other.normal) and self.raised >= other.raised
        return (
            signed
            and inside
            and set(self.larger) >= set(other.larger)
            and set(self.fault_free) >= set(other.fault_free)
        )


@dataclass(frozen=True)
class SymptomTable:
    """Rules that are evaluated side by side.

    Args:
        name: short
        description: one sentence
        source: where the rules come from
        rules: one for each fault
        timing: of symptoms and rules
        one_fault: whether one fault at a time is assumed: rules that hold together then name candidates, no fault
    """

    name: str
    description: str
    source: str
    rules: tuple[SymptomRule, ...]
    timing: Timing
    one_fault: bool = True

    @property
    def residuals(self) -> tuple[str, ...]:
        """Every residual that some rule names, in the order in which they come."""
        return tuple(dict.fromkeys(each for rule in self.rules for each in rule.residuals))

    @property
    def faults(self) -> tuple[str, ...]:
        """Every fault that has a rule."""
        return tuple(rule.fault for rule in self.rules)

    def not_isolable(self) -> tuple[tuple[str, str], ...]:
        """Pairs of faults, one of whose rules holds wherever the other does: symptoms alone never isolate them."""
        return tuple((a.fault, b.fault) for a, b in combinations(self.rules, 2) if a.implies(b) or b.implies(a))
