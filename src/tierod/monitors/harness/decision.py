"""Decisions of a monitor, and their false alarm rates: declared, shown to users, and checked against what runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Literal

from tierod.methods.analysis.gamma import gamma_quantile
from tierod.methods.detectors import Cusum, GeometricAverage, HeldThreshold, LikelihoodRatio, SequentialTest
from tierod.methods.detectors.rule_design import RuleDesign

Unit = Literal["h", "recording", "car"]


@dataclass(frozen=True)
class Demonstrated:
    """Observations on fault-free data that no threshold was tuned on.

    Args:
        observed: hours, recordings or cars
        alarms: false ones
    """

    observed: float
    alarms: int = 0

    def __post_init__(self) -> None:
        if not (self.observed > 0.0 and self.alarms >= 0):
            raise ValueError(f"observed is {self.observed} and alarms {self.alarms}; expected some, and none or more")

    @property
    def most(self) -> float:
        """Upper 95 % bound of the rate, false alarms per unit observed: three over the observed time without any."""
        return gamma_quantile(self.alarms + 1.0, 0.95) / self.observed

    def stated(self, unit: Unit) -> str:
        """In words: the observed time and its bound."""
        amount = f"{self.observed:.3g} h" if unit == "h" else f"{self.observed:.0f} {unit}s"
        seen = {0: "none", 1: "one"}.get(self.alarms, str(self.alarms))
        return f"{seen} in {amount}, so fewer than {self.most:.2g} per {unit} at 95 %"


@dataclass(frozen=True)
class OwnRule:
    """Numbers of a part that decides by its own rule: bounds of a fault-free part, or a count of such events.

    Args:
        stated: the rule in words, with these numbers
        values: name of the part's attribute -> value
    """

    stated: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Decision:
    """One way in which a monitor turns a number into a statement: residual, distance, stopping rule.

    Args:
        name: of the decision
        distance: statistic of the rule, and its unit
        rule: the block of `tierod.methods.detectors` that decides, with its threshold, or `OwnRule`
        place: where it is in a session, attribute by attribute ("block.verdict.alarm"); "" for the session itself
        mean_time_between_false_alarms: that it is designed for [unit]; None where only `demonstrated` is known
        demonstrated: on fault-free data; None where nothing was observed
        source: where the design was made and measured
        unit: "h", or "recording" or "car" for a rule that looks once at each
        design: from which the threshold follows; None where there is no statistic to design with
        statistic: trace of the report that the rule compares; "" where there is none
        levels: thresholds in the unit of that trace, or of the value that one look at a recording tests
        level: where a session has the threshold, attribute by attribute, where the vehicle file gives it; "" elsewhere
        below: whether the rule acts below its levels; else it acts above positive ones and below negative ones
    """

    name: str
    distance: str
    rule: Any
    place: str
    mean_time_between_false_alarms: float | None
    demonstrated: Demonstrated | None
    source: str
    unit: Unit = "h"
    design: RuleDesign | None = None
    statistic: str = ""
    levels: tuple[float, ...] = ()
    level: str = ""
    below: bool = False

    def levels_in(self, session: Any) -> tuple[float, ...]:
        """The thresholds in effect in a session."""
        if self.level:
            return (float(attrgetter(self.level)(session)),)
        if self.statistic or isinstance(self.rule, OwnRule) or self.levels:
            return self.levels
        # One look at a recording: the threshold of the rule itself.
        sides = {"upper": (1.0,), "lower": (-1.0,)}.get(self.rule.sides, (1.0, -1.0))
        return tuple(side * self.rule.threshold for side in sides)

    @property
    def rule_in_words(self) -> str:
        """The rule in words, with its threshold."""
        return rule_in_words(self.rule)

    @property
    def false_alarms_in_words(self) -> str:
        """In words: the designed rate, and the demonstrated one."""
        shown = self.demonstrated.stated(self.unit) if self.demonstrated else "nothing observed"
        if self.mean_time_between_false_alarms is None:
            return f"demonstrated: {shown}" if self.demonstrated else shown
        unit = "h" if self.unit == "h" else f"{self.unit}s"
        mean = self.mean_time_between_false_alarms
        wanted = f"{mean:,.0f}".replace(",", " ") if 100.0 <= mean < 1e7 else f"{mean:.2g}"
        return f"designed: one in {wanted} {unit}; demonstrated: {shown}"

    def part_of(self, session: Any) -> Any:
        """The part of a session that decides; None where the vehicle does not have it.

        Raises:
            AttributeError: no session has such a part
        """
        return attrgetter(self.place)(session) if self.place else session

    def departures(self, session: Any) -> tuple[str, ...]:
        """Departures of a session from the rule as declared; empty where there are none."""
        try:
            part = self.part_of(session)
        except AttributeError:
            return (f"{self.name}: the session has no {self.place}",)
        if part is None:
            return ()
        if not isinstance(self.rule, OwnRule):
            return () if _alike(part, self.rule) else (f"{self.name}: {self.place} is {part}, declared {self.rule}",)
        found = {name: _reached(part, name) for name in self.rule.values}
        return tuple(
            f"{self.name}: {self.place}.{name} is {there}, declared {self.rule.values[name]}"
            for name, there in found.items()
            if not (isinstance(there, float | int) and math.isclose(there, self.rule.values[name], rel_tol=1e-9))
        )


def _reached(part: Any, name: str) -> Any:
    try:
        return attrgetter(name)(part)
    except AttributeError:
        return None


def _alike(part: Any, rule: Any) -> bool:
    """Whether two blocks are the same but for rounding."""
    if type(part) is not type(rule):
        return False
    pairs = [(getattr(part, name), getattr(rule, name)) for name in rule.__dataclass_fields__]
    return all(math.isclose(a, b, rel_tol=1e-9) if isinstance(b, float) else a == b for a, b in pairs)


def rule_in_words(rule: Any) -> str:
    """A block of `tierod.methods.detectors` in words, with its numbers."""
    sides = {"both": ", either side", "upper": ", above", "lower": ", below"}.get(getattr(rule, "sides", ""), "")
    if isinstance(rule, OwnRule):
        return rule.stated
    if isinstance(rule, Cusum):
        forgiven = f"{rule.drift:.3g} forgiven per value, " if rule.drift else ""
        return f"cumulative sum{sides}: {forgiven}threshold {rule.threshold:.4g}"
    if isinstance(rule, HeldThreshold):
        held = f" in {rule.hold} values one after the other" if rule.hold > 1 else ""
        return f"threshold {rule.threshold:.4g}{sides}{held}"
    if isinstance(rule, GeometricAverage):
        return f"geometric average{sides}: weight {rule.weight:.3g}, threshold {rule.threshold:.4g}"
    if isinstance(rule, SequentialTest):
        return f"sequential test: shift {rule.shift:.3g}, evidence {rule.upper:.3g} for and {rule.lower:.3g} against"
    if isinstance(rule, LikelihoodRatio):
        return f"likelihood ratio: threshold {rule.threshold:.4g}"
    return str(rule)
