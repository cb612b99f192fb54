"""Branches for a step that runs alone and need not vectorise; chains of selections as one operation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from tierod.core.graph.operations import Operation, Program, drop_unused, invariant_of

FEWEST = 16
"""Operations of a branch from which it pays: fewer cost less than a jump that was foretold wrongly."""


class Condition(NamedTuple):
    """A value that is not zero (or zero, where it does not `hold`)."""

    value: int
    holds: bool


@dataclass(frozen=True)
class Branch:
    """Operations that are worked out together.

    Args:
        condition: under which; None for those that are always needed
        operations: their numbers, in order
    """

    condition: Condition | None
    operations: tuple[int, ...]


def branches(program: Program) -> list[Branch]:
    """All operations of a step but the invariant ones, so ordered that each comes after what it needs.

    An operation whose result nothing takes but selections that leave it out elsewhere is worked out in a branch.
    """
    chosen = _chosen(program, _conditions(program))
    rounds = _rounds(program, chosen)
    parts: dict[tuple[int, Condition | None], list[int]] = {}
    for index, number in rounds.items():
        parts.setdefault((number, chosen.get(index)), []).append(index)
    ordered = sorted(parts.items(), key=lambda part: (part[0][0], part[0][1] is not None, part[1][0]))
    return [Branch(condition, tuple(operations)) for (_, condition), operations in ordered]


def _conditions(program: Program) -> dict[int, frozenset[Condition]]:
    """Conditions that all hold wherever an operation's result is taken."""
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
    """A condition without its negations."""
    while program.operations[value].name == "not":
        value, holds = program.operations[value].arguments[0], not holds
    return Condition(value, holds)


def _chosen(program: Program, conditions: dict[int, frozenset[Condition]]) -> dict[int, Condition]:
    """The conditions that save most operations, one for each operation; none where they save too little."""
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
    """A number for every operation: branches of one number need nothing of each other."""
    rounds: dict[int, int] = {}
    for index, operation in enumerate(program.operations):
        if index in program.invariant:
            continue
        own = chosen.get(index)
        needed: Sequence[int] = operation.arguments if own is None else (*operation.arguments, own.value)
        rounds[index] = max((rounds[each] + (chosen.get(each) != own) for each in needed if each in rounds), default=0)
    return rounds


SHORTEST_CHAIN = 8
"""Values from which a table pays beside selections."""


def with_picks(program: Program) -> Program:
    """The same program with every chain "v1 if n == 1, v2 if n == 2, ... else v0" as one operation, "pick".

    Its arguments are n, v0, v1, ...; a number that is none of 1, 2, ... picks v0, as the chain does. A program without
    invariant operations, which is worked out as a whole, keeps none.
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
    """The whole chain that ends at an operation, the last value first."""
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
    """The value that is compared with a constant, and the constant."""
    asked = operations[condition]
    if asked.name != "eq":
        return None
    first, second = asked.arguments
    if operations[first].name == "constant":
        first, second = second, first
    return (first, float(operations[second].constant)) if operations[second].name == "constant" else None
