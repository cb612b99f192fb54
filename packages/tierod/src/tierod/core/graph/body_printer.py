"""Print a straight line of operations as the body of a C function, without branches for lanes or with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from tierod.core.graph.c_functions import FUSED, OWN
from tierod.core.graph.operations import (
    LOGICAL,
    NEXT_STATE,
    OUTPUT,
    PUSH,
    RING,
    SAMPLE,
    STATE,
    Branch,
    Operation,
    Program,
    branches,
    is_constant,
    with_picks,
)
from tierod.core.graph.trace import Graph

INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
COMPARE = {"lt": "<", "le": "<=", "eq": "==", "ne": "!="}


@dataclass(frozen=True)
class Places:
    """C expressions that address the arrays from inside a loop."""

    state: Callable[[int], str]
    ring: Callable[[int], str]
    sample: Callable[[int], str]
    output: Callable[[int], str]
    carried: Callable[[int], str]


class LinePrinter:
    """Prints the operations of one graph as lines of C; holds the layout that all functions of a file share."""

    def __init__(self, graph: Graph, operations: Program):
        self.graph, self.program = graph, operations
        self.carried = {value: index for index, value in enumerate(operations.carried())}
        starts = [len(graph.state)]
        for _, size in graph.rings:
            starts.append(starts[-1] + size)
        self.ring_start = starts

    def prepared(self, stride: int) -> str:
        """C that computes `c` from the tuning `p`, with a stride between the numbers of `c`."""
        lines = []
        for index, operation in enumerate(self.program.operations):
            if index in self.program.invariant and operation.name != "constant":
                value = f"p[{operation.constant[1]}]" if operation.name == "input" else self.expression(operation, {})
                lines.append(f"    const real v{index} = {value};\n")
        stores = [f"    c[{slot * stride}] = v{value};\n" for value, slot in self.carried.items()]
        unused = ("" if any("= p[" in line for line in lines) else "    (void)p;\n") + (
            "" if stores else "    (void)c;\n"
        )
        return "".join(lines) + "".join(stores) + unused

    def body(self, places: Places, indent: str) -> str:
        """C of the whole step."""
        named = self.names(places)
        notes = self.notes()
        lines = [
            self.statement(index, named, places, notes, indent)
            for index in range(len(self.program.operations))
            if index not in self.program.invariant
        ]
        for target, value in sorted(self.program.outputs.items()):
            lines.append(self.store(target, value, named, places, indent))
        return "".join(lines)

    def names(self, places: Places) -> dict[int, str]:
        named = {value: f"v{value}" for value in range(len(self.program.operations))}
        return named | {value: places.carried(slot) for value, slot in self.carried.items()}

    def statement(self, index: int, named: dict[int, str], places: Places, notes: dict[int, str], indent: str) -> str:
        operation = self.program.operations[index]
        if operation.name == "input":
            group, position = operation.constant
            reach = {STATE: places.state, RING: places.ring, SAMPLE: places.sample}
            return f"{indent}const real v{index} = {reach[group](position)};\n"
        note = f" /* {notes[index]} */" if index in notes else ""
        return f"{indent}const real v{index} = {self.expression(operation, named)};{note}\n"

    def store(self, target: tuple[int, int], value: int, named: dict[int, str], places: Places, indent: str) -> str:
        group, position = target
        reach = {NEXT_STATE: places.state, PUSH: places.ring, OUTPUT: places.output}
        return f"{indent}{reach[group](position)} = {self.constant(value) or named[value]};\n"

    def notes(self) -> dict[int, str]:
        """Names of the next states and outputs that values stand for, by index."""
        names = {NEXT_STATE: self.graph.state, OUTPUT: self.graph.output}
        notes: dict[int, str] = {}
        for (group, position), value in self.program.outputs.items():
            if group in names:
                word = "next " if group == NEXT_STATE else ""
                notes[value] = "; ".join(filter(None, [notes.get(value), word + names[group][position]]))
        return notes

    def constant(self, index: int) -> str | None:
        """C of a constant; None for a value that is no constant."""
        operation = self.program.operations[index]
        if operation.name != "constant":
            return None
        value = float(operation.constant)
        if value in (float("inf"), float("-inf")):
            return "(real)INFINITY" if value > 0 else "(-(real)INFINITY)"
        return f"R({value!r})" if value >= 0 else f"(-R({-value!r}))"

    def _is_logical(self, index: int) -> bool:
        operation = self.program.operations[index]
        if operation.name == "select":
            return all(map(self._is_logical, operation.arguments[1:]))
        return operation.name in LOGICAL or (operation.name == "constant" and operation.constant in (0.0, 1.0))

    def expression(self, operation: Operation, named: dict[int, str]) -> str:
        def text(index: int) -> str:
            return self.constant(index) or named.get(index, f"v{index}")

        def truth(index: int) -> str:
            return text(index) if self._is_logical(index) else f"({text(index)} != R(0.0) ? R(1.0) : R(0.0))"

        name, arguments = operation.name, operation.arguments
        if name in INFIX:
            return f"{text(arguments[0])} {INFIX[name]} {text(arguments[1])}"
        if name in FUSED:
            return FUSED[name].format(*map(text, arguments))
        if name in COMPARE:
            return f"{text(arguments[0])} {COMPARE[name]} {text(arguments[1])} ? R(1.0) : R(0.0)"
        # Truth values are numbers, 0 or 1: && and || would branch, and the loop over lanes would not vectorise.
        if name == "and":
            return f"{truth(arguments[0])} * {truth(arguments[1])}"
        if name == "or":
            return f"{truth(arguments[0])} + {truth(arguments[1])} > R(0.0) ? R(1.0) : R(0.0)"
        if name == "select":
            return f"{text(arguments[0])} != R(0.0) ? {text(arguments[1])} : {text(arguments[2])}"
        if name == "if":
            return f"{text(arguments[0])} != R(0.0) ? {text(arguments[1])} : R(0.0)"
        unary = {"not": "{0} == R(0.0) ? R(1.0) : R(0.0)", "neg": "-{0}", "inverse": "R(1.0) / {0}", "assign": "{0}"}
        if name in unary:
            return unary[name].format(text(arguments[0]))
        function = OWN.get(name, f"M({name})")
        return f"{function}({', '.join(map(text, arguments))})"


class BranchingPrinter(LinePrinter):
    """Prints a step that runs alone and need not vectorise; its numbers equal those of `LinePrinter` to the last bit.

    Args:
        gathered: gives C of one of several inputs from their positions in the sample and C of the number that
            picks; None where their positions do not allow that
    """

    def __init__(
        self, graph: Graph, operations: Program, gathered: Callable[[Sequence[int], str], str | None] | None = None
    ):
        super().__init__(graph, with_picks(operations))
        self._whole = truths_of(self.program)
        self._logical = frozenset(self.program.operations[index] for index in self._whole)
        self._gathers = self._gathered(gathered) if gathered else {}
        self._left_out = self._gathered_alone()

    def _gathered(self, gathered: Callable[[Sequence[int], str], str | None]) -> dict[int, str]:
        found = {}
        for index, operation in enumerate(self.program.operations):
            if operation.name == "pick":
                inputs = [self.program.operations[each] for each in operation.arguments[1:]]
                if all(each.name == "input" and each.constant[0] == SAMPLE for each in inputs):
                    text = gathered([each.constant[1] for each in inputs], f"i{index}")
                    if text is not None:
                        found[index] = text
        return found

    def _gathered_alone(self) -> frozenset[int]:
        operations = self.program.operations
        gathered = {each for index in self._gathers for each in operations[index].arguments[1:]}
        others = {
            each
            for index, operation in enumerate(operations)
            for each in (operation.arguments[:1] if index in self._gathers else operation.arguments)
        }
        return frozenset(gathered - others - set(self.program.outputs.values()))

    def body(self, places: Places, indent: str) -> str:
        """C of the whole step."""
        named, notes = self.names(places), self.notes()
        parts = branches(self.program)
        lines = [self._branch(part, named, places, notes, indent) for part in parts]
        lines += [
            self.store(target, value, named, places, indent) for target, value in sorted(self.program.outputs.items())
        ]
        return "".join(lines)

    def _branch(self, part: Branch, named: dict[int, str], places: Places, notes: dict[int, str], indent: str) -> str:
        if part.condition is None:
            needed = [index for index in part.operations if index not in self._left_out]
            return "".join(self.statement(index, named, places, notes, indent) for index in needed)
        # Values that are used outside the branch are declared before it.
        inside = set(part.operations)
        taken = {index for index in inside if not self._used_by.get(index, inside) <= inside}
        lines = [f"{indent}{self._kind(index)} v{index} = 0;\n" for index in part.operations if index in taken]
        asked = self._truth(part.condition.value, named)
        lines.append(f"{indent}if ({asked if part.condition.holds else f'!{asked}'}) {{\n")
        for index in part.operations:
            line = self.statement(index, named, places, notes, indent + "    ")
            lines.append(
                line.replace(f"const {self._kind(index)} v{index} =", f"v{index} =") if index in taken else line
            )
        return "".join([*lines, f"{indent}}}\n"])

    @cached_property
    def _used_by(self) -> dict[int, set[int]]:
        used_by: dict[int, set[int]] = {}
        for index, operation in enumerate(self.program.operations):
            for argument in operation.arguments:
                used_by.setdefault(argument, set()).add(index)
        return used_by

    def _kind(self, index: int) -> str:
        return "int" if index in self._whole else "real"

    def statement(self, index: int, named: dict[int, str], places: Places, notes: dict[int, str], indent: str) -> str:
        operation = self.program.operations[index]
        if operation.name == "pick":
            return self._picked(index, named, indent)
        line = super().statement(index, named, places, notes, indent)
        return line.replace("const real ", "const int ", 1) if index in self._whole else line

    def _picked(self, index: int, named: dict[int, str], indent: str) -> str:
        """C of a value picked by its number; a number that is none of 1, 2, ... picks the first value."""
        number, *values = self.program.operations[index].arguments
        given, last = self._real(number, named), len(values) - 1
        # The range is tested first: C does not define the conversion of NaN or of too large a number to int.
        whole = f"{given} >= R(1.0) && {given} <= R({last}.0) && {given} == (real)(int){given} ? (int){given} : 0"
        if index in self._gathers:
            return f"{indent}const int i{index} = {whole};\n{indent}const real v{index} = {self._gathers[index]};\n"
        table = ", ".join(self._real(each, named) for each in values)
        return f"{indent}const real w{index}[] = {{{table}}};\n{indent}const real v{index} = w{index}[{whole}];\n"

    def expression(self, operation: Operation, named: dict[int, str]) -> str:
        name, arguments = operation.name, operation.arguments
        if name in COMPARE:
            return f"{self._real(arguments[0], named)} {COMPARE[name]} {self._real(arguments[1], named)}"
        if name in ("and", "or"):
            return f" {'&' if name == 'and' else '|'} ".join(self._truth(each, named) for each in arguments)
        if name == "not":
            return f"!{self._truth(arguments[0], named)}"
        if name in ("select", "if"):
            logical = operation in self._logical
            chosen = [self._truth(a, named) if logical else self._real(a, named) for a in arguments[1:]]
            other = chosen[1] if name == "select" else self._zero(logical)
            return f"{self._truth(arguments[0], named)} ? {chosen[0]} : {other}"
        reals = {each: f"(real){named.get(each, f'v{each}')}" for each in arguments if each in self._whole}
        return super().expression(operation, named | reals if reals else named)

    def _zero(self, logical: bool) -> str:
        return "0" if logical else "R(0.0)"

    def _real(self, index: int, named: dict[int, str]) -> str:
        name = self.constant(index) or named.get(index, f"v{index}")
        return f"(real){name}" if index in self._whole else name

    def _truth(self, index: int, named: dict[int, str]) -> str:
        constant = self.program.operations[index]
        if constant.name == "constant":
            return "1" if constant.constant != 0.0 else "0"
        name = named.get(index, f"v{index}")
        return name if index in self._whole else f"({name} != R(0.0))"


def truths_of(program: Program) -> frozenset[int]:
    """Values that are 0 or 1 and are computed in every step."""
    known = {
        index
        for index, operation in enumerate(program.operations)
        if is_constant(operation, 0.0) or is_constant(operation, 1.0)
    }
    found: set[int] = set()
    for index, operation in enumerate(program.operations):
        chosen = operation.arguments[1:] if operation.name in ("select", "if") else ()
        chooses_truths = any(each in found for each in chosen) and all(each in found | known for each in chosen)
        if index not in program.invariant and (operation.name in LOGICAL or chooses_truths):
            found.add(index)
    return frozenset(found)
