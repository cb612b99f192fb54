"""Print a graph as C99: one step, a loop over a recording, and a loop over 64 vehicles at once."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from tierod.graph.c_library import FUSED, OWN, PRELUDE
from tierod.graph.operations import (
    LOGICAL,
    NEXT_STATE,
    OUTPUT,
    PUSH,
    RING,
    SAMPLE,
    STATE,
    Operation,
    Program,
    program,
)
from tierod.graph.trace import Graph

LANES = 64
TILE_STEPS = 64
"""Samples of one tile: inputs and outputs of 64 vehicles then stay in a core's cache."""
STATE_IN_LOCALS = 200

INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
COMPARE = {"lt": "<", "le": "<=", "eq": "==", "ne": "!="}


def prefix(graph: Graph) -> str:
    """What every exported name of the graph's C begins with."""
    return f"tierod_{re.sub(r'[^0-9A-Za-z]+', '_', graph.name).lower()}"


def print_scalar(graph: Graph) -> str:
    """C99 for one vehicle: `prepare`, `push` (one step on bound buffers) and `scan` (a loop over a recording)."""
    return _Printer(graph, program(graph.function)).scalar()


def print_lanes(graph: Graph, own_tuning: bool) -> str:
    """C99 for 64 vehicles at once, arrays laid out [time][signal][lane].

    Args:
        graph: of the block
        own_tuning: each lane brings its own calibration; otherwise all share one
    """
    return _Printer(graph, program(graph.function)).lanes(own_tuning)


@dataclass(frozen=True)
class _Places:
    """How C reaches the arrays from inside a loop."""

    state: Callable[[int], str]
    ring: Callable[[int], str]
    sample: Callable[[int], str]
    output: Callable[[int], str]
    carried: Callable[[int], str]


class _Printer:
    """One graph's C; holds what all its functions share."""

    def __init__(self, graph: Graph, operations: Program):
        self.graph, self.program, self.name = graph, operations, prefix(graph)
        self.carried = {value: index for index, value in enumerate(operations.carried())}
        starts = [len(graph.state)]
        for _, size in graph.rings:
            starts.append(starts[-1] + size)
        self.ring_start = starts

    # -- whole files ---------------------------------------------------------------------------------------------

    def scalar(self) -> str:
        in_locals = len(self.graph.state) <= STATE_IN_LOCALS
        return "".join([PRELUDE, self._legend(), self._prepare(), self._step(), self._push(), self._scan(in_locals)])

    def lanes(self, own_tuning: bool) -> str:
        places = _Places(
            state=lambda i: f"x[{i * LANES} + l]",
            ring=lambda i: f"r{i}[l]",
            sample=lambda i: f"uk[{i * LANES} + l]",
            output=lambda i: f"yk[{i * LANES} + l]",
            carried=lambda i: f"c[{i * LANES} + l]" if own_tuning else f"c{i}",
        )
        body = self._body(places, "            ")
        rings = [
            f"        real *restrict r{i} = &x[({self.ring_start[i]} + (k0 + k) % {size}) * {LANES}];\n"
            for i, (_, size) in enumerate(self.graph.rings)
        ]
        unused = "" if rings else "    (void)k0;\n"
        # GCC vectorises no loop that loads what does not change in it.
        shared = [] if own_tuning else [f"    const real c{i} = c[{i}];\n" for i in range(len(self.carried))]
        constants = "".join(shared) + ("" if self.carried else "    (void)c;\n")
        n_sample, n_output = len(self.graph.sample), len(self.graph.output)
        signature = (
            "(long n, real *restrict x, const real *restrict u, real *restrict y, const real *restrict c, long k0)"
        )
        loop = (
            f"void {self.name}_lanes{signature} {{\n{unused}{constants}"
            "    for (long k = 0; k < n; k++) {\n"
            f"        const real *restrict uk = &u[k * {n_sample * LANES}];\n"
            f"        real *restrict yk = &y[k * {n_output * LANES}];\n"
            + "".join(rings)
            + f"#pragma GCC ivdep\n        for (int l = 0; l < {LANES}; l++) {{\n{body}        }}\n    }}\n}}\n"
        )
        declaration = f"void {self.name}_lanes{signature};\n"
        return "".join([PRELUDE, self._legend(), self._prepare(), declaration, loop, self._batch()])

    def _batch(self) -> str:
        """Lanes over arrays of their own, moved into tiles that stay in the cache and back."""
        signature = (
            f"void {self.name}_batch(long n, real *restrict x, const real *const *u, real *const *y, "
            "const real *restrict c, long k0, real *restrict tile_u, real *restrict tile_y)"
        )

        def moved(width: int, line: str) -> str:
            return (
                f"        for (long i = 0; i < m * {width}; i++)\n"
                f"            for (int l = 0; l < {LANES}; l++)\n                {line}\n"
            )

        n_sample, n_output = len(self.graph.sample), len(self.graph.output)
        return (
            f"{signature};\n{signature} {{\n"
            f"    for (long k = 0; k < n; k += {TILE_STEPS}) {{\n"
            f"        const long m = n - k < {TILE_STEPS} ? n - k : {TILE_STEPS};\n"
            + moved(n_sample, f"tile_u[i * {LANES} + l] = u[l][k * {n_sample} + i];")
            + f"        {self.name}_lanes(m, x, tile_u, tile_y, c, k0 + k);\n"
            + moved(n_output, f"y[l][k * {n_output} + i] = tile_y[i * {LANES} + l];")
            + "    }\n}\n"
        )

    # -- functions -----------------------------------------------------------------------------------------------

    def _legend(self) -> str:
        graph = self.graph
        groups = {"tuning": graph.tuning, "state": graph.state, "sample": graph.sample, "output": graph.output}
        lines = [f"/* {word:6s} {i:4d}  {name} */\n" for word, names in groups.items() for i, name in enumerate(names)]
        return "".join(lines)

    def _prepare(self) -> str:
        signature = f"void {self.name}_prepare(const real *restrict p, real *restrict c)"
        lines = []
        for index, operation in enumerate(self.program.operations):
            if index in self.program.invariant and operation.name != "constant":
                value = f"p[{operation.constant[1]}]" if operation.name == "input" else self._expression(operation, {})
                lines.append(f"    const real v{index} = {value};\n")
        stores = [f"    c[{slot}] = v{value};\n" for value, slot in self.carried.items()]
        unused = ("" if any("= p[" in line for line in lines) else "    (void)p;\n") + (
            "" if stores else "    (void)c;\n"
        )
        size = f"extern const long {self.name}_carried;\nconst long {self.name}_carried = {len(self.carried)};\n"
        return f"{size}{signature};\n{signature} {{\n{''.join(lines)}{''.join(stores)}{unused}}}\n"

    def _step(self) -> str:
        places = _Places(
            state=lambda i: f"x[{i}]",
            ring=lambda i: f"x[{self.ring_start[i]} + k % {self.graph.rings[i][1]}]",
            sample=lambda i: f"u[{i}]",
            output=lambda i: f"y[{i}]",
            carried=lambda i: f"c[{i}]",
        )
        body = self._body(places, "    ")
        unused = "" if self.graph.rings else "    (void)k;\n"
        unused += "" if self.carried else "    (void)c;\n"
        return (
            f"static inline void {self.name}_sample(real *restrict x, const real *restrict u, real *restrict y, "
            f"const real *restrict c, long k) {{\n{body}{unused}}}\n"
        )

    def _push(self) -> str:
        kind = f"{self.name}_stream"
        return (
            f"typedef struct {{ real *x; const real *u; real *y; const real *c; long k; }} {kind};\n"
            f"void {self.name}_push({kind} *s);\n"
            f"void {self.name}_push({kind} *s) {{ {self.name}_sample(s->x, s->u, s->y, s->c, s->k); s->k += 1; }}\n"
        )

    def _scan(self, in_locals: bool) -> str:
        places = _Places(
            state=lambda i: f"s{i}" if in_locals else f"x[{i}]",
            ring=lambda i: f"x[{self.ring_start[i]} + k % {self.graph.rings[i][1]}]",
            sample=lambda i: f"ui[{i}]",
            output=lambda i: f"yi[{i}]",
            carried=lambda i: f"c{i}",
        )
        count = range(len(self.graph.state)) if in_locals else range(0)
        load = [f"    const real c{i} = c[{i}];\n" for i in range(len(self.carried))] + ["    (void)c;\n"]
        load += [f"    real s{i} = x[{i}];\n" for i in count]
        body = self._body(places, "        ")
        signature = (
            f"void {self.name}_scan(long n, real *restrict x, const real *restrict u, real *restrict y, "
            "const real *restrict c, long k0)"
        )
        step = "        const long k = k0 + i;\n" if self.graph.rings else ""
        return (
            f"{signature};\n{signature} {{\n{''.join(load)}"
            "    for (long i = 0; i < n; i++) {\n"
            f"        const real *restrict ui = &u[i * {len(self.graph.sample)}];\n"
            f"        real *restrict yi = &y[i * {len(self.graph.output)}];\n{step}{body}    }}\n"
            + "".join(f"    x[{i}] = s{i};\n" for i in count)
            + "    (void)k0;\n}\n"
        )

    # -- the straight line ---------------------------------------------------------------------------------------

    def _body(self, places: _Places, indent: str) -> str:
        named = {value: f"v{value}" for value in range(len(self.program.operations))}
        named |= {value: places.carried(slot) for value, slot in self.carried.items()}
        reach = {STATE: places.state, RING: places.ring, SAMPLE: places.sample}
        notes = self._notes()
        lines = []
        for index, operation in enumerate(self.program.operations):
            if index in self.program.invariant:
                continue
            if operation.name == "input":
                group, position = operation.constant
                lines.append(f"{indent}const real v{index} = {reach[group](position)};\n")
            else:
                note = f" /* {notes[index]} */" if index in notes else ""
                lines.append(f"{indent}const real v{index} = {self._expression(operation, named)};{note}\n")
        targets = {NEXT_STATE: places.state, PUSH: places.ring, OUTPUT: places.output}
        for (group, position), value in sorted(self.program.outputs.items()):
            lines.append(f"{indent}{targets[group](position)} = {self._constant(value) or named[value]};\n")
        return "".join(lines)

    def _notes(self) -> dict[int, str]:
        names = {NEXT_STATE: self.graph.state, OUTPUT: self.graph.output}
        notes: dict[int, str] = {}
        for (group, position), value in self.program.outputs.items():
            if group in names:
                word = "next " if group == NEXT_STATE else ""
                notes[value] = "; ".join(filter(None, [notes.get(value), word + names[group][position]]))
        return notes

    def _constant(self, index: int) -> str | None:
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

    def _expression(self, operation: Operation, named: dict[int, str]) -> str:
        def text(index: int) -> str:
            return self._constant(index) or named.get(index, f"v{index}")

        def truth(index: int) -> str:
            return text(index) if self._is_logical(index) else f"({text(index)} != R(0.0) ? R(1.0) : R(0.0))"

        name, arguments = operation.name, operation.arguments
        if name in INFIX:
            return f"{text(arguments[0])} {INFIX[name]} {text(arguments[1])}"
        if name in FUSED:
            return FUSED[name].format(*map(text, arguments))
        if name in COMPARE:
            return f"{text(arguments[0])} {COMPARE[name]} {text(arguments[1])} ? R(1.0) : R(0.0)"
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
