"""Printing of a program as C functions of bounded length that pass values through a scratch array."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tierod.core.graph.body_printer import COMPARE, BranchingPrinter, Places
from tierod.core.graph.operations import NEXT_STATE, OUTPUT, Operation, Program, branches
from tierod.core.graph.trace import Graph
from tierod.export.interface import Clock, Spelling, added, is_own
from tierod.export.segments import LONGEST, Layout, Nested, Segment, layout, nested, soon_taken

_PLAIN = re.compile(r"[\w.>\[\]-]+")  # C code of an input that is a plain struct member


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


class CutPrinter(StatementPrinter):
    """Printer of one program as several functions, with the operations of the kernels in the same order."""

    def __init__(self, body: Body, clocks: Mapping[int, Clock], longest: int = LONGEST):
        super().__init__(body, clocks)
        self._needs = {target: self._needed(target) for target in self.program.outputs if not self._stays(target)}
        self._longest = longest
        self.layout = self._laid_out()
        self._users = self._takers()

    def _laid_out(self) -> Layout:
        ordered = soon_taken(self.program, branches(self.program))
        readable = self._readable(self._needs)
        return layout(self.program, self._needs, ordered, self._whole, self._longest, readable)

    def _takers(self) -> dict[int, set[int]]:
        """Operations that use each value; -1 where it is stored."""
        found: dict[int, set[int]] = {}
        for index in (each for segment in self.layout.segments for each in segment.operations):
            for argument in self._arguments(index):
                found.setdefault(argument, set()).add(index)
        for values in self._needs.values():
            for value in values:
                found.setdefault(value, set()).add(-1)
        return found

    def functions(self, name: str, arguments: Mapping[str, str], static: bool = False) -> str:
        texts, calls = [], []
        given = {**arguments, **self._scratch_arguments()}
        for number, group in enumerate(self._grouped()):
            body = "".join(self._segment(segment) for segment in group)
            # Members and outputs may share the name of an argument (u->x), and so may comments.
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
        groups: list[list[Segment]] = []
        # Counted as full, so that the first segment opens a group.
        size = self._longest
        for segment in self.layout.segments:
            own = self._length(segment)
            if size + own > self._longest:
                groups.append([])
                size = 0
            groups[-1].append(segment)
            size += own
        return groups

    def _length(self, segment: Segment) -> int:
        return len(segment.operations) + len(segment.stores)

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
        kept = [index for index in segment.operations if index in self.layout.slots]
        lines += [f"{indent}{self._slot(index)} = v{index};\n" for index in kept]
        lines += [self._stored(target, named, indent) for target in segment.stores]
        text = "".join(map(self.spelling.spelt, lines))
        if segment.condition is None:
            return f"    {{\n{text}    }}\n" if own or read else text
        asked = self.spelling.spelt(self._truth(segment.condition.value, self._outside(segment.condition.value)))
        # Compilers cannot see that these values are used only under the same condition, and would warn.
        other = "".join(
            f"        {self._slot(index)} = {'false' if index in self._whole else self.spelling.number(0.0)};\n"
            for index in kept
        )
        missing = f" else {{\n{other}    }}\n" if other else "\n"
        return f"    if ({asked if segment.condition.holds else f'!{asked}'}) {{\n{text}    }}{missing}"

    def _uses(self, segment: Segment) -> dict[int, set[int]]:
        """Operations that use each value of a segment; -1 means any use outside of it."""
        own = set(segment.operations)
        stored = {value for target in segment.stores for value in self._needs[target]}
        taken = {argument for index in own for argument in self._arguments(index)}
        outside = own & (self.layout.slots.keys() | stored)
        return {
            index: {each if each in own else -1 for each in self._users.get(index, ())}
            | ({-1} if index in outside else set())
            for index in own | taken
        }

    def _direct(self, segment: Segment) -> dict[int, str]:
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
        """Values that a statement names; of a selection among indexed inputs only the index."""
        arguments = self.program.operations[index].arguments
        return arguments[:1] if index in self._gathers else arguments

    def _names(self, own: set[int]) -> dict[int, str]:
        crossing = {index: self._slot(index) for index in self.layout.slots if index not in own}
        stored = {index: self.reach.given(at) for index, at in self.layout.read_back.items() if index not in own}
        return self.names(self._places()) | stored | crossing

    def _outside(self, index: int) -> dict[int, str]:
        operation = self.program.operations[index]
        own = {index: self.reach.taken(operation.constant)} if operation.name == "input" else {}
        return self._names(set()) | own

    def _slot(self, index: int) -> str:
        return f"{'b' if index in self._whole else 'w'}[{self.layout.slots[index]}]"
