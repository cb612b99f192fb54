"""Printing of values, operations, selections and stores of an export as C, with the brackets that MISRA C requires."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tierod.core.graph.body_printer import COMPARE, BranchingPrinter, Places
from tierod.core.graph.operations import NEXT_STATE, OUTPUT, Operation, Program
from tierod.core.graph.trace import Graph
from tierod.export.interface import Spelling
from tierod.export.nested import Nested
from tierod.export.storage import Clock, added, is_own

Group = tuple[int, int]  # (group, position) of an input or output

# C code of one of several inputs, given their positions and C code of the index; None where none is possible
Gathered = Callable[[Sequence[int], str], str | None]


@dataclass(frozen=True)
class Reach:
    """C code of the inputs and outputs of a program."""

    taken: Callable[[Group], str]  # C code of an input, by group and position
    given: Callable[[Group], str]
    carried: Callable[[int], str]  # C code of a value that depends on parameters only, by its slot
    notes: Mapping[Group, str]
    types: Mapping[Group, str]  # C type of an output that is not a plain number


@dataclass(frozen=True)
class Body:
    """A program to be printed, with the spelling of its numbers, inputs and outputs."""

    graph: Graph
    operations: Program
    spelling: Spelling
    reach: Reach
    gathered: Gathered | None = None


class StatementPrinter(BranchingPrinter):
    def __init__(self, body: Body, clocks: Mapping[int, Clock]):
        super().__init__(body.graph, body.operations, body.gathered)
        self.spelling, self.reach, self.clocks = body.spelling, body.reach, clocks

    def _places(self) -> Places:
        def refused(_: int) -> str:
            raise AssertionError("inputs are reached by their group")

        return Places(refused, refused, refused, refused, self.reach.carried)

    def notes(self) -> dict[int, str]:
        found: dict[int, str] = {}
        for target, value in sorted(self.program.outputs.items()):
            if target in self.reach.notes and target[0] != NEXT_STATE:
                found[value] = "; ".join(filter(None, [found.get(value), self.reach.notes[target]]))
        return found

    def statement(self, index: int, named: dict[int, str], places: Places, notes: dict[int, str], indent: str) -> str:
        """Lines of C code that compute one value."""
        operation = self.program.operations[index]
        if operation.name == "input":
            return f"{indent}const real v{index} = {self.reach.taken(operation.constant)};\n"
        if operation.name == "assign" and index in self._whole:
            return f"{indent}const bool v{index} = {self._truth(operation.arguments[0], named)};\n"
        return super().statement(index, named, places, notes, indent).replace("const int v", "const bool v", 1)

    def _picked(self, index: int, named: dict[int, str], indent: str) -> str:
        number, *values = self.program.operations[index].arguments
        # The range is tested before the conversion, which C leaves undefined for NaN and large numbers.
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
        """C literal of a constant; None for any other value."""
        operation = self.program.operations[index]
        return self.spelling.number(float(operation.constant)) if operation.name == "constant" else None

    def expression(self, operation: Operation, named: dict[int, str]) -> str:
        """C expression of an operation, with the brackets that MISRA C requires."""
        name, arguments = operation.name, operation.arguments
        if name in COMPARE:
            return f"({super().expression(operation, named)})"
        if name in ("and", "or"):
            return f" {'&&' if name == 'and' else '||'} ".join(self._truth(each, named) for each in arguments)
        if name == "not":
            return f"!{self._truth(arguments[0], named)}"
        reals = {each: self._real(each, named) for each in arguments if each in self._whole and name != "select"}
        if name in ("select", "if"):
            condition, _, rest = super().expression(operation, named).partition(" ? ")
            return f"({condition}) ? {rest}" if " " in condition else f"{condition} ? {rest}"
        return super(BranchingPrinter, self).expression(operation, named | reals)

    def _real(self, index: int, named: dict[int, str]) -> str:
        text = self.constant(index) or named.get(index, f"v{index}")
        return f"({text} ? R(1.0) : R(0.0))" if index in self._whole else text

    def _truth(self, index: int, named: dict[int, str]) -> str:
        operation = self.program.operations[index]
        if operation.name == "constant":
            return "true" if operation.constant != 0.0 else "false"
        text = named.get(index, f"v{index}")
        return text if index in self._whole else f"({text} != R(0.0))"

    def _nested(self, branch: Nested, named: dict[int, str], notes: dict[int, str], indent: str) -> str:
        """C code of selections as one branch; a side without cost becomes the initial value."""
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
        """Alternative of a selection on one side; zero where it has no second one."""
        logical = selection in self._whole
        if value is None:
            return "false" if logical else self.spelling.number(0.0)
        return self._truth(value, named) if logical else self._real(value, named)

    # stores: numbers, codes, and clocks, which count steps

    def _stored(self, target: Group, named: dict[int, str], indent: str) -> str:
        value = self.program.outputs[target]
        place = self.reach.given(target)
        if self._is_clock(target):
            return f"{indent}{place} = {self._count(value, target[1], named)};\n"
        text = self._real(value, named)
        if target in self.reach.types:
            text = f"({self.reach.types[target]})(int32_t){text}"
        return f"{indent}{place} = {text};\n"

    def _stays(self, target: Group) -> bool:
        return target[0] == NEXT_STATE and is_own(self.program, self.program.outputs[target], target[1])

    def _readable(self, needs: Mapping[Group, set[int]]) -> frozenset[Group]:
        """Outputs from which a computed number can be read back: no clocks, logical values, codes or delay lines."""
        return frozenset(
            target
            for target in needs
            if target[0] in (NEXT_STATE, OUTPUT)
            and self.program.outputs[target] not in self._whole
            and target not in self.reach.types
            and not self._is_clock(target)
        )

    def _is_clock(self, target: Group) -> bool:
        return target[0] == NEXT_STATE and target[1] in self.clocks

    def _count(self, index: int, position: int, named: dict[int, str]) -> str:
        operation, own = self.program.operations[index], self.reach.given((NEXT_STATE, position))
        if operation.name in ("select", "if"):
            first = self._count(operation.arguments[1], position, named)
            other = self._count(operation.arguments[2], position, named) if operation.name == "select" else "0U"
            return f"({self._truth(operation.arguments[0], named)} ? {first} : {other})"
        more = added(self.program, index, position)
        if more is not None:
            asked = "" if more.condition is None else f"{self._truth(more.condition, named)} && "
            # The count saturates, because an overflow would restart the clock.
            return f"(({asked}({own} < UINT32_MAX)) ? ({own} + 1U) : {own})"
        return own if is_own(self.program, index, position) else "0U"

    def _needed(self, target: Group) -> set[int]:
        """Values that the store of an output uses; for a clock, the conditions on which its next count depends."""

        def conditions(index: int) -> set[int]:
            operation = self.program.operations[index]
            more = added(self.program, index, target[1])
            if more is not None and more.condition is not None:
                return {more.condition}
            if operation.name not in ("select", "if"):
                return set()
            return {operation.arguments[0]}.union(*map(conditions, operation.arguments[1:]))

        value = self.program.outputs[target]
        return conditions(value) if self._is_clock(target) else {value}
