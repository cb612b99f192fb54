"""Printing of a program as C functions of bounded length that pass values through a scratch array."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping

from tierod.core.graph.operations import branches
from tierod.export.nested import Nested, nested
from tierod.export.segments import LONGEST, Layout, Segment, layout, soon_taken
from tierod.export.statements import Body, StatementPrinter
from tierod.export.storage import Clock

_PLAIN = re.compile(r"[\w.>\[\]-]+")  # C code of an input that is a plain struct member


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
