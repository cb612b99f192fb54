"""Structs of an export: C names, spelling of numbers, and C code that accesses every number."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from tierod.core.graph.operations import NEXT_STATE, OUTPUT, RING, SAMPLE, TUNING, Program, program
from tierod.core.graph.state import initial_program
from tierod.core.graph.trace import Graph
from tierod.export.simplification import growth_first, simplified
from tierod.export.storage import Clock, Lines, clocks, delay_lines, pushed_once
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
