"""Chains "n == 1 or n == 4 or ..." as one operation: whether a number is a member of a set of whole numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tierod.core.graph.operations import LOGICAL, Operation, Program, drop_unused, invariant_of

MEMBER = "member"
"""Name of the operation; its constant holds the whole numbers that its argument is compared with, in order."""

LARGEST = 63
"""Largest whole number that a set of 64 bits can hold."""


def with_members(program: Program) -> Program:
    """The same program with every disjunction of comparisons of one number with whole numbers as one operation.

    Args:
        program: program of a step
    """
    operations, fixed = list(program.operations), program.invariant
    found: dict[int, tuple[int, frozenset[int]]] = {}
    for index, operation in enumerate(operations):
        if index in fixed:
            continue
        known = _compared(operations, operation) if operation.name == "eq" else _joined(operations, operation, found)
        if known is not None:
            found[index] = known
            if len(known[1]) > 1:
                operations[index] = Operation(MEMBER, (known[0],), tuple(sorted(known[1])))
        elif operation.name == "or":
            first, second = operation.arguments
            # A disjunction of a truth value and zero is the truth value.
            if _is_zero(operations, first) and operations[second].name in LOGICAL:
                operations[index] = operations[second]
            elif _is_zero(operations, second) and operations[first].name in LOGICAL:
                operations[index] = operations[first]
    kept, outputs = drop_unused(operations, program.outputs)
    fixed = invariant_of(kept) if program.invariant else program.invariant
    return replace(program, operations=tuple(kept), outputs=outputs, invariant=fixed)


def _compared(operations: Sequence[Operation], operation: Operation) -> tuple[int, frozenset[int]] | None:
    """(value that is compared with a whole number, set of that number); None for any other comparison."""
    for number, other in (operation.arguments, operation.arguments[::-1]):
        constant = operations[other]
        if constant.name == "constant" and operations[number].name != "constant":
            value = float(constant.constant)
            return (number, frozenset([int(value)])) if value in range(LARGEST + 1) else None
    return None


def _joined(
    operations: Sequence[Operation], operation: Operation, found: dict[int, tuple[int, frozenset[int]]]
) -> tuple[int, frozenset[int]] | None:
    """Union of the sets that one value is compared with, for a disjunction; zero adds nothing."""
    if operation.name != "or":
        return None
    own = [found[each] for each in operation.arguments if each in found]
    others = [each for each in operation.arguments if each not in found]
    if not own or any(not _is_zero(operations, each) for each in others) or len({number for number, _ in own}) > 1:
        return None
    return own[0][0], frozenset().union(*(members for _, members in own))


def _is_zero(operations: Sequence[Operation], index: int) -> bool:
    return operations[index].name == "constant" and operations[index].constant == 0.0
