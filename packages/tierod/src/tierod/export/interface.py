"""Structs of an export: C names, spelling of numbers, and C code that accesses every number."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from tierod.core.graph.operations import (
    NEXT_STATE,
    OUTPUT,
    PUSH,
    RING,
    SAMPLE,
    STATE,
    TUNING,
    Program,
    is_constant,
    program,
)
from tierod.core.graph.trace import Graph, initial_program
from tierod.export.simplification import growth_first, simplified
from tierod.export.subject import Described, Member, Subject, elements, identifier, members

Precision = Literal["single", "double"]

_LITERAL = re.compile(r"\bR\(([0-9.e+-]+)\)")
_FUNCTION = re.compile(r"\bM\((\w+)\)")
_OWN = re.compile(r"\btierod_(\w+)\(")


@dataclass(frozen=True)
class Spelling:
    prefix: str  # of all names ("tierod_friction")
    precision: Precision
    fused: bool = False  # whether multiply-add is always rounded once, even if the target has no instruction for it

    @property
    def real(self) -> str:
        """C type of all numbers."""
        return f"{self.prefix}_real_t"

    @property
    def suffix(self) -> str:
        """Suffix of literals and of C library functions."""
        return "f" if self.precision == "single" else ""

    def number(self, value: float) -> str:
        """C literal of the nearest number in this precision; infinity beyond its range."""
        if math.isnan(value):
            return f"(({self.real})NAN)"
        with np.errstate(over="ignore"):
            rounded = float(np.float32(value)) if self.precision == "single" else value
        if math.isinf(rounded):
            return f"(({self.real})INFINITY)" if value > 0.0 else f"(-({self.real})INFINITY)"
        text = repr(abs(value if rounded else 0.0)) + self.suffix
        return text if math.copysign(1.0, value) > 0.0 else f"(-{text})"

    def spelt(self, text: str) -> str:
        """A line of the kernels' printer with its macros replaced."""
        text = _OWN.sub(lambda found: f"{self.prefix}_{found[1]}(", self.literals(text))
        return text.replace("(real)", f"({self.real})").replace("const real ", f"const {self.real} ")

    def literals(self, text: str) -> str:
        """A text with literals and C library functions spelt in this precision."""
        text = _LITERAL.sub(lambda found: found[1] + self.suffix, text)
        return _FUNCTION.sub(lambda found: found[1] + self.suffix, text)


STATUS = "status"

PARAMETER = 4  # Group of the parameters in programs that run once, where parameters are inputs like others


@dataclass(frozen=True)
class Options:
    precision: Precision = "single"
    validity: bool = False  # whether a mask marks the valid inputs, in place of NaN
    libm: bool = True  # whether functions such as the sine come from the C library, rather than the kernels' own
    fused: bool = False  # whether multiply-add is always rounded once, even if the target has no instruction for it


@dataclass(frozen=True)
class Interface:
    subject: Subject
    options: Options = field(default_factory=Options)

    @cached_property
    def spelling(self) -> Spelling:
        return Spelling(f"tierod_{self.subject.name}", self.options.precision, self.options.fused)

    @property
    def prefix(self) -> str:
        return self.spelling.prefix

    @property
    def graph(self) -> Graph:
        graph: Graph = self.subject.graph
        return graph

    @cached_property
    def stepped(self) -> Program:
        """Simplified program of one step; in single precision with reordered sums (see `growth`)."""
        found = simplified(program(self.graph.function), self.initial, self.tuning)
        return growth_first(found) if self.options.precision == "single" else found

    @property
    def tuning(self) -> tuple[float, ...]:
        """Values of the parameters of one step."""
        return self.subject.values

    @cached_property
    def program(self) -> Program:
        """Program of one step, with a single push per row of the delay lines."""
        return pushed_once(self.stepped, self.lines)

    @cached_property
    def initial(self) -> Program:
        return initial_program(self.subject.block)

    @cached_property
    def clocks(self) -> dict[int, Clock]:
        """States stored as whole numbers of steps; none in double precision, which drifts at most 1 ms in 100 hours."""
        return clocks(self.program, self.initial) if self.options.precision == "single" else {}

    @cached_property
    def sample(self) -> tuple[Member, ...]:
        return members(self.graph.sample)

    @cached_property
    def output(self) -> tuple[Member, ...]:
        return members(self.graph.output)

    @cached_property
    def parameters(self) -> tuple[Member, ...]:
        return members(self.graph.tuning)

    @cached_property
    def plain(self) -> tuple[tuple[int, ...], tuple[Member, ...]]:
        positions = tuple(k for k in range(len(self.graph.state)) if k not in self.clocks)
        return positions, members([self.graph.state[k] for k in positions])

    @cached_property
    def counted(self) -> dict[int, str]:
        return {k: f"{identifier(self.graph.state[k])}_steps" for k in self.clocks}

    @cached_property
    def lines(self) -> Lines:
        return delay_lines(self.stepped, self.initial, self.graph.rings)

    @property
    def statuses(self) -> tuple[int, ...]:
        """Positions of the outputs that are status codes."""
        return tuple(k for k, each in enumerate(self.subject.output) if is_status(each))

    @cached_property
    def _state(self) -> dict[int, str]:
        positions, found = self.plain
        named = dict(zip(positions, elements(found), strict=True))
        return {k: f"x->{text}" for k, text in {**named, **self.counted}.items()}

    @cached_property
    def named(self) -> dict[tuple[str, int], str]:
        """C code of every number of sample, output and parameters, by the letter of its struct and its position."""
        groups = {"u": self.sample, "y": self.output, "p": self.parameters}
        return {(word, k): f"{word}->{text}" for word, all_ in groups.items() for k, text in enumerate(elements(all_))}

    def given(self, target: tuple[int, int]) -> str:
        """C code of an output of the program."""
        group, position = target
        if group == OUTPUT:
            return self.named["y", position]
        return self._state[position] if group == NEXT_STATE else self.lines.written(position)

    def taken(self, source: tuple[int, int]) -> str:
        """C code of an input of the program, as a number."""
        group, position = source
        if group in (TUNING, PARAMETER):
            return self.named["p", position]
        if group == RING:
            return self.lines.read(position)
        if group == SAMPLE:
            return self._sampled(position)
        if position in self.clocks:
            return f"(real){self._state[position]} * {self._step(self.clocks[position])}"
        return self._state[position]

    def _sampled(self, position: int) -> str:
        text = self.named["u", position]
        if not self.options.validity:
            return text
        return f"(((u->valid & {self.prefix.upper()}_VALID_{self.bit(position)}) != 0U) ? {text} : (real)NAN)"

    def bit(self, position: int) -> str:
        """Name of the bit that marks an input as valid."""
        return identifier(self.graph.sample[position]).upper()

    def _step(self, clock: Clock) -> str:
        operation = self.program.operations[clock.step]
        if operation.name == "constant":
            return self.spelling.number(float(operation.constant))
        return self.carried(self.program.carried().index(clock.step))

    def carried(self, slot: int) -> str:
        """C code of a value that depends on parameters only."""
        return f"c->value[{slot}]"


def is_status(each: Described) -> bool:
    return each.path.rpartition(".")[2] == STATUS and each.holder == "Statement"


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
