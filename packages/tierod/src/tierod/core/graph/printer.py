"""Print a graph as C99: one step, a loop over a recording, and a loop over several vehicles at once."""

from __future__ import annotations

import re

from tierod.core.graph.branching_printer import BranchingPrinter
from tierod.core.graph.c_functions import prelude
from tierod.core.graph.compiler import vector_width
from tierod.core.graph.line_printer import LinePrinter, Places
from tierod.core.graph.operations import Program, program
from tierod.core.graph.trace import Graph, Interface

LANES = vector_width()
"""Number of vehicles that are stepped together: one vector register holds a number of each."""
TILE_STEPS = 64
"""Number of samples of a tile: inputs and outputs of all vehicles then stay in the cache of a core."""
STATE_IN_LOCALS = 200
"""Largest number of states that `scan` keeps in local variables."""


def prefix(graph: Interface) -> str:
    """Prefix of every name that the graph's C exports."""
    return f"tierod_{re.sub(r'[^0-9A-Za-z]+', '_', graph.name).lower()}"


def legend(graph: Interface) -> str:
    """C comments that list name and position of every input and output."""
    groups = {"tuning": graph.tuning, "state": graph.state, "sample": graph.sample, "output": graph.output}
    return "".join(
        f"/* {word:6s} {i:4d}  {name} */\n" for word, names in groups.items() for i, name in enumerate(names)
    )


def push(name: str) -> str:
    """C of one step on bound buffers, for a block with a function `<name>_scan`.

    A step is a scan of one sample, so that the compiler sees the equations once: they are most of its work.
    """
    kind = f"{name}_stream"
    return (
        f"typedef struct {{ real *x; const real *u; real *y; const real *c; long k; }} {kind};\n"
        f"void {name}_push({kind} *s);\n"
        f"void {name}_push({kind} *s) {{ {name}_scan(1, s->x, s->u, s->y, s->c, s->k); s->k += 1; }}\n"
    )


def print_scalar(graph: Graph) -> str:
    """C99 for one vehicle: `prepare`, `push` (one step on bound buffers) and `scan` (a loop over a recording)."""
    return _ScalarPrinter(graph, program(graph.function)).text()


def print_lanes(graph: Graph, own_tuning: bool) -> str:
    """C99 for `LANES` vehicles at once, arrays laid out `[time][signal][lane]`.

    Args:
        own_tuning: whether each lane has its own calibration; otherwise all share one
    """
    return _LanesPrinter(graph, program(graph.function)).text(own_tuning)


def _prepare(printer: LinePrinter) -> str:
    name = prefix(printer.graph)
    signature = f"void {name}_prepare(const real *restrict p, real *restrict c)"
    size = f"extern const long {name}_carried;\nconst long {name}_carried = {len(printer.carried)};\n"
    return f"{size}{signature};\n{signature} {{\n{printer.prepared(1)}}}\n"


def _head(printer: LinePrinter, in_lanes: bool = False) -> str:
    return prelude((operation.name for operation in printer.program.operations), in_lanes) + legend(printer.graph)


class _ScalarPrinter(BranchingPrinter):
    """Printer for one vehicle: nothing has to vectorise, so operations of a branch that is not taken are skipped."""

    def __init__(self, graph: Graph, operations: Program):
        super().__init__(graph, operations)
        self.name = prefix(graph)

    def text(self) -> str:
        in_locals = len(self.graph.state) <= STATE_IN_LOCALS
        return "".join([_head(self), _prepare(self), self._scan(in_locals), push(self.name)])

    def _scan(self, in_locals: bool) -> str:
        places = Places(
            state=lambda i: f"s{i}" if in_locals else f"x[{i}]",
            ring=lambda i: f"x[{self.ring_start[i]} + k % {self.graph.rings[i][1]}]",
            sample=lambda i: f"ui[{i}]",
            output=lambda i: f"yi[{i}]",
            carried=lambda i: f"c{i}",
        )
        count = range(len(self.graph.state)) if in_locals else range(0)
        load = [f"    const real c{i} = c[{i}];\n" for i in range(len(self.carried))] + ["    (void)c;\n"]
        load += [f"    real s{i} = x[{i}];\n" for i in count]
        body = self.body(places, "        ")
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


class _LanesPrinter(LinePrinter):
    """Printer for several vehicles at once: every decision is a selection, so that the loop over them vectorises."""

    def __init__(self, graph: Graph, operations: Program):
        super().__init__(graph, operations)
        self.name = prefix(graph)

    def text(self, own_tuning: bool) -> str:
        places = Places(
            state=lambda i: f"x[{i * LANES} + l]",
            ring=lambda i: f"r{i}[l]",
            sample=lambda i: f"uk[{i * LANES} + l]",
            output=lambda i: f"yk[{i * LANES} + l]",
            carried=lambda i: f"c[{i * LANES} + l]" if own_tuning else f"c{i}",
        )
        body = self.body(places, "            ")
        rings = [
            f"        real *restrict r{i} = &x[({self.ring_start[i]} + (k0 + k) % {size}) * {LANES}];\n"
            for i, (_, size) in enumerate(self.graph.rings)
        ]
        unused = "" if rings else "    (void)k0;\n"
        # GCC does not vectorise a loop that loads a loop-invariant value.
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
        return "".join([_head(self, in_lanes=True), _prepare(self), declaration, loop, self._batch()])

    def _batch(self) -> str:
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
