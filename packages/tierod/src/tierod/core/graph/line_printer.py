"""Print a straight line of operations as the body of a C function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tierod.core.graph.c_functions import FUSED, OWN
from tierod.core.graph.operations import LOGICAL, NEXT_STATE, OUTPUT, PUSH, RING, SAMPLE, STATE, Operation, Program
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
        """Names of all values in C."""
        named = {value: f"v{value}" for value in range(len(self.program.operations))}
        return named | {value: places.carried(slot) for value, slot in self.carried.items()}

    def statement(self, index: int, named: dict[int, str], places: Places, notes: dict[int, str], indent: str) -> str:
        """C line that computes one value."""
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
