"""Print values, operations and selections of an export as C, with the brackets that checkers of C require."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from tierod.core.graph.branching_printer import BranchingPrinter
from tierod.core.graph.line_printer import COMPARE, Places
from tierod.core.graph.membership import MEMBER
from tierod.core.graph.operations import NEXT_STATE, Operation, Program
from tierod.core.graph.trace import Graph
from tierod.export.nested import Nested
from tierod.export.spelling import Spelling

Group = tuple[int, int]
"""(group, position) of an input or output."""

Gathered = Callable[[Sequence[int], str], str | None]
"""C of one of several inputs, given their positions and C of the number that picks; None where there is none."""


@dataclass(frozen=True)
class Reach:
    """C of what a program takes and gives.

    Args:
        taken: of an input, by group and position
        given: of an output
        carried: of a value that depends on tuning alone, by its place
        notes: what an output is, for a comment
        types: C type of an output that is not a plain number
    """

    taken: Callable[[Group], str]
    given: Callable[[Group], str]
    carried: Callable[[int], str]
    notes: Mapping[Group, str]
    types: Mapping[Group, str]


@dataclass(frozen=True)
class Body:
    """What is printed, and how it is written.

    Args:
        graph: of the block
        operations: its program
        spelling: of names and numbers
        reach: C of inputs and outputs
        gathered, truths: see `BranchingPrinter`
    """

    graph: Graph
    operations: Program
    spelling: Spelling
    reach: Reach
    gathered: Gathered | None = None
    truths: frozenset[int] | None = None


class StatementPrinter(BranchingPrinter):
    """The statements of one program.

    Args:
        body: to be printed
    """

    def __init__(self, body: Body):
        super().__init__(body.graph, body.operations, body.gathered, body.truths)
        self.spelling, self.reach = body.spelling, body.reach

    def _places(self) -> Places:
        def refused(_: int) -> str:
            raise AssertionError("inputs are reached by their group")

        return Places(refused, refused, refused, refused, self.reach.carried)

    def notes(self) -> dict[int, str]:
        """Meanings of values, by their numbers."""
        found: dict[int, str] = {}
        for target, value in sorted(self.program.outputs.items()):
            if target in self.reach.notes and target[0] != NEXT_STATE:
                found[value] = "; ".join(filter(None, [found.get(value), self.reach.notes[target]]))
        return found

    def statement(self, index: int, named: dict[int, str], places: Places, notes: dict[int, str], indent: str) -> str:
        """The lines that work out one value."""
        operation = self.program.operations[index]
        if operation.name == "input":
            return f"{indent}const real v{index} = {self.reach.taken(operation.constant)};\n"
        if operation.name == "assign" and index in self._whole:
            return f"{indent}const bool v{index} = {self._truth(operation.arguments[0], named)};\n"
        return super().statement(index, named, places, notes, indent).replace("const int v", "const bool v", 1)

    def _picked(self, index: int, named: dict[int, str], indent: str) -> str:
        """A value by its number, with brackets where checkers of C require them."""
        number, *values = self.program.operations[index].arguments
        given, last = self._real(number, named), len(values) - 1
        lines = (
            f"{indent}const bool k{index} = ({given} >= R(1.0)) && ({given} <= R({last}.0));\n"
            f"{indent}const int32_t j{index} = k{index} ? (int32_t){given} : 0;\n"
            f"{indent}const int32_t i{index} = ({given} == (real)j{index}) ? j{index} : 0;\n"
        )
        if index in self._gathers:
            return f"{lines}{indent}const real v{index} = {self._gathers[index]};\n"
        table = ", ".join(self._real(each, named) for each in values)
        return (
            f"{lines}{indent}const real t{index}[] = {{{table}}};\n{indent}const real v{index} = t{index}[i{index}];\n"
        )

    def constant(self, index: int) -> str | None:
        """A constant as C writes it; None for what is none."""
        operation = self.program.operations[index]
        return self.spelling.number(float(operation.constant)) if operation.name == "constant" else None

    def expression(self, operation: Operation, named: dict[int, str]) -> str:
        """An operation as C writes it, with brackets where checkers of C require them."""
        name, arguments = operation.name, operation.arguments
        if name in COMPARE:
            return f"({super().expression(operation, named)})"
        if name in ("and", "or"):
            return f" {'&&' if name == 'and' else '||'} ".join(self._truth(each, named) for each in arguments)
        if name == "not":
            return f"!{self._truth(arguments[0], named)}"
        if name == MEMBER:
            return self.membership(self._real(arguments[0], named), *map(hexadecimal, halves(operation.constant)))
        reals = {each: self._real(each, named) for each in arguments if each in self._whole and name != "select"}
        if name in ("select", "if"):
            condition, _, rest = super().expression(operation, named).partition(" ? ")
            return f"({condition}) ? {rest}" if " " in condition else f"{condition} ? {rest}"
        return super(BranchingPrinter, self).expression(operation, named | reals)

    def membership(self, number: str, low: str, high: str) -> str:
        """C of whether a number is a member of a set.

        Args:
            number: C of it
            low, high: C of the bits of the whole numbers from 0 on and from 32 on
        """
        return f"tierod_member({number}, {low}, {high})"

    def _real(self, index: int, named: dict[int, str]) -> str:
        """A value as a number."""
        text = self.constant(index) or named.get(index, f"v{index}")
        return f"({text} ? R(1.0) : R(0.0))" if index in self._whole else text

    def _truth(self, index: int, named: dict[int, str]) -> str:
        """A value as a truth."""
        operation = self.program.operations[index]
        if operation.name == "constant":
            return "true" if operation.constant != 0.0 else "false"
        text = named.get(index, f"v{index}")
        return text if index in self._whole else f"({text} != R(0.0))"

    # -- selections ----------------------------------------------------------------------------------------------

    def _nested(self, branch: Nested, named: dict[int, str], notes: dict[int, str], indent: str) -> str:
        """Selections as one branch; what costs nothing is chosen before it is asked."""
        lines = []
        light = next((side for side in (0, 1) if self._is_light(branch, side)), None)
        for index, pair in branch.chosen.items():
            kind = "bool" if index in self._whole else self.spelling.real
            begun = "" if light is None else f" = {self._value(index, pair[light], named)}"
            note = f" /* {notes[index]} */" if index in notes else ""
            lines.append(f"{indent}{kind} v{index}{begun};{note}\n")
        asked = self._truth(branch.condition, named)
        sides = [self._side(branch, side, named, notes, indent + "    ") for side in (0, 1)]
        if light is not None:
            lines.append(f"{indent}if ({asked if light else f'!{asked}'}) {{\n{sides[1 - light]}{indent}}}\n")
        else:
            lines.append(f"{indent}if ({asked}) {{\n{sides[0]}{indent}}} else {{\n{sides[1]}{indent}}}\n")
        return "".join(lines)

    def _is_light(self, branch: Nested, side: int) -> bool:
        """Whether one side of a branch works nothing out and reads no state."""
        values = [pair[side] for pair in branch.chosen.values()]
        reads = any(
            value is not None and self.program.operations[value].name == "input" and value not in self.program.invariant
            for value in values
        )
        return not branch.sides[side] and not reads

    def _side(self, branch: Nested, side: int, named: dict[int, str], notes: dict[int, str], indent: str) -> str:
        places = self._places()
        lines = [self.statement(index, named, places, notes, indent) for index in branch.sides[side]]
        lines += [
            f"{indent}v{index} = {self._value(index, pair[side], named)};\n" for index, pair in branch.chosen.items()
        ]
        return "".join(lines)

    def _value(self, selection: int, value: int | None, named: dict[int, str]) -> str:
        """What a selection takes on one side; zero where it has no second value."""
        logical = selection in self._whole
        if value is None:
            return "false" if logical else self.spelling.number(0.0)
        return self._truth(value, named) if logical else self._real(value, named)


def halves(members: Iterable[int]) -> tuple[int, int]:
    """The bits of a set of whole numbers from 0 on and from 32 on.

    Args:
        members: of the set, below 64
    """
    bits = sum(1 << each for each in members)
    return bits & 0xFFFFFFFF, bits >> 32


def hexadecimal(bits: int) -> str:
    """C of 32 bits.

    Args:
        bits: as a whole number
    """
    return f"0x{bits:X}U"
