"""Sums in which a state's gain by tuning alone meets its small change first, so that single precision keeps both.

The variance of a Kalman filter becomes `(variance - gain) + growth`. In single precision either of both may be less
than half of the last bit of the variance, so that each is rounded away, always to the same side: friction was 0.004 N m
off on a drive in which it rises, and is 0.0002 N m off with `variance + (growth - gain)`, which is rounded once.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from tierod.core.graph.operations import STATE, Operation, Program, drop_unused, invariant_of

_STATE_IN = {"fma": 2, "fnma": 2, "sub": 0}
"""Operations that change a state, and which of their arguments it is."""


def growth_first(program: Program) -> Program:
    """The program with what states gain by tuning alone added to their change, before it is added to the state.

    Args:
        program: of a step
    """
    uses = Counter(argument for each in program.operations for argument in each.arguments)
    uses.update(program.outputs.values())
    operations: list[Operation] = []
    new: dict[int, int] = {}
    for index, each in enumerate(program.operations):
        found = _changed(program, each, uses)
        if found is not None:
            change, growth = found
            given = [new[value] for value in change.arguments]
            state, given[_STATE_IN[change.name]] = given[_STATE_IN[change.name]], new[growth]
            operations.append(Operation(change.name, tuple(given)))
            operations.append(Operation("add", (state, len(operations) - 1)))
        else:
            operations.append(each._replace(arguments=tuple(new[value] for value in each.arguments)))
        new[index] = len(operations) - 1
    kept, outputs = drop_unused(operations, {target: new[value] for target, value in program.outputs.items()})
    return replace(program, operations=tuple(kept), outputs=outputs, invariant=invariant_of(kept))


def _changed(program: Program, each: Operation, uses: Counter[int]) -> tuple[Operation, int] | None:
    """The change of a state, used nowhere else, that a growth is added to, and that growth."""
    for first, growth in (each.arguments, each.arguments[::-1]) if each.name == "add" else ():
        change = program.operations[first]
        if (
            change.name in _STATE_IN
            and uses[first] == 1
            and _is_state(program, change.arguments[_STATE_IN[change.name]])
            and _is_growth(program, growth)
        ):
            return change, growth
    return None


def _is_state(program: Program, index: int) -> bool:
    operation = program.operations[index]
    return operation.name == "input" and operation.constant[0] == STATE


def _is_growth(program: Program, index: int) -> bool:
    """Whether a value follows from tuning alone, always or under a condition."""
    operation = program.operations[index]
    return index in program.invariant or (operation.name == "if" and operation.arguments[1] in program.invariant)
