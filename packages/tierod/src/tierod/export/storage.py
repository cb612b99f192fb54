"""Storage of the state of an export: clocks as whole numbers of steps, and delay lines merged where they agree.

A clock that adds 0.01 s in single precision loses 0.75 s in an hour and stops at 262 144 s. A state is a
clock if it begins at zero and each next value is zero, the value itself, or the value plus one fixed step.

A block that compares many delays of a signal holds a delay line for each. All receive the same number in every
step, so the longest contains all others. Lines of one family, such as one per sensor, are the rows of an array with
a common write index."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from tierod.core.graph.operations import NEXT_STATE, PUSH, STATE, Program, is_constant
from tierod.export.subject import identifier


class Clock(NamedTuple):
    """A state that counts steps."""

    step: int  # number of the value added per step, which depends on the tuning only
    next: int


class Added(NamedTuple):
    """Increment of a state by a value."""

    step: int
    condition: int | None  # number of the value that enables the increment; None for an unconditional one


def clocks(program: Program, initial: Program) -> dict[int, Clock]:
    found = {}
    for (group, position), value in sorted(program.outputs.items()):
        if group == NEXT_STATE and is_constant(initial.operations[initial.outputs[group, position]], 0.0):
            steps: set[int] = set()
            if _counts(program, position, value, steps) and len(steps) == 1:
                found[position] = Clock(steps.pop(), value)
    return found


def free_clocks(program: Program, known: Mapping[int, Clock]) -> tuple[int, ...]:
    """Positions of free-running clocks, whose next value depends on no condition."""
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


@dataclass(frozen=True)
class Line:
    """An array of delay lines of one length."""

    name: str
    rows: int
    size: int

    @property
    def declarator(self) -> str:
        """C declarator: name and dimensions."""
        return f"{self.name}[{self.size}]" if self.rows == 1 else f"{self.name}[{self.rows}][{self.size}]"

    def row(self, number: int) -> str:
        """C code of a row."""
        return self.name if self.rows == 1 else f"{self.name}[{number}]"

    def place(self, row: int, delay: int) -> str:
        """C code of the number from some steps ago; the oldest one lies where the next number is written."""
        own = self.row(row)
        if delay == self.size:
            return f"x->{own}[x->{self.name}_head]"
        return f"x->{own}[(x->{self.name}_head + {self.size - delay}U) % {self.size}U]"


@dataclass(frozen=True)
class Lines:
    arrays: tuple[Line, ...]
    home: Mapping[int, tuple[int, int]]  # position of a delay line of the graph -> number of its array, and its row
    delays: tuple[int, ...]
    kept: frozenset[int]  # positions of the longest delay line of each row, which contains the others

    def read(self, position: int) -> str:
        """C code of the oldest number of a delay line of the graph."""
        array, row = self.home[position]
        return self.arrays[array].place(row, self.delays[position])

    def row(self, position: int) -> tuple[Line, str]:
        """Array of a delay line of the graph, and C code of its row."""
        array, row = self.home[position]
        return self.arrays[array], self.arrays[array].row(row)

    def written(self, position: int) -> str:
        """C code of the element that takes the next number of a delay line of the graph."""
        array, row = self.home[position]
        return self.arrays[array].place(row, self.arrays[array].size)


def delay_lines(program: Program, initial: Program, rings: Sequence[tuple[str, int]]) -> Lines:
    """Merged delay lines of a step."""
    rows: dict[tuple[str, int, int], list[int]] = {}
    for position, (path, _) in enumerate(rings):
        pushed, first = program.outputs[PUSH, position], initial.outputs[PUSH, position]
        # Equal initial contents are required too, else the merged line would differ until it is full.
        rows.setdefault((_family(path), pushed, first), []).append(position)
    families: dict[str, list[list[int]]] = {}
    for (family, _, _), own in rows.items():
        families.setdefault(family if len(own) > 1 else rings[own[0]][0], []).append(own)
    arrays, home = [], {}
    for number, (family, several) in enumerate(families.items()):
        size = max(rings[k][1] for own in several for k in own)
        arrays.append(Line(identifier(family.replace("*", "")), len(several), size))
        home.update({k: (number, row) for row, own in enumerate(several) for k in own})
    kept = frozenset(max(own, key=lambda k: rings[k][1]) for own in rows.values())
    return Lines(tuple(arrays), home, tuple(size for _, size in rings), kept)


def pushed_once(program: Program, lines: Lines) -> Program:
    """Program of the step with a single push per row."""
    outputs = {
        target: value for target, value in program.outputs.items() if target[0] != PUSH or target[1] in lines.kept
    }
    return replace(program, outputs=outputs)


def _family(path: str) -> str:
    return re.sub(r"(?<![^.])\d+(?![^.])", "*", path)
