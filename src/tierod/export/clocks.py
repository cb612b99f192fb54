"""States that count time: in single precision they are whole numbers of steps, so that no clock drifts or stops.

A clock that adds 0.01 s in single precision loses 0.75 s in an hour and stands still from 262 144 s on. A state is a
clock where it begins at zero, and every next value is its own plus one and the same step, itself, or zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from tierod.core.graph.operations import NEXT_STATE, STATE, Program, is_constant


class Clock(NamedTuple):
    """A state that counts steps.

    Args:
        step: number of the value that it adds, worked out from the tuning alone
        next: number of the value that it takes
    """

    step: int
    next: int


class Added(NamedTuple):
    """Increment of a state by a value.

    Args:
        step: number of the value that is added
        condition: number of the value under which it is; None for always
    """

    step: int
    condition: int | None


def clocks(program: Program, initial: Program) -> dict[int, Clock]:
    """The clocks of a program, by the position of their state.

    Args:
        program: of the step
        initial: of the first state; a clock begins at zero
    """
    found = {}
    for (group, position), value in sorted(program.outputs.items()):
        if group == NEXT_STATE and is_constant(initial.operations[initial.outputs[group, position]], 0.0):
            steps: set[int] = set()
            if _counts(program, position, value, steps) and len(steps) == 1:
                found[position] = Clock(steps.pop(), value)
    return found


def free_clocks(program: Program, known: Mapping[int, Clock]) -> tuple[int, ...]:
    """Positions of the clocks that run on whatever is measured: their next value rests on no condition.

    Args:
        program: of the step
        known: its clocks
    """
    return tuple(
        k
        for k, clock in known.items()
        if (more := added(program, clock.next, k)) is not None and more.condition is None
    )


def is_own(program: Program, index: int, position: int) -> bool:
    """Whether a value is a state as it was."""
    operation = program.operations[index]
    return operation.name == "input" and operation.constant == (STATE, position)


def added(program: Program, index: int, position: int) -> Added | None:
    """Increment of a state by a value; None where the value does something else."""
    operation = program.operations[index]
    if operation.name != "add":
        return None
    first, second = operation.arguments
    if is_own(program, second, position):
        first, second = second, first
    if not is_own(program, first, position):
        return None
    if second in program.invariant:
        return Added(second, None)
    more = program.operations[second]
    at_times = more.name == "if" and more.arguments[1] in program.invariant
    return Added(more.arguments[1], more.arguments[0]) if at_times else None


def _counts(program: Program, position: int, index: int, steps: set[int]) -> bool:
    """Whether a value is a clock's next one; the steps that it adds are collected."""
    operation = program.operations[index]
    if operation.name == "select":
        return all(_counts(program, position, each, steps) for each in operation.arguments[1:])
    if operation.name == "if":
        return _counts(program, position, operation.arguments[1], steps)
    more = added(program, index, position)
    if more is not None:
        steps.add(more.step)
        return True
    return is_own(program, index, position) or is_constant(operation, 0.0)
