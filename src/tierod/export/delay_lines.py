"""Delay lines of a step: those that remember the same numbers are one, read at several places.

A block that compares many delays of a signal holds a line for each of them. All are given the same number in every
step, so that the longest holds what the others do. Lines of one family, such as one for each sensor, are the rows of
an array with one place to write at.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from tierod.core.graph.operations import PUSH, Program
from tierod.export.members import identifier


@dataclass(frozen=True)
class Line:
    """An array of delay lines of one length.

    Args:
        name: of C
        rows: of the array
        size: numbers of a row
    """

    name: str
    rows: int
    size: int

    @property
    def declarator(self) -> str:
        """Name and dimensions."""
        return f"{self.name}[{self.size}]" if self.rows == 1 else f"{self.name}[{self.rows}][{self.size}]"

    def row(self, number: int) -> str:
        """C of a row."""
        return self.name if self.rows == 1 else f"{self.name}[{number}]"

    def place(self, row: int, delay: int) -> str:
        """C of the number of some steps ago; of as many steps ago as the row is long it is written next.

        Args:
            row: of the array
            delay: steps, at most `size`
        """
        own = self.row(row)
        if delay == self.size:
            return f"x->{own}[x->{self.name}_head]"
        return f"x->{own}[(x->{self.name}_head + {self.size - delay}U) % {self.size}U]"


@dataclass(frozen=True)
class Lines:
    """All delay lines of a step.

    Args:
        arrays: as C holds them
        home: position of a delay line of the graph -> number of its array, and its row
        delays: length of every delay line of the graph
        kept: the longest delay line of each row, which stands for all of it
    """

    arrays: tuple[Line, ...]
    home: Mapping[int, tuple[int, int]]
    delays: tuple[int, ...]
    kept: frozenset[int]

    def read(self, position: int) -> str:
        """C of the oldest number of a delay line of the graph."""
        array, row = self.home[position]
        return self.arrays[array].place(row, self.delays[position])

    def row(self, position: int) -> tuple[Line, str]:
        """The array of a delay line of the graph, and C of its row."""
        array, row = self.home[position]
        return self.arrays[array], self.arrays[array].row(row)

    def written(self, position: int) -> str:
        """C of the place that takes the next number of a delay line of the graph."""
        array, row = self.home[position]
        return self.arrays[array].place(row, self.arrays[array].size)


def delay_lines(program: Program, initial: Program, rings: Sequence[tuple[str, int]]) -> Lines:
    """The delay lines of a step.

    Args:
        program: of the step
        initial: of the first state
        rings: dotted name and length of every delay line of the graph
    """
    rows: dict[tuple[str, int, int], list[int]] = {}
    for position, (path, _) in enumerate(rings):
        pushed, first = program.outputs[PUSH, position], initial.outputs[PUSH, position]
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
    """The step with one push for each row.

    Args:
        program: of the step
        lines: its delay lines
    """
    outputs = {
        target: value for target, value in program.outputs.items() if target[0] != PUSH or target[1] in lines.kept
    }
    return replace(program, outputs=outputs)


def _family(path: str) -> str:
    return re.sub(r"(?<![^.])\d+(?![^.])", "*", path)
