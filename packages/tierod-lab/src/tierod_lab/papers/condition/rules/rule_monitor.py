"""The rules as a monitor: residuals, thresholds, symptoms, and the status of every sensor and actuator."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from pathlib import Path
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import (
    absolute,
    all_of,
    any_of,
    both,
    either,
    greatest_of,
    maximum,
    minimum,
    negated,
    present,
    where,
)
from tierod.core.statuses import Statement, Status, code_of
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.monitors.condition.judge import Residual, SpanOfFault, Spans
from tierod.monitors.condition.reaction import ConditionOutput, FaultReaction, Judged, ReactionState
from tierod.monitors.condition.signals import (
    ACTUATORS,
    ELEMENTS,
    OF_AUTOMATED,
    SENSORS,
    ConditionSample,
    Elements,
    Statements,
    readings_by,
)
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, CarParameters, ResidualCalibration
from tierod_lab.papers.condition.rules.residual_set import MAIN, ResidualSet, residual_set

HALF = 3.8
"""Residual in standard deviations that lies at its threshold [-]: half a threshold, which fault-free drives hardly
reach, is then as likely with as without a fault."""

VARIANTS = ("rules-printed", "rules", "rules-discriminating")
"""Names of the tables of symptoms, and of the variants of the monitor."""


@dataclass(frozen=True)
class SymptomRule:
    """Symptoms of one fault in the residuals; the keys are those of symptoms.toml."""

    fault: str
    abnormal: tuple[str, ...] = ()
    normal: tuple[str, ...] = ()
    positive: tuple[str, ...] = ()
    negative: tuple[str, ...] = ()
    larger: tuple[tuple[str, ...], ...] = ()
    fault_free: tuple[str, ...] = ()

    @property
    def raised(self) -> frozenset[str]:
        """Residuals that must be abnormal, of either sign."""
        return frozenset((*self.abnormal, *self.positive, *self.negative))

    def conditions(self, ratios: Mapping[str, Scalar]) -> list[tuple[Scalar, Scalar]]:
        """(ratio of a residual to its threshold, whether it is as the rule asks) of every condition."""
        return [
            *((ratios[name], absolute(ratios[name]) >= 1.0) for name in self.abnormal),
            *((ratios[name], absolute(ratios[name]) < 1.0) for name in self.normal),
            *((ratios[name], ratios[name] >= 1.0) for name in self.positive),
            *((ratios[name], ratios[name] <= -1.0) for name in self.negative),
            *((ratios[name], absolute(ratios[name]) > absolute(ratios[other])) for name, other in self.larger),
        ]


@dataclass(frozen=True)
class SymptomTable:
    """Rules that are evaluated side by side."""

    source: str
    rule: tuple[SymptomRule, ...]  # one for each fault, after those that it depends on
    # time for which a rule must hold without a break before its fault is declared
    confirm_time: Annotated[float, "s", NOT_NEGATIVE]
    hold_on: Annotated[float, "s", NOT_NEGATIVE]  # time for which a residual stays abnormal after it was
    # time after the rule of a fault last held from which other rules take the fault as absent
    fault_free_after: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    # whether one fault at a time is assumed; rules that hold together then give candidates, no fault
    one_fault: bool = True

    @property
    def residuals(self) -> tuple[str, ...]:
        """Every residual that any rule names."""
        named = (
            name
            for rule in self.rule
            for name in (*rule.abnormal, *rule.normal, *rule.positive, *rule.negative, *sum(rule.larger, ()))
        )
        return tuple(dict.fromkeys(named))


@lru_cache(maxsize=3)
def symptoms(variant: str) -> SymptomTable:
    """The table of one of `VARIANTS`."""
    document = Document.read(Path(__file__).with_name("symptoms.toml"), "rule")
    table: SymptomTable = build(SymptomTable, document.content[variant], document, (variant,))
    return table


class Held(NamedTuple):
    """Held symptom of a residual: last abnormal ratio to its threshold, and remaining hold-on time [s]."""

    ratio: Scalar
    left: Scalar


class Isolation(NamedTuple):
    """What the rules say: flag of every fault, whether it is one of several candidates, and its score.

    A score is the share of the conditions of the rule that hold, among those whose residuals are present.
    """

    faulty: Mapping[str, Scalar]
    candidates: Mapping[str, Scalar]
    scores: Mapping[str, Scalar]


@dataclass(frozen=True)
class RuleMonitor:
    """Status of six sensors and four actuators by rules.

    Args:
        thresholds: threshold of every residual, in the order of `RESIDUALS`; infinite for one that is never judged
        least_score: share of a rule's conditions that must hold for its fault to be a candidate

    Build it by `rule_monitor`.
    """

    residuals: ResidualSet
    thresholds: tuple[Annotated[float, "unit of the signal", POSITIVE], ...]
    table: SymptomTable
    spans: SpanOfFault
    sample_time: Annotated[float, "s", POSITIVE]
    least_score: Annotated[float, "", POSITIVE] = 0.75

    Sample = ConditionSample

    class State(NamedTuple):
        residuals: ResidualSet.State
        symptoms: tuple[Held, ...]
        held: tuple[Scalar, ...]  # time for which each rule has held [s]
        since_held: tuple[Scalar, ...]  # remaining time in which each fault does not count as absent [s]
        faulty: tuple[Scalar, ...]
        spans: Spans

    Output = Judged

    def init(self) -> State:
        zeros = (0.0,) * len(self.table.rule)
        held = (Held(0.0, 0.0),) * len(self.table.residuals)
        return self.State(self.residuals.init(), held, zeros, zeros, (0.0,) * len(OF_AUTOMATED), Spans.initial())

    def step(self, state: State, sample: ConditionSample) -> tuple[State, Judged]:
        # With the verdict of the last sample, since that of this one depends on the residuals of the actuators.
        faulty = dict(zip(OF_AUTOMATED, state.faulty, strict=True))
        residuals, seen = self.residuals.step(state.residuals, sample, faulty)
        ratios = self._ratios(seen)
        after, isolation = self._isolation(state, ratios)
        expected = {}
        for name, main in MAIN.items():
            reading = getattr(seen.held, name)
            there = getattr(seen.there, main) > 0.5
            expected[name] = where(there, reading + getattr(seen.residuals, main), reading)
        blind = self._blind(seen, expected)
        settled = {name: each > self.residuals.settling for name, each in residuals.waited._asdict().items()}
        statements = self._statements(isolation, blind, _exceeding(ratios, settled))
        spans, statements = state.spans.followed_by(statements, self._sizes(ratios, seen), self.spans)
        testable = {name: 1.0 - each for name, each in blind.items()}
        judged = Judged(
            statements,
            Elements(*(testable.get(name, 0.0 if name in SENSORS else 1.0) for name in ELEMENTS)),
            Elements(*(0.0,) * len(ELEMENTS)),
            readings_by(expected),
            readings_by({}),
            greatest_of(*(each.evidence for each in statements)),
            0.0,
            spans.supported,
            spans.ended(self.spans),
        )
        return self.State(residuals, *after, tuple(isolation.faulty[name] for name in OF_AUTOMATED), spans), judged

    def _ratios(self, seen: ResidualSet.Output) -> dict[str, Scalar]:
        """Ratios of the residuals to their thresholds; infinite, which counts as missing, where one is not present.

        A residual that was never present on fault-free drives has an infinite threshold; it is neither normal nor
        abnormal.
        """
        return {
            name: where(both(there > 0.5, present(threshold)), value / threshold, math.inf)
            for name, value, there, threshold in zip(
                RESIDUALS, seen.residuals, seen.there, self.thresholds, strict=True
            )
        }

    def _isolation(
        self, state: State, ratios: Mapping[str, Scalar]
    ) -> tuple[tuple[tuple[Held, ...], tuple[Scalar, ...], tuple[Scalar, ...]], Isolation]:
        """Evaluate all rules."""
        table, time = self.table, self.sample_time
        pairs = [self._symptom(held, ratios[name]) for held, name in zip(state.symptoms, table.residuals, strict=True)]
        shown = dict(zip(table.residuals, (ratio for _, ratio in pairs), strict=True))
        confirmed = maximum(table.confirm_time, 0.75 * time) - 0.5 * time  # half a sample of tolerance for rounding
        held: dict[str, Scalar] = {}
        since_held: dict[str, Scalar] = {}
        scores: dict[str, Scalar] = {}
        for rule, before, left in zip(table.rule, state.held, state.since_held, strict=True):
            conditions = rule.conditions(shown)
            total = sum((where(present(ratio), 1.0, 0.0) for ratio, _ in conditions), start=0.0)
            found = sum((where(both(present(ratio), so), 1.0, 0.0) for ratio, so in conditions), start=0.0)
            scores[rule.fault] = where(total > 0.0, found / where(total > 0.0, total, 1.0), 0.0)
            absent = [since_held[name] < 0.5 * time for name in rule.fault_free]
            holds = all_of(*(both(present(ratio), so) for ratio, so in conditions), *absent)
            held[rule.fault] = where(holds, minimum(before + time, table.confirm_time + time), 0.0)
            since = maximum(table.fault_free_after, time)
            since_held[rule.fault] = where(held[rule.fault] > confirmed, since, maximum(left - time, 0.0))
        flags = {name: where(each > confirmed, 1.0, 0.0) for name, each in held.items()}
        beyond = {name: both(present(each), absolute(each) >= 1.0) for name, each in shown.items()}
        isolation = self._isolated(flags, scores, beyond)
        return (tuple(symptom for symptom, _ in pairs), tuple(held.values()), tuple(since_held.values())), isolation

    def _symptom(self, before: Held, ratio: Scalar) -> tuple[Held, Scalar]:
        """Held symptom and effective ratio of a residual: an abnormal one holds on, a missing one is no symptom."""
        beyond = both(present(ratio), absolute(where(present(ratio), ratio, 0.0)) >= 1.0)
        left = where(beyond, self.table.hold_on, maximum(before.left - self.sample_time, 0.0))
        held = where(beyond, ratio, before.ratio)
        return Held(held, left), where(left > 0.5 * self.sample_time, held, ratio)

    def _isolated(
        self, flags: Mapping[str, Scalar], scores: Mapping[str, Scalar], beyond: Mapping[str, Scalar]
    ) -> Isolation:
        """Faults and candidates among the sensors, and among the actuators.

        Candidates are faults whose rules hold together, and, where an abnormal residual is explained by no rule, those
        of the best score.
        """
        faulty, candidates = {}, {}
        for group in (OF_AUTOMATED, ACTUATORS):
            known = frozenset().union(*(rule.raised for rule in self.table.rule if rule.fault in group))
            count: Scalar = sum((flags[name] for name in group), start=0.0)
            best: Scalar = greatest_of(0.0, *(scores[name] for name in group))
            abnormal: Scalar = any_of(0.0, *(each for name, each in beyond.items() if name in known))
            unknown = all_of(count < 0.5, abnormal, best >= self.least_score)
            for name in group:
                fits = both(unknown, scores[name] >= best - 1e-9)
                candidates[name] = where(either(both(count > 1.5, flags[name]), fits), 1.0, 0.0)
                faulty[name] = where(count > 1.5, 0.0, flags[name]) if self.table.one_fault else flags[name]
        return Isolation(faulty, candidates, scores)

    def _sizes(self, ratios: Mapping[str, Scalar], seen: ResidualSet.Output) -> dict[str, Residual]:
        """Main residual of every sensor, and the smallest of all that the rule of an actuator takes as abnormal."""
        found = {
            name: Residual(HALF * ratios[main], present(ratios[main]), reading=getattr(seen.held, name))
            for name, main in MAIN.items()
        }
        for rule in self.table.rule:
            if rule.fault in ACTUATORS and rule.raised:
                least = reduce(minimum, (absolute(ratios[name]) for name in sorted(rule.raised)))
                found[rule.fault] = Residual(HALF * least, present(least))
        return found

    def _statements(self, isolation: Isolation, blind: Mapping[str, Scalar], exceeding: Scalar) -> Statements:
        """Status and score of every element; rules estimate neither kind nor magnitude.

        Every element is a candidate while a residual exceeds its limit and no rule explains it.
        """
        # A single candidate is no explanation either: its rule does not hold.
        explained = either(any_of(0.0, *isolation.faulty.values()), sum(isolation.candidates.values(), 0.0) > 1.5)
        unexplained = both(exceeding, negated(explained))
        made = []
        for name in ELEMENTS:
            # Sensors that the rules do not use, such as front wheels, are never testable nor declared.
            unseen = blind.get(name, 0.0 if name in ACTUATORS else 1.0)
            faulty, candidate, score = (each.get(name, 0.0) for each in isolation)
            quiet = where(unseen > 0.5, code_of(Status.NOT_TESTABLE), code_of(Status.HEALTHY))
            suspect = either(candidate > 0.5, both(unexplained, 1.0 if name in isolation.scores else 0.0))
            status = where(faulty > 0.5, code_of(Status.FAULT), where(suspect, code_of(Status.SUSPECT), quiet))
            made.append(Statement(status, 0.0, 0.0, 0.0, 0.0, score))
        return Statements(*made)

    def _blind(self, seen: ResidualSet.Output, expected: Mapping[str, Scalar]) -> dict[str, Scalar]:
        """Flag of each sensor whose loss would not show.

        Reading and expected reading are within the threshold of the main residual, or that residual is missing.
        """
        bounds = dict(zip(RESIDUALS, self.thresholds, strict=True))
        flags = {}
        for name, main in MAIN.items():
            there = getattr(seen.there, main) > 0.5
            near = both(absolute(expected[name]) < bounds[main], absolute(getattr(seen.held, name)) < bounds[main])
            flags[name] = where(all_of(there, near), 1.0, where(there, 0.0, 1.0))
        return flags


def _exceeding(ratios: Mapping[str, Scalar], settled: Mapping[str, Scalar]) -> Scalar:
    """Whether any residual exceeds its limit; one without a signal, or whose filters have just begun, does not."""
    found = []
    for name, ratio in ratios.items():
        sensors: Sequence[Scalar] = [settled[each] for each in RESIDUALS[name].signals if each in settled]
        found.append(all_of(present(ratio), absolute(ratio) > 1.0, *sensors))
    return any_of(0.0, *found)


@dataclass(frozen=True)
class RulesWithReaction:
    """The rules as a variant of the monitor, with the reaction to their statements."""

    monitor: RuleMonitor  # the rules
    reaction: FaultReaction  # substitutes of the sensors and trouble codes

    Sample = ConditionSample
    Output = ConditionOutput

    class State(NamedTuple):
        monitor: RuleMonitor.State
        reaction: ReactionState

    def init(self) -> State:
        return self.State(self.monitor.init(), self.reaction.init())

    def step(self, state: State, sample: ConditionSample) -> tuple[State, ConditionOutput]:
        monitor, judged = self.monitor.step(state.monitor, sample)
        reaction, output = self.reaction.step(state.reaction, sample, judged)
        return self.State(monitor, reaction), output


def rule_monitor(
    car: CarParameters, calibration: ResidualCalibration, variant: str = "rules", sample_time: float = 0.01
) -> RuleMonitor:
    """A variant of the rules for a vehicle.

    Args:
        calibration: calibration of `calibrate_residuals`, whose `printed` suits the variant
        variant: one of `VARIANTS`
        sample_time: sampling interval [s]
    """
    return RuleMonitor(
        residual_set(car, calibration.coefficients, sample_time, calibration.printed),
        tuple(calibration.thresholds[name] for name in RESIDUALS),
        symptoms(variant),
        SpanOfFault(sample_time, lasting=True),
        sample_time,
    )
