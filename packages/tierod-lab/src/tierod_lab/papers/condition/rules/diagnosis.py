"""Evaluation of all rules of a table: declared faults, candidates, and a score for every fault."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import (
    absolute,
    all_of,
    any_of,
    both,
    either,
    greatest_of,
    maximum,
    minimum,
    present,
    where,
)
from tierod_lab.papers.condition.rules.symptoms import SymptomRule, SymptomTable


@lru_cache(maxsize=64)
def ratios_class(residuals: tuple[str, ...]) -> type:
    """NamedTuple class of the signed ratio of each residual to its threshold; not finite where one is missing."""
    return named_tuple("Ratios", [(name, Annotated[float, ""]) for name in residuals])


@lru_cache(maxsize=64)
def faults_class(faults: tuple[str, ...]) -> type:
    """NamedTuple class with one number for each fault of a table."""
    return named_tuple("Faults", [(name, Annotated[float, ""]) for name in faults])


class Held(NamedTuple):
    """Held symptom of a residual: last abnormal ratio to its threshold, and remaining hold-on time [s]."""

    ratio: Scalar
    left: Scalar


@dataclass(frozen=True)
class RuleDiagnosis:
    """Evaluates all rules of a table at every sample.

    Args:
        groups: groups of faults, within each of which one fault at a time is assumed; all faults if empty
        least_score: score from which the best faults are candidates where a residual is abnormal but no rule holds

    The output has a number for each fault. `faulty`: 1 where its rule has held for the confirm time and, with
    `one_fault`, no other rule of its group has. `candidates`: 1 for each of several faults whose rules hold together,
    or, where no rule holds, for those with the best score; they are not isolable from each other. `scores`: weighted
    share of the conditions of its rule that hold, among those whose residuals are present.
    """

    table: SymptomTable
    sample_time: Annotated[float, "s", POSITIVE]
    groups: tuple[tuple[str, ...], ...] = ()
    least_score: Annotated[float, "", POSITIVE] = 0.75

    @property
    def Sample(self) -> type:
        """NamedTuple class of the residuals that the rules name."""
        return ratios_class(self.table.residuals)

    class Output(NamedTuple):
        faulty: Tree
        candidates: Tree
        scores: Tree
        abnormal: Scalar

    class State(NamedTuple):
        symptoms: tuple[Held, ...]
        held: tuple[Scalar, ...]
        since_held: tuple[Scalar, ...]

    def init(self) -> State:
        count = len(self.table.rules)
        return self.State((Held(0.0, 0.0),) * len(self.table.residuals), (0.0,) * count, (0.0,) * count)

    def step(self, state: State, sample: Tree) -> tuple[State, Output]:
        pairs = [self._symptom(held, ratio) for held, ratio in zip(state.symptoms, sample, strict=True)]
        ratios = dict(zip(self.table.residuals, (ratio for _, ratio in pairs), strict=True))
        longest = self.table.timing.confirm_time + self.sample_time
        held: dict[str, Scalar] = {}
        since_held: dict[str, Scalar] = {}
        scores = {}
        for rule, before, left in zip(self.table.rules, state.held, state.since_held, strict=True):
            matched, scores[rule.fault] = _fit(rule, ratios)
            # Rules are in order of dependence (see `symptom_files`), so `since_held` already has those named here.
            fault_free = [since_held[name] < 0.5 * self.sample_time for name in rule.fault_free]
            holds = all_of(matched, *fault_free)
            held[rule.fault] = where(holds, minimum(before + self.sample_time, longest), 0.0)
            kept = maximum(left - self.sample_time, 0.0)
            after = maximum(self.table.timing.fault_free_after, self.sample_time)
            since_held[rule.fault] = where(held[rule.fault] > self._confirmed, after, kept)
        flags = {name: where(each > self._confirmed, 1.0, 0.0) for name, each in held.items()}
        seen = {name: where(both(present(each), absolute(each) >= 1.0), 1.0, 0.0) for name, each in ratios.items()}
        state = self.State(tuple(symptom for symptom, _ in pairs), tuple(held.values()), tuple(since_held.values()))
        return state, self._said(flags, scores, seen)

    @property
    def _confirmed(self) -> Scalar:
        """Time for which a rule must hold, with half a sample of tolerance for rounding [s]."""
        return maximum(self.table.timing.confirm_time, 0.75 * self.sample_time) - 0.5 * self.sample_time

    def _symptom(self, before: Held, ratio: Scalar) -> tuple[Held, Scalar]:
        """Held symptom and effective ratio of a residual: an abnormal one holds on, a missing one is no symptom."""
        beyond = both(present(ratio), absolute(where(present(ratio), ratio, 0.0)) >= 1.0)
        left = where(beyond, self.table.timing.hold_on, maximum(before.left - self.sample_time, 0.0))
        held = where(beyond, ratio, before.ratio)
        return Held(held, left), where(left > 0.5 * self.sample_time, held, ratio)

    def _said(self, flags: dict[str, Scalar], scores: dict[str, Scalar], seen: dict[str, Scalar]) -> Output:
        faulty, candidates = {}, {}
        raised = {rule.fault: rule.raised for rule in self.table.rules}
        for group in self.groups or (self.table.faults,):
            names = [name for name in group if name in flags]
            known = frozenset().union(*(raised[name] for name in names))
            count: Scalar = sum((flags[name] for name in names), start=0.0)
            best: Scalar = greatest_of(0.0, *(scores[name] for name in names))
            abnormal: Scalar = any_of(0.0, *(seen[each] for each in self.table.residuals if each in known))
            unknown = all_of(count < 0.5, abnormal, best >= self.least_score)
            for name in names:
                fits = both(unknown, scores[name] >= best - 1e-9)
                candidates[name] = where(either(both(count > 1.5, flags[name]), fits), 1.0, 0.0)
                faulty[name] = where(count > 1.5, 0.0, flags[name]) if self.table.one_fault else flags[name]
        of = faults_class(self.table.faults)
        return self.Output(of(**faulty), of(**candidates), of(**scores), where(any_of(0.0, *seen.values()), 1.0, 0.0))


def _fit(rule: SymptomRule, ratios: dict[str, Scalar]) -> tuple[Scalar, Scalar]:
    asked: list[tuple[str, Scalar]] = []
    for name in rule.abnormal:
        asked.append((name, absolute(ratios[name]) >= 1.0))
    for name in rule.normal:
        asked.append((name, absolute(ratios[name]) < 1.0))
    for name in rule.positive:
        asked.append((name, ratios[name] >= 1.0))
    for name in rule.negative:
        asked.append((name, ratios[name] <= -1.0))
    for name, other in rule.larger:
        asked.append((name, absolute(ratios[name]) > absolute(ratios[other])))
    weights = dict(rule.weights)
    total: Scalar = 0.0
    found: Scalar = 0.0
    for name, so in asked:
        weight = weights.get(name, 1.0)
        total = total + where(present(ratios[name]), weight, 0.0)
        found = found + where(both(present(ratios[name]), so), weight, 0.0)
    matched = all_of(*(both(present(ratios[name]), so) for name, so in asked))
    return matched, where(total > 0.0, found / where(total > 0.0, total, 1.0), 0.0)
