"""Branches for a step that runs alone and need not vectorise, and chains of selections as one operation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from tierod.core.graph.operations import Operation, Program, drop_unused, invariant_of

FEWEST = 16
"""Smallest number of operations that a branch pays for: fewer cost less than a mispredicted jump."""


class Condition(NamedTuple):
    """Condition that a value is not zero; where `holds` is False, that it is zero."""

    value: int
    holds: bool


@dataclass(frozen=True)
class Branch:
    """Operations that are evaluated together.

    Args:
        condition: condition of their evaluation; None for those that are always needed
    """

    condition: Condition | None
    operations: tuple[int, ...]


def branches(program: Program) -> list[Branch]:
    """All operations of a step except the invariant ones, ordered so that each follows those that it needs.

    An operation whose result is used only under a condition is evaluated in a branch.
    """
    chosen = _chosen(program, _conditions(program))
    rounds = _rounds(program, chosen)
    parts: dict[tuple[int, Condition | None], list[int]] = {}
    for index, number in rounds.items():
        parts.setdefault((number, chosen.get(index)), []).append(index)
    ordered = sorted(parts.items(), key=lambda part: (part[0][0], part[0][1] is not None, part[1][0]))
    return [Branch(condition, tuple(operations)) for (_, condition), operations in ordered]


def _conditions(program: Program) -> dict[int, frozenset[Condition]]:
    """Conditions that hold wherever the result of an operation is used."""
    found: dict[int, frozenset[Condition]] = {value: frozenset() for value in program.outputs.values()}
    for index in range(len(program.operations) - 1, -1, -1):
        if index in program.invariant:
            continue
        own, operation = found.get(index, frozenset()), program.operations[index]
        for place, argument in enumerate(operation.arguments):
            under = own
            if operation.name in ("select", "if") and place > 0:
                under = own | {_condition(program, operation.arguments[0], place == 1)}
            found[argument] = found[argument] & under if argument in found else under
    return found


def _condition(program: Program, value: int, holds: bool) -> Condition:
    while program.operations[value].name == "not":
        value, holds = program.operations[value].arguments[0], not holds
    return Condition(value, holds)


def _chosen(program: Program, conditions: dict[int, frozenset[Condition]]) -> dict[int, Condition]:
    """For each operation the condition under which most operations are skipped; none where that saves too little."""
    worked = [
        index
        for index, operation in enumerate(program.operations)
        if index not in program.invariant and operation.name not in ("input", "constant")
    ]
    skipped = Counter(each for index in worked for each in conditions.get(index, ()))
    chosen = {}
    for index in worked:
        own = [each for each in conditions.get(index, ()) if each.value not in program.invariant]
        if own:
            chosen[index] = max(own, key=lambda each: (skipped[each], each))
    counted = Counter(chosen.values())
    return {index: each for index, each in chosen.items() if counted[each] >= FEWEST}


def _rounds(program: Program, chosen: dict[int, Condition]) -> dict[int, int]:
    """A round for every operation: branches of the same round do not need results of each other."""
    rounds: dict[int, int] = {}
    for index, operation in enumerate(program.operations):
        if index in program.invariant:
            continue
        own = chosen.get(index)
        needed: Sequence[int] = operation.arguments if own is None else (*operation.arguments, own.value)
        # A result of another branch is needed a round later; within a branch the order of the operations suffices.
        rounds[index] = max((rounds[each] + (chosen.get(each) != own) for each in needed if each in rounds), default=0)
    return rounds


SHORTEST_CHAIN = 8
"""Smallest number of values for which a table is faster than selections."""


def with_picks(program: Program) -> Program:
    """The same program with every chain "v1 if n == 1, v2 if n == 2, ... else v0" as one operation, "pick".

    Its arguments are n, v0, v1, ...; a number that is none of 1, 2, ... picks v0, as the chain does. A program without
    invariant operations, which is evaluated as a whole, stays without.
    """
    operations = list(program.operations)
    for index in range(len(operations)):
        picked = _pick(program.operations, index)
        if picked is not None and index not in program.invariant:
            operations[index] = picked
    kept, outputs = drop_unused(operations, program.outputs)
    fixed = invariant_of(kept) if program.invariant else program.invariant
    return replace(program, operations=tuple(kept), outputs=outputs, invariant=fixed)


def _pick(operations: tuple[Operation, ...], index: int) -> Operation | None:
    """The chain of selections that ends at an operation as one "pick"; None where there is none that is long enough."""
    values: list[int] = []
    number, wanted = -1, 0.0
    while wanted != 1.0 and operations[index].name == "select":
        condition, value, rest = operations[index].arguments
        compared = _compared(operations, condition)
        if compared is None or (values and compared != (number, wanted - 1.0)):
            break
        number, wanted = compared
        values.append(value)
        index = rest
    if wanted != 1.0 or len(values) < SHORTEST_CHAIN:
        return None
    return Operation("pick", (number, index, *reversed(values)))


def _compared(operations: tuple[Operation, ...], condition: int) -> tuple[int, float] | None:
    """(value that is compared with a constant, constant); None for any other condition."""
    asked = operations[condition]
    if asked.name != "eq":
        return None
    first, second = asked.arguments
    if operations[first].name == "constant":
        first, second = second, first
    return (first, float(operations[second].constant)) if operations[second].name == "constant" else None
