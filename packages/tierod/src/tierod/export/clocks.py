"""States that count time, stored in single precision as whole numbers of steps so that no clock drifts or stops.

A clock that adds 0.01 s in single precision loses 0.75 s in an hour and stops at 262 144 s. A state is a
clock if it begins at zero and each next value is zero, the value itself, or the value plus one fixed step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from tierod.core.graph.operations import NEXT_STATE, STATE, Program, is_constant


class Clock(NamedTuple):
    """A state that counts steps.

    Args:
        step: number of the value added per step, which depends on the tuning only
    """

    step: int
    next: int


class Added(NamedTuple):
    """Increment of a state by a value.

    Args:
        condition: number of the value that enables the increment; None for an unconditional one
    """

    step: int
    condition: int | None


def clocks(program: Program, initial: Program) -> dict[int, Clock]:
    """The clocks of a program, by the position of their state."""
    found = {}
    for (group, position), value in sorted(program.outputs.items()):
        if group == NEXT_STATE and is_constant(initial.operations[initial.outputs[group, position]], 0.0):
            steps: set[int] = set()
            if _counts(program, position, value, steps) and len(steps) == 1:
                found[position] = Clock(steps.pop(), value)
    return found


def free_clocks(program: Program, known: Mapping[int, Clock]) -> tuple[int, ...]:
    """Positions of free-running clocks, whose next value depends on no condition.

    Args:
        known: clocks of the program, by the position of their state
    """
    return tuple(
        k
        for k, clock in known.items()
        if (more := added(program, clock.next, k)) is not None and more.condition is None
    )


def is_own(program: Program, index: int, position: int) -> bool:
    """Whether a value is the unchanged previous value of a state."""
    operation = program.operations[index]
    return operation.name == "input" and operation.constant == (STATE, position)


def added(program: Program, index: int, position: int) -> Added | None:
    """Increment that a value adds to a state; None where the value is anything else."""
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
    """Whether a value is a possible next value of a clock; collects the steps that are added."""
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
