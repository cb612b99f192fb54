"""Structs of an export: C code that accesses every number of sample, state, parameters, constants and output."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from tierod.core.graph.operations import NEXT_STATE, OUTPUT, RING, SAMPLE, TUNING, Program, program
from tierod.core.graph.state import initial_program
from tierod.core.graph.trace import Graph
from tierod.export.clocks import Clock, clocks
from tierod.export.delay_lines import Lines, delay_lines, pushed_once
from tierod.export.described import Described
from tierod.export.growth import growth_first
from tierod.export.members import Member, elements, identifier, members
from tierod.export.simplified import simplified
from tierod.export.spelling import Precision, Spelling
from tierod.export.subject import Subject

STATUS = "status"

PARAMETER = 4
"""Group of the parameters in programs that run once, where parameters are inputs like others."""


@dataclass(frozen=True)
class Options:
    """Options of an export.

    Args:
        validity: whether a mask marks the valid inputs, in place of NaN
        libm: whether functions such as the sine come from the C library, rather than the kernels' own
        fused: whether multiply-add is always rounded once, even if the target has no instruction for it
    """

    precision: Precision = "single"
    validity: bool = False
    libm: bool = True
    fused: bool = False


@dataclass(frozen=True)
class Interface:
    """Interface of a subject's C code, as the caller sees it."""

    subject: Subject
    options: Options = field(default_factory=Options)

    @cached_property
    def spelling(self) -> Spelling:
        """Spelling of names and numbers in C."""
        return Spelling(f"tierod_{self.subject.name}", self.options.precision, self.options.fused)

    @property
    def prefix(self) -> str:
        """Prefix of all exported names."""
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

    # -- members -------------------------------------------------------------------------------------------------

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
        """Positions of the states that are not clocks, and their members."""
        positions = tuple(k for k in range(len(self.graph.state)) if k not in self.clocks)
        return positions, members([self.graph.state[k] for k in positions])

    @cached_property
    def counted(self) -> dict[int, str]:
        """C names of the clocks, by position."""
        return {k: f"{identifier(self.graph.state[k])}_steps" for k in self.clocks}

    @cached_property
    def lines(self) -> Lines:
        return delay_lines(self.stepped, self.initial, self.graph.rings)

    @property
    def statuses(self) -> tuple[int, ...]:
        """Positions of the outputs that are status codes."""
        return tuple(k for k, each in enumerate(self.subject.output) if is_status(each))

    # -- C of every number ---------------------------------------------------------------------------------------

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
    """Whether a number is a status code."""
    return each.path.rpartition(".")[2] == STATUS and each.holder == "Statement"
