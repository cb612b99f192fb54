"""Reordering of sums: the growth of a state is added to its change first, so that single precision keeps both.

The variance of a Kalman filter becomes `(variance - gain) + growth`. In single precision either term may be below half
a unit in the last place of the variance and is then rounded away, always in the same direction. On a drive with rising
friction the error was 0.004 N m; with `variance + (growth - gain)`, rounded once, it is 0.0002 N m.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from tierod.core.graph.operations import STATE, Operation, Program, drop_unused, invariant_of

_STATE_IN = {"fma": 2, "fnma": 2, "sub": 0}
"""Operations that change a state, and the position of the state among their arguments."""


def growth_first(program: Program) -> Program:
    """Program in which the parameter-dependent growth of a state is added to its change before both reach the state."""
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
    """Change of a state that is used only in this sum, and the growth added to it; None for any other operation."""
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
    """Whether a value depends on parameters only, possibly enabled by a condition."""
    operation = program.operations[index]
    return index in program.invariant or (operation.name == "if" and operation.arguments[1] in program.invariant)
