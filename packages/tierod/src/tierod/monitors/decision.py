"""Declared decision rules of a monitor: false alarm rates, checks of the running code, and what a report shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from operator import attrgetter
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.findings import Curve, Decided
from tierod.methods.analysis.consistency import gamma_quantile
from tierod.methods.detectors import Cusum, HeldThreshold
from tierod.methods.detectors.rule_design import RuleDesign

Unit = Literal["h", "recording", "car"]


@dataclass(frozen=True)
class Demonstrated:
    """False alarms observed on fault-free data that no threshold was tuned on."""

    observed: float  # amount of data: hours, recordings or cars
    alarms: int = 0  # number of false alarms

    def __post_init__(self) -> None:
        if not (self.observed > 0.0 and self.alarms >= 0):
            raise ValueError(
                f"observed is {self.observed} and alarms {self.alarms}; expected observed above zero and "
                "alarms not negative"
            )

    @property
    def most(self) -> float:
        """Upper 95 % confidence bound of the false alarm rate, per unit observed; about 3 / observed without alarms."""
        return gamma_quantile(self.alarms + 1.0, 0.95) / self.observed

    def stated(self, unit: Unit) -> str:
        """Observed amount and bound of the rate, in words."""
        amount = f"{self.observed:.3g} h" if unit == "h" else f"{self.observed:.0f} {unit}s"
        seen = {0: "none", 1: "one"}.get(self.alarms, str(self.alarms))
        return f"{seen} in {amount}, so fewer than {self.most:.2g} per {unit} at 95 %"


@dataclass(frozen=True)
class OwnRule:
    """Numbers of a rule that is no block of `tierod.methods.detectors`, such as bounds or counts of events."""

    stated: str  # the rule in words, with its numbers
    values: Mapping[str, float]  # numbers by name of the attribute that holds them


@dataclass(frozen=True)
class Decision:
    """Decision of a monitor: a statistic, a stopping rule with its threshold, and the false alarm rate."""

    name: str  # name of the decision
    distance: str  # statistic of the rule, and its unit
    rule: Any  # block of `tierod.methods.detectors` that decides, with its threshold, or `OwnRule`
    # path of the rule in a session by attributes ("block.verdict.alarm"); "" for the session itself, and before
    # `declared` has set it
    place: str
    mean_time_between_false_alarms: float | None  # design value [unit]; None if only `demonstrated` is known
    demonstrated: Demonstrated | None  # observations on fault-free data; None without observations
    source: str  # where the design and its measurement are documented
    unit: Unit = "h"  # "h", or "recording" or "car" for a rule that tests each of them once
    design: RuleDesign | None = None  # design of the threshold; None if there is no statistic to design with
    statistic: str = ""  # trace of the report that the rule compares with its thresholds; "" without a trace
    # thresholds in the unit of that trace, or of the value that a single test of a recording compares
    levels: tuple[float, ...] = ()
    level: str = ""  # path of the threshold in a session by attributes if the vehicle file gives it; "" otherwise
    below: bool = False  # whether the rule acts below its levels; otherwise above positive and below negative ones

    def levels_in(self, session: Any) -> tuple[float, ...]:
        """Thresholds in effect in a session."""
        if self.level:
            return (float(attrgetter(self.level)(session)),)
        if self.statistic or isinstance(self.rule, OwnRule) or self.levels:
            return self.levels
        # A single test of a recording: the threshold of the rule itself.
        sides = {"upper": (1.0,), "lower": (-1.0,)}.get(self.rule.sides, (1.0, -1.0))
        return tuple(side * self.rule.threshold for side in sides)

    @property
    def rule_in_words(self) -> str:
        """Rule in words, with its threshold."""
        return rule_in_words(self.rule)

    @property
    def false_alarms_in_words(self) -> str:
        """Designed and demonstrated false alarm rate, in words."""
        shown = self.demonstrated.stated(self.unit) if self.demonstrated else "nothing observed"
        if self.mean_time_between_false_alarms is None:
            return f"demonstrated: {shown}" if self.demonstrated else shown
        unit = "h" if self.unit == "h" else f"{self.unit}s"
        mean = self.mean_time_between_false_alarms
        wanted = f"{mean:,.0f}".replace(",", " ") if 100.0 <= mean < 1e7 else f"{mean:.2g}"
        return f"designed: one in {wanted} {unit}; demonstrated: {shown}"

    def part_of(self, session: Any) -> Any:
        """Part of a session that decides; None if the vehicle does not have that part."""
        return attrgetter(self.place)(session) if self.place else session

    def departures(self, session: Any) -> tuple[str, ...]:
        """Sentences on differences between the rule in a session and the declared one; empty if they agree."""
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


def decides(*decisions: Decision) -> Mapping[str, Any]:
    """Metadata of the field of a block that holds a rule or its thresholds: the decisions that it makes."""
    return {"decisions": decisions}


def declared(kind: type, place: str) -> tuple[Decision, ...]:
    """Decisions that the fields of a block declare by `decides`, for a block at this path in its session."""
    return tuple(
        replace(decision, place=f"{place}.{each.name}")
        for each in fields(kind)
        for decision in each.metadata.get("decisions", ())
    )


def _reached(part: Any, name: str) -> Any:
    try:
        return attrgetter(name)(part)
    except AttributeError:
        return None


def _alike(part: Any, rule: Any) -> bool:
    """Whether two blocks are equal within rounding errors."""
    if type(part) is not type(rule):
        return False
    pairs = [(getattr(part, name), getattr(rule, name)) for name in rule.__dataclass_fields__]
    return all(math.isclose(a, b, rel_tol=1e-9) if isinstance(b, float) else a == b for a, b in pairs)


def rule_in_words(rule: Any) -> str:
    """Rule of a decision in words, with its numbers."""
    sides = {"both": ", either side", "upper": ", above", "lower": ", below"}.get(getattr(rule, "sides", ""), "")
    if isinstance(rule, OwnRule):
        return rule.stated
    if isinstance(rule, Cusum):
        forgiven = f"drift {rule.drift:.3g} per value, " if rule.drift else ""
        return f"cumulative sum{sides}: {forgiven}threshold {rule.threshold:.4g}"
    if isinstance(rule, HeldThreshold):
        held = f" in {rule.hold} values one after the other" if rule.hold > 1 else ""
        return f"threshold {rule.threshold:.4g}{sides}{held}"
    return str(rule)


class Passing:
    """Follows the statistic of every decision of a session: its extreme value, and when it passes its threshold.

    Args:
        decisions: decisions of the variant; those without a statistic are ignored

    `reached` holds the extreme values, `passed` the times of the first passage [s], both by name of the decision.
    """

    def __init__(self, decisions: Iterable[Decision], session: Any):
        taken = [each for each in decisions if each.statistic and each.part_of(session) is not None]
        self._levels = {each.name: each.levels_in(session) for each in taken}
        self._decisions = {each.name: each for each in taken}
        self.reached: dict[str, float] = {}
        self.passed: dict[str, float] = {}

    def add(self, time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        """Add the next piece."""
        for name, decision in self._decisions.items():
            values = shown.get(decision.statistic)
            if values is not None and np.isfinite(values).any():
                self._follow(name, decision.below, time, values)

    def _follow(self, name: str, below: bool, time: np.ndarray, values: np.ndarray) -> None:
        sides = _sides(self._levels[name], below)
        extremes = [float(np.nanmin(values)) if low else float(np.nanmax(values)) for low, _ in sides]
        known = [*extremes, *([self.reached[name]] if name in self.reached else [])]
        self.reached[name] = min(known) if below else max(known, key=abs)
        reaches = [each <= level if low else each >= level for each, (low, level) in zip(extremes, sides, strict=True)]
        if name in self.passed or not any(reaches):
            return
        beyond = np.any([values <= level if low else values >= level for low, level in sides], axis=0)
        self.passed[name] = float(time[np.argmax(beyond)])


def _sides(levels: tuple[float, ...], below: bool) -> list[tuple[bool, float]]:
    """(whether the rule acts below the level, level) of every level; a rule without a level is never passed."""
    return [(below or level < 0.0, level) for level in levels] or [(False, np.inf)]


SHARES = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
"""Thresholds of a trade-off curve, as shares of the designed threshold [-]."""

SIZES = 25  # Intervals of a curve of detection probability over the size of the change


def decided(
    decisions: Iterable[Decision],
    session: Any,
    reached: Mapping[str, float] = MappingProxyType({}),
    passed: Mapping[str, float] = MappingProxyType({}),
) -> tuple[Decided, ...]:
    """Decisions of a session for its report, without those of parts that the vehicle lacks."""
    return tuple(
        Decided(
            each.name,
            each.distance,
            each.rule_in_words,
            each.false_alarms_in_words,
            each.source,
            each.statistic,
            each.levels_in(session),
            curve_of(each),
            each.below,
            reached.get(each.name),
            passed.get(each.name),
        )
        for each in decisions
        if each.part_of(session) is not None
    )


def curve_of(decision: Decision) -> Curve | None:
    """Trade-off curve of a rule: detection delay over mean time between false alarms.

    For a single test per recording it is the probability of detection over the size of the change instead.
    """
    design = decision.design
    if design is None:
        return None
    if math.isinf(design.spacing):
        sizes = [2.0 * design.threshold * number / SIZES for number in range(SIZES + 1)]
        chances = [1.0 / design.rule.run_length(design.threshold, size) for size in sizes]
        title = "size of the change [standard deviations]"
        return Curve(tuple(sizes), tuple(chances), title, "chance to find it", (design.threshold, 0.5), chance=True)
    points = []
    for share in SHARES:
        threshold = share * design.threshold
        try:
            hours = design.run_length(threshold) * design.spacing / 3600.0
            points.append((hours, design.delay(threshold) * design.spacing))
        except ParameterError:
            continue
    points = [point for point in points if all(map(math.isfinite, point))]
    chosen = (
        design.values * design.spacing / 3600.0,
        design.delay(design.threshold) * design.spacing,
    )
    along, up = zip(*points, strict=True) if points else ((), ())
    return Curve(along, up, "between false alarms [h]", "delay at the shift [s]", chosen)
