"""Symptom tables: residuals that a fault makes abnormal, with their sign, and residuals that it leaves normal."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Annotated

from tierod.core.fields import NOT_NEGATIVE


@dataclass(frozen=True)
class Timing:
    """Times of symptoms and rules.

    Args:
        confirm_time: time for which a rule must hold without a break before its fault is declared
        hold_on: time for which a residual stays abnormal after it was beyond its threshold
        fault_free_after: time after the rule of a fault last held from which other rules take the fault as absent
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
        larger: pairs of residuals, the first of which has the larger magnitude over its threshold
        fault_free: other faults of the table whose rules must not hold
        weights: weights of residuals in the score, where they differ from 1
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
        """Every residual that the rule names, once."""
        named = [*self.abnormal, *self.normal, *self.positive, *self.negative]
        return tuple(dict.fromkeys([*named, *(each for pair in self.larger for each in pair)]))

    @property
    def raised(self) -> frozenset[str]:
        """Residuals that must be abnormal, of either sign."""
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
        name: short name
        description: description in one sentence
        source: origin of the rules
        rules: one rule for each fault
        timing: times of symptoms and rules
        one_fault: whether one fault at a time is assumed; rules that hold together then give candidates, no fault
    """

    name: str
    description: str
    source: str
    rules: tuple[SymptomRule, ...]
    timing: Timing
    one_fault: bool = True

    @property
    def residuals(self) -> tuple[str, ...]:
        """Every residual that any rule names, in order of appearance."""
        return tuple(dict.fromkeys(each for rule in self.rules for each in rule.residuals))

    @property
    def faults(self) -> tuple[str, ...]:
        """Every fault that has a rule."""
        return tuple(rule.fault for rule in self.rules)

    def not_isolable(self) -> tuple[tuple[str, str], ...]:
        """Pairs of faults that symptoms cannot isolate: the rule of one holds wherever that of the other does."""
        return tuple((a.fault, b.fault) for a, b in combinations(self.rules, 2) if a.implies(b) or b.implies(a))
