"""Printing of a rolled step: operations repeated per hypothesis, sensor or delay as loops, the rest as functions."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from tierod.core.graph.branches import with_picks
from tierod.core.graph.branching_printer import truths_of
from tierod.core.graph.membership import MEMBER, with_members
from tierod.core.graph.operations import Operation, Program
from tierod.export.addresses import Tables
from tierod.export.clocks import Clock
from tierod.export.cut_printer import CutPrinter
from tierod.export.net import STORE, Target, net_of
from tierod.export.packs import Pack, families
from tierod.export.rolled import is_kept_at_the_end, outside, places, rolled, worked
from tierod.export.schedule import Loop
from tierod.export.segments import LONGEST, Layout, Segment
from tierod.export.statements import Body, Reach, StatementPrinter, halves, hexadecimal

_VALUE = re.compile(r"(?<![\w>.])v(\d+)\b")

LARGEST = 1 << 16
"""Largest whole number to which an iteration number is added; such sums are exact in single precision."""

ROLE = 5
"""Group of the values that an iteration takes from elsewhere, which are inputs of its program."""


Rolling = Mapping[str, Mapping[Target, str]]
"""Dotted names of inputs and outputs, from which loops are found: "input" and "output" -> position -> name."""


@dataclass(frozen=True)
class LoopSegment(Segment):
    """Operations of a loop.

    Args:
        loop: that contains them
    """

    loop: Loop = field(kw_only=True)


@dataclass(frozen=True)
class Turn:
    """One iteration of a loop as a program.

    Args:
        printer: of its statements
        texts: C code of the values taken from elsewhere, by the number of the value
        values: number of the value of every pack, by the pack's members
    """

    printer: StatementPrinter
    texts: Mapping[int, str]
    values: Mapping[tuple[int, ...], int]


class RolledPrinter(CutPrinter):
    """Printer of one program as loops and functions, numerically equal to `CutPrinter` to the last bit.

    Args:
        body, clocks, longest: see `CutPrinter`
        rolling: names from which loops are found
    """

    def __init__(self, body: Body, clocks: Mapping[int, Clock], rolling: Rolling, longest: int = LONGEST):
        self._rolling = rolling
        joined = with_members(with_picks(body.operations))
        super().__init__(replace(body, operations=joined, truths=truths_of(joined)), clocks, longest)

    def _laid_out(self) -> Layout:
        clocks = {target for target in self._needs if self._is_clock(target)}
        net = net_of(self.program, self._needs, clocks)
        operations = net.program.operations
        inputs = {
            f"input.{self._rolling['input'][each.constant]}": index
            for index, each in enumerate(operations)
            if each.name == "input" and each.constant in self._rolling["input"]
        }
        stores = {
            f"output.{self._rolling['output'][each.constant]}": index
            for index, each in enumerate(operations)
            if each.name == STORE and each.constant in self._rolling["output"]
        }
        step = rolled(
            net, families(inputs | stores), self._whole, lambda at: self._reached(operations, at), self._longest
        )
        self.program, self._whole = step.net.program, step.truths
        self._logical = frozenset(self.program.operations[index] for index in self._whole)
        slots, sizes = places(step)
        segments: list[Segment] = []
        for part in step.parts:
            own = tuple(worked(part))
            stored = tuple(target for index in own if (target := step.net.target(index)) is not None)
            rest = tuple(index for index in own if step.net.target(index) is None)
            if isinstance(part, Loop):
                segments.append(LoopSegment(None, rest, stored, loop=part))
            else:
                segments.append(Segment(None, rest, stored))
        return Layout(tuple(segments), slots, {}, sizes)

    def _reached(self, operations: Sequence[Operation], index: int) -> str:
        """C code of an input, of a value depending on parameters only, or of a store's destination with its type."""
        operation = operations[index]
        if operation.name == STORE:
            return f"{self.reach.types.get(operation.constant, '')} {self.reach.given(operation.constant)}"
        if index in self.carried:
            return self.reach.carried(self.carried[index])
        return self.reach.taken(operation.constant)

    def _length(self, segment: Segment) -> int:
        return len(segment.loop.packs) if isinstance(segment, LoopSegment) else super()._length(segment)

    def _segment(self, segment: Segment) -> str:
        if not isinstance(segment, LoopSegment):
            return super()._segment(segment)
        return self.spelling.spelt(self._looped(segment.loop))

    # -- loops ---------------------------------------------------------------------------------------------------

    def _looped(self, loop: Loop) -> str:
        """C code of one loop with its tables."""
        tables = Tables(self._table)
        handed = {column: f"h{number}" for number, column in enumerate(loop.handed_on)}
        turn = self._turn(loop, tables, handed)
        indent = " " * 12
        lines = [
            f"{indent}const {self._type(index in turn.printer._whole)} v{index} = {text};\n"
            for index, text in turn.texts.items()
        ]
        ends = []
        for pack in loop.packs:
            target = self._target(pack.members[0])
            if target is None:
                lines.append(self._worked(turn, pack, tables, indent))
            else:
                lines.append(self._stored_by(turn, pack, target, tables, indent))
            at_the_end = is_kept_at_the_end(loop, pack, self.layout.slots)
            if target is None and not at_the_end and any(index in self.layout.slots for index in pack.members):
                place = tables.indexed([self._slot(index) for index in pack.members])
                ends.append(f"{indent}{place} = v{turn.values[pack.members]};\n")
        begun, left = self._handed(loop, handed, turn, ends, indent)
        # Values of an iteration are renamed from v to r, because v numbers denote values of the whole step.
        body = _VALUE.sub(r"r\1", "".join(lines + ends))
        head = f"        for (uint16_t i = 0U; i < {loop.turns}U; i++) {{\n"
        return f"    {{\n{tables.text}{begun}{head}{body}        }}\n{left}    }}\n"

    def _turn(self, loop: Loop, tables: Tables, handed: Mapping[tuple[int, ...], str]) -> Turn:
        """Program of one iteration, whose inputs are the values taken from elsewhere."""
        operations: list[Operation] = []
        numbers: dict[tuple[int, ...], int] = {}
        texts: dict[int, str] = {}
        truths: set[int] = set()
        for column in (*outside(loop), *handed):
            number = numbers[column] = len(operations)
            known = self.program.operations[column[0]]
            if len(set(column)) == 1 and known.name == "constant":
                operations.append(known)
                continue
            operations.append(Operation("input", (), (ROLE, number)))
            texts[number] = handed[column] if column in handed else self._from(column, tables)
            if (loop.handed_on[column][0] if column in handed else column[0]) in self._whole:
                truths.add(number)
        for pack in loop.packs:
            numbers[pack.members] = len(operations)
            if pack.members[0] in self._whole:
                truths.add(len(operations))
            first = self.program.operations[pack.members[0]]
            operations.append(first._replace(arguments=tuple(numbers[column] for column in pack.columns)))
        program = Program(tuple(operations), {}, frozenset())
        reach = Reach(lambda source: texts[source[1]], self.reach.given, self.reach.carried, {}, {})
        printer = StatementPrinter(Body(self.graph, program, self.spelling, reach, truths=frozenset(truths)))
        return Turn(printer, texts, numbers)

    def _from(self, column: Sequence[int], tables: Tables) -> str:
        """C code of the value that an iteration takes from elsewhere."""
        operations = self.program.operations
        if operations[column[0]].name == "constant":
            return self._numbers([float(operations[index].constant) for index in column], tables)
        texts = [self._slot(i) if i in self.layout.slots else self._reached(operations, i) for i in column]
        return texts[0] if len(set(column)) == 1 else tables.indexed(texts)

    def _numbers(self, values: Sequence[float], tables: Tables) -> str:
        """C code of the constant of an iteration; consecutive whole numbers are computed from the iteration number."""
        first = values[0]
        follow = all(value == first + turn for turn, value in enumerate(values))
        if follow and first.is_integer() and math.copysign(1.0, first) > 0.0 and first < LARGEST:
            return "(real)i" if first == 0.0 else f"(real)i + {self.spelling.number(first)}"
        return tables.at(self.spelling.real, [self.spelling.number(value) for value in values])

    def _worked(self, turn: Turn, pack: Pack, tables: Tables, indent: str) -> str:
        """C code of one value of an iteration."""
        index, operations = turn.values[pack.members], self.program.operations
        if operations[pack.members[0]].name == MEMBER:
            (number,) = turn.printer.program.operations[index].arguments
            sets = zip(*(halves(operations[each].constant) for each in pack.members), strict=True)
            low, high = (tables.at("uint32_t", list(map(hexadecimal, each))) for each in sets)
            asked = turn.printer.membership(turn.printer._real(number, {}), low, high)
            return f"{indent}const bool v{index} = {asked};\n"
        return turn.printer.statement(index, {}, turn.printer._places(), {}, indent)

    def _stored_by(self, turn: Turn, pack: Pack, target: Target, tables: Tables, indent: str) -> str:
        """C code of one store of an iteration."""
        (value,) = turn.printer.program.operations[turn.values[pack.members]].arguments
        place = tables.indexed([self.reach.given(self.program.operations[each].constant) for each in pack.members])
        text = turn.printer._real(value, {})
        if target in self.reach.types:
            text = f"({self.reach.types[target]})(int32_t){text}"
        return f"{indent}{place} = {text};\n"

    def _handed(
        self, loop: Loop, handed: Mapping[tuple[int, ...], str], turn: Turn, ends: list[str], indent: str
    ) -> tuple[str, str]:
        """C code before and after the loop for values handed on; code that ends an iteration is appended to `ends`."""
        begun, left = "", ""
        named = self._names(set())
        kept: set[tuple[int, ...]] = set()
        for column, name in handed.items():
            source = loop.handed_on[column]
            first = self.program.operations[column[0]]
            known = named | ({column[0]: self.reach.taken(first.constant)} if first.name == "input" else {})
            truth = source[0] in self._whole
            text = self._truth(column[0], known) if truth else self._real(column[0], known)
            begun += f"        {self._type(truth)} {name} = {text};\n"
            ends.append(f"{indent}{name} = v{turn.values[source]};\n")
            pack = next(each for each in loop.packs if each.members == source)
            if (
                source[-1] in self.layout.slots
                and is_kept_at_the_end(loop, pack, self.layout.slots)
                and source not in kept
            ):
                kept.add(source)
                left += f"        {self._slot(source[-1])} = {name};\n"
        return begun, left

    def _target(self, index: int) -> Target | None:
        """Output that an operation stores; None for any other operation."""
        operation = self.program.operations[index]
        return operation.constant if operation.name == STORE else None

    def _type(self, truth: bool) -> str:
        return "bool" if truth else self.spelling.real

    def _table(self, kind: str, name: str, values: Sequence[str]) -> str:
        lines = textwrap.wrap(", ".join(values), 100)
        rows = "".join(f"            {line}\n" for line in lines)
        return f"        static const {kind} {name}[{len(values)}] = {{\n{rows}        }};\n"
