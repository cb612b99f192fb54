"""Print a program as functions of bounded length that pass values through a scratch array."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tierod.core.graph.branches import branches
from tierod.core.graph.branching_printer import BranchingPrinter
from tierod.core.graph.line_printer import COMPARE, Places
from tierod.core.graph.operations import NEXT_STATE, OUTPUT, Operation, Program
from tierod.core.graph.trace import Graph
from tierod.export.clocks import Clock, added, is_own
from tierod.export.nested import Nested, nested
from tierod.export.order import soon_taken
from tierod.export.segments import LONGEST, Layout, Segment, layout
from tierod.export.spelling import Spelling

_PLAIN = re.compile(r"[\w.>\[\]-]+")
"""C of an input that is a member as it stands."""

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


class CutPrinter(BranchingPrinter):
    """One program as several functions; the operations are those of the kernels, in the same order.

    Args:
        graph: of the block
        operations: its program
        spelling: of names and numbers
        reach: C of inputs and outputs
        clocks: states that are kept as whole numbers of steps
        longest: operations of one function
        gathered: see `BranchingPrinter`
    """

    def __init__(
        self,
        graph: Graph,
        operations: Program,
        spelling: Spelling,
        reach: Reach,
        clocks: Mapping[int, Clock],
        longest: int = LONGEST,
        gathered: Gathered | None = None,
    ):
        super().__init__(graph, operations, gathered)
        self.spelling, self.reach, self.clocks = spelling, reach, clocks
        needs = {target: self._needed(target) for target in self.program.outputs if not self._stays(target)}
        self.layout: Layout = layout(
            self.program,
            needs,
            soon_taken(self.program, branches(self.program)),
            self._whole,
            longest,
            self._readable(needs),
        )
        self._needs = needs
        self._longest = longest
        self._users = self._takers()

    def _takers(self) -> dict[int, set[int]]:
        """Operations that take a value; -1 where it is stored."""
        found: dict[int, set[int]] = {}
        for index in (each for segment in self.layout.segments for each in segment.operations):
            for argument in self._arguments(index):
                found.setdefault(argument, set()).add(index)
        for values in self._needs.values():
            for value in values:
                found.setdefault(value, set()).add(-1)
        return found

    # -- functions -----------------------------------------------------------------------------------------------

    def functions(self, name: str, arguments: Mapping[str, str], static: bool = False) -> str:
        """All functions and the one that calls them.

        Args:
            name: of the one that calls the others
            arguments: C of the declaration of each argument, by its name
            static: whether the one that calls the others is static too
        """
        texts, calls = [], []
        given = {**arguments, **self._scratch_arguments()}
        for number, group in enumerate(self._grouped()):
            body = "".join(self._segment(segment) for segment in group)
            # A member or an output may be called like an argument: u->x, and the comment of a value.
            code = re.sub(r"/\*.*?\*/", "", body)
            used = [word for word in given if re.search(rf"(?<!->)\b{word}\b", code)]
            part = f"{name}_{number:02d}"
            texts.append(f"static void {part}({', '.join(given[word] for word in used)})\n{{\n{body}}}\n\n")
            calls.append(f"    {part}({', '.join(used)});\n")
        numbers, truths = self.layout.sizes
        scratch = f"    {self.spelling.real} w[{numbers}];\n" if numbers else ""
        scratch += f"    bool b[{truths}];\n" if truths else ""
        whole = "".join(calls)
        unused = "".join(f"    (void){word};\n" for word in arguments if not re.search(rf"\b{word}\b", whole))
        declared = ", ".join(arguments.values())
        return f"{''.join(texts)}{'static ' if static else ''}void {name}({declared})\n{{\n{scratch}{unused}{whole}}}\n"

    def _scratch_arguments(self) -> dict[str, str]:
        numbers, truths = self.layout.sizes
        return ({"w": f"{self.spelling.real} w[{numbers}]"} if numbers else {}) | (
            {"b": f"bool b[{truths}]"} if truths else {}
        )

    def _grouped(self) -> list[list[Segment]]:
        """Segments that share a function: together no longer than one may be."""
        groups: list[list[Segment]] = []
        size = self._longest
        for segment in self.layout.segments:
            own = len(segment.operations) + len(segment.stores)
            if size + own > self._longest:
                groups.append([])
                size = 0
            groups[-1].append(segment)
            size += own
        return groups

    def _segment(self, segment: Segment) -> str:
        own, program = set(segment.operations), self.program
        taken = {argument for index in segment.operations for argument in self._arguments(index)}
        taken = taken.union(*(self._needs[target] for target in segment.stores))
        direct = self._direct(segment)
        named = self._names(own) | direct
        inputs = (i for i in taken if program.operations[i].name == "input" and i not in program.invariant)
        read = sorted(i for i in inputs if i not in direct)
        indent = "        " if segment.condition or own or read else "    "
        places, notes = self._places(), self.notes()
        lines = [self.statement(index, named, places, notes, indent) for index in read]
        for each in nested(program, segment.operations, self._uses(segment)):
            if isinstance(each, Nested):
                lines.append(self._nested(each, named, notes, indent))
            else:
                lines.append(self.statement(each, named, places, notes, indent))
        lines += [self._kept(index, indent) for index in segment.operations if index in self.layout.slots]
        lines += [self._stored(target, named, indent) for target in segment.stores]
        text = "".join(map(self.spelling.spelt, lines))
        if segment.condition is None:
            return f"    {{\n{text}    }}\n" if own or read else text
        asked = self.spelling.spelt(self._truth(segment.condition.value, self._outside(segment.condition.value)))
        kept = (index for index in segment.operations if index in self.layout.slots)
        # Compilers cannot see that nothing takes these values elsewhere.
        other = "".join(
            f"        {self._slot(index)} = {'false' if index in self._whole else self.spelling.number(0.0)};\n"
            for index in kept
        )
        missing = f" else {{\n{other}    }}\n" if other else "\n"
        return f"    if ({asked if segment.condition.holds else f'!{asked}'}) {{\n{text}    }}{missing}"

    def _uses(self, segment: Segment) -> dict[int, set[int]]:
        """Operations of a segment that take a value; -1 stands for all that is outside of it."""
        own = set(segment.operations)
        stored = {value for target in segment.stores for value in self._needs[target]}
        taken = {argument for index in own for argument in self._arguments(index)}
        outside = own & (self.layout.slots.keys() | stored)
        return {
            index: {each if each in own else -1 for each in self._users.get(index, ())}
            | ({-1} if index in outside else set())
            for index in own | taken
        }

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
        """What a selection takes on one side."""
        logical = selection in self._whole
        if value is None:
            return self._zero(logical)
        return self._truth(value, named) if logical else self._real(value, named)

    def _direct(self, segment: Segment) -> dict[int, str]:
        """C of the inputs that one operation alone takes, and no store: they need no name of their own."""
        counted = Counter(argument for index in segment.operations for argument in self._arguments(index))
        stored = {value for target in segment.stores for value in self._needs[target]}
        texts = {
            index: self.reach.taken(self.program.operations[index].constant)
            for index, count in counted.items()
            if count == 1
            and index not in stored
            and index not in self.program.invariant
            and self.program.operations[index].name == "input"
        }
        return {index: text for index, text in texts.items() if _PLAIN.fullmatch(text)}

    def _arguments(self, index: int) -> tuple[int, ...]:
        """Values that a statement names: of a pick among inputs that are reached by number the number alone."""
        arguments = self.program.operations[index].arguments
        return arguments[:1] if index in self._gathers else arguments

    def _names(self, own: set[int]) -> dict[int, str]:
        crossing = {index: self._slot(index) for index in self.layout.slots if index not in own}
        stored = {index: self.reach.given(at) for index, at in self.layout.read_back.items() if index not in own}
        return self.names(self._places()) | stored | crossing

    def _outside(self, index: int) -> dict[int, str]:
        """Names of values where no input has been read."""
        operation = self.program.operations[index]
        own = {index: self.reach.taken(operation.constant)} if operation.name == "input" else {}
        return self._names(set()) | own

    def _kept(self, index: int, indent: str) -> str:
        return f"{indent}{self._slot(index)} = v{index};\n"

    def _slot(self, index: int) -> str:
        """Where a value lies that crosses functions."""
        return f"{'b' if index in self._whole else 'w'}[{self.layout.slots[index]}]"

    # -- inputs and outputs --------------------------------------------------------------------------------------

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

    def _stored(self, target: Group, named: dict[int, str], indent: str) -> str:
        value = self.program.outputs[target]
        place = self.reach.given(target)
        if self._is_clock(target):
            return f"{indent}{place} = {self._count(value, target[1], named)};\n"
        text = self._real(value, named)
        if target in self.reach.types:
            text = f"({self.reach.types[target]})(int32_t){text}"
        return f"{indent}{place} = {text};\n"

    # -- clocks --------------------------------------------------------------------------------------------------

    def _stays(self, target: Group) -> bool:
        """Whether a state is what it was."""
        return target[0] == NEXT_STATE and is_own(self.program, self.program.outputs[target], target[1])

    def _readable(self, needs: Mapping[Group, set[int]]) -> frozenset[Group]:
        """Outputs that hold a number as it was worked out: no clocks, truths, codes and delay lines."""
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
        """The next number of steps of a clock."""
        operation, own = self.program.operations[index], self.reach.given((NEXT_STATE, position))
        if operation.name in ("select", "if"):
            first = self._count(operation.arguments[1], position, named)
            other = self._count(operation.arguments[2], position, named) if operation.name == "select" else "0U"
            return f"({self._truth(operation.arguments[0], named)} ? {first} : {other})"
        more = added(self.program, index, position)
        if more is not None:
            asked = "" if more.condition is None else f"{self._truth(more.condition, named)} && "
            return f"(({asked}({own} < UINT32_MAX)) ? ({own} + 1U) : {own})"
        return own if is_own(self.program, index, position) else "0U"

    def _needed(self, target: Group) -> set[int]:
        """Values that the storing of an output takes: of a clock the conditions on which its next number depends."""

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

    # -- single operations ---------------------------------------------------------------------------------------

    def statement(self, index: int, named: dict[int, str], places: Places, notes: dict[int, str], indent: str) -> str:
        """The lines that work out one value."""
        operation = self.program.operations[index]
        if operation.name == "input":
            return f"{indent}const real v{index} = {self.reach.taken(operation.constant)};\n"
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
        reals = {each: self._real(each, named) for each in arguments if each in self._whole and name != "select"}
        if name in ("select", "if"):
            condition, _, rest = super().expression(operation, named).partition(" ? ")
            return f"({condition}) ? {rest}" if " " in condition else f"{condition} ? {rest}"
        return super(BranchingPrinter, self).expression(operation, named | reals)

    def _zero(self, logical: bool) -> str:
        """What a selection gives where it has no second value."""
        return "false" if logical else self.spelling.number(0.0)

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
