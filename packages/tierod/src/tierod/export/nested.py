"""Selections with a common condition as one branch, together with the operations that only one side needs.

The kernels compute both alternatives of a selection. A control unit counts instructions, so its code computes only the
chosen alternative and otherwise keeps the stored state.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from itertools import count

from tierod.core.graph.operations import Condition, Program

FEWEST = 2  # Fewest operations and reads that a branch must save

SELECTIONS = ("select", "if")


@dataclass(frozen=True)
class Nested:
    """Selections with a common condition."""

    condition: int
    # number of every selection -> its values for a true and for a false condition; None for zero
    chosen: Mapping[int, tuple[int | None, int | None]]
    # operations needed only for a true and only for a false condition, in order
    sides: tuple[tuple[int, ...], tuple[int, ...]]


def nested(program: Program, operations: Sequence[int], uses: Mapping[int, Set[int]]) -> Iterator[int | Nested]:
    """Operations of a segment in order, with those that only one side of a selection needs inside branches.

    Args:
        uses: operations that use each value; -1 means a store or a use by another segment
    """
    place = dict(zip(operations, count()))
    groups: dict[int, list[int]] = {}
    for index in operations:
        if program.operations[index].name in SELECTIONS:
            condition = _asked(program, index, place).value
            if not is_presence(program, condition):
                groups.setdefault(condition, []).append(index)
    found: dict[int, Nested] = {}
    taken: set[int] = set()
    for condition, selections in groups.items():
        own = [each for each in selections if each not in taken]
        made = _branch(program, condition, own, place, uses, taken) if own else None
        if made is not None:
            found[own[0]] = made
            taken.update(made.chosen, *made.sides)
    chosen = {each for branch in found.values() for each in branch.chosen}
    values = {each for branch in found.values() for pair in branch.chosen.values() for each in pair}
    # A negation used only as a condition needs no variable; one that is also selected is a value like any other.
    asked: set[int] = set()
    for index in reversed(operations):
        if program.operations[index].name == "not" and uses[index] <= chosen | asked and index not in values:
            asked.add(index)
    for index in operations:
        if index in found:
            yield found[index]
        elif index not in taken and index not in asked:
            yield index


def is_presence(program: Program, index: int) -> bool:
    """Whether a value tests the finiteness of a value that is not an input of the sample.

    Such a value is always finite while the monitor holds its inputs, so no run would cover the branch.
    """
    operations = program.operations
    while operations[index].name == "not":
        index = operations[index].arguments[0]
    if operations[index].name != "lt":
        return False
    value, limit = (operations[each] for each in operations[index].arguments)
    endless = limit.name == "constant" and limit.constant == float("inf")
    return endless and value.name == "fabs" and operations[value.arguments[0]].name != "input"


def _branch(
    program: Program,
    condition: int,
    selections: list[int],
    place: Mapping[int, int],
    uses: Mapping[int, Set[int]],
    taken: Set[int],
) -> Nested | None:
    """Branch at the position of the first selection; None where it would save too little."""
    kept = list(selections)
    while True:
        chosen = {each: _values(program, each, place) for each in kept}
        sides = _sides(program, chosen, place, uses, taken)
        late = {each for each in kept[1:] if not _ready(program, each, chosen, sides, place, kept[0])}
        if not late:
            break
        kept = [each for each in kept if each not in late]
    ordered = tuple(tuple(sorted(side, key=place.__getitem__)) for side in sides)
    reads = sum(
        program.operations[value].name == "input" and value not in program.invariant and len(uses[value]) == 1
        for pair in chosen.values()
        for value in pair
        if value is not None
    )
    if len(ordered[0]) + len(ordered[1]) + reads < FEWEST:
        return None
    return Nested(condition, chosen, (ordered[0], ordered[1]))


def _asked(program: Program, selection: int, place: Mapping[int, int]) -> Condition:
    value, holds = program.operations[selection].arguments[0], True
    while value in place and program.operations[value].name == "not":
        value, holds = program.operations[value].arguments[0], not holds
    return Condition(value, holds)


def _values(program: Program, selection: int, place: Mapping[int, int]) -> tuple[int | None, int | None]:
    _, first, *rest = program.operations[selection].arguments
    pair = (first, rest[0] if rest else None)
    return pair if _asked(program, selection, place).holds else pair[::-1]


def _sides(
    program: Program,
    chosen: Mapping[int, tuple[int | None, int | None]],
    place: Mapping[int, int],
    uses: Mapping[int, Set[int]],
    taken: Set[int],
) -> tuple[set[int], set[int]]:
    sides: tuple[set[int], set[int]] = (set(), set())
    last = max(place[each] for each in chosen)
    for index in sorted(place, key=place.__getitem__, reverse=True):
        if place[index] >= last or index in taken or index in chosen:
            continue
        for side, other in ((0, 1), (1, 0)):
            if uses[index] and all(
                user in sides[side]
                or (
                    user in chosen
                    and chosen[user][side] == index
                    and chosen[user][other] != index
                    and program.operations[user].arguments[0] != index
                )
                for user in uses[index]
            ):
                sides[side].add(index)
    return sides


def _ready(
    program: Program,
    selection: int,
    chosen: Mapping[int, tuple[int | None, int | None]],
    sides: tuple[set[int], set[int]],
    place: Mapping[int, int],
    first: int,
) -> bool:
    for side, value in zip(sides, chosen[selection], strict=True):
        waiting = [value] if value is not None else []
        while waiting:
            index = waiting.pop()
            if index in side:
                waiting += program.operations[index].arguments
            elif place.get(index, -1) >= place[first]:
                return False
    return True
