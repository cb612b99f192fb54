"""Print a graph as C99: one step, a loop over a recording, a loop over several vehicles at once, and a bank."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.graph.bank import BankGraph
from tierod.core.graph.body_printer import BranchingPrinter, LinePrinter, Places
from tierod.core.graph.c_functions import prelude
from tierod.core.graph.operations import SAMPLE, Program, program
from tierod.core.graph.trace import GROUP, LANES, TILE_STEPS, Graph, Interface, prefix

STATE_IN_LOCALS = 200  # Largest number of states that `scan` keeps in local variables


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


def print_c(graph: Graph | BankGraph) -> str:
    """C99 for one vehicle: `prepare`, `push` (one step on bound buffers) and `scan` (a loop over a recording)."""
    if isinstance(graph, BankGraph):
        return _BankPrinter(graph).text()
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


ALIGNED = """\
#ifdef __GNUC__
#define TIEROD_ALIGNED __attribute__((aligned(64)))
#else
#define TIEROD_ALIGNED
#endif
"""


class _BankPrinter:
    """Prints one bank. Memory: lanes [group][number][8], numbers of the judge, feedback, delay lines of the judge."""

    def __init__(self, graph: BankGraph):
        self.graph, self.name = graph, prefix(graph)
        self.lane = LinePrinter(graph.lane, program(graph.lane.function))
        self.width, self.put_out = len(graph.lane.state), len(graph.lane.output)
        self.judge = BranchingPrinter(graph.judge, program(graph.judge.function), self._gathered)
        self.judge_start = graph.lanes_memory
        self.feedback_start = self.judge_start + len(graph.judge.state)
        self.carried = graph.groups * len(self.lane.carried) * GROUP

    def text(self) -> str:
        used = (*self.lane.program.operations, *self.judge.program.operations)
        head = prelude((operation.name for operation in used), in_lanes=True)
        parts = [head, ALIGNED, legend(self.graph), self._prepare(), self._lanes(), self._judge(), self._adopt()]
        return "".join([*parts, self._sample(), self._scan(), push(self.name)])

    def _prepare(self) -> str:
        name, graph, tuned = self.name, self.graph, len(self.graph.lane.tuning)
        size = self.carried + len(self.judge.carried)
        arguments = "const real *restrict p, real *restrict c"
        return (
            f"static void {name}_prepare_lane({arguments}) {{\n{self.lane.prepared(GROUP)}}}\n"
            f"static void {name}_prepare_judge({arguments}) {{\n{self.judge.prepared(1)}}}\n"
            f"extern const long {name}_carried;\nconst long {name}_carried = {size};\n"
            f"void {name}_prepare({arguments});\nvoid {name}_prepare({arguments}) {{\n"
            f"    for (int i = 0; i < {graph.groups * GROUP}; i++)\n"
            f"        {name}_prepare_lane(&p[(i < {graph.count} ? i : 0) * {tuned}], "
            f"&c[i / {GROUP} * {len(self.lane.carried) * GROUP} + i % {GROUP}]);\n"
            f"    {name}_prepare_judge(&p[{graph.count * tuned}], &c[{self.carried}]);\n}}\n"
        )

    def _lanes(self) -> str:
        inputs = sorted(
            operation.constant[1]
            for operation in self.lane.program.operations
            if operation.name == "input" and operation.constant[0] == SAMPLE
        )
        taken = len(self.graph.sample)
        # GCC does not vectorise a loop that loads a loop-invariant value.
        shared = [f"    const real u{i} = {f'u[{i}]' if i < taken else f'f[{i - taken}]'};\n" for i in inputs]
        body = self.lane.body(self._places(), "        ")
        unused = "".join(f"    (void){name};\n" for name in "xufoc")
        return (
            f"static void {self.name}_lanes(real *restrict x, const real *restrict u, const real *restrict f, "
            f"real *restrict o, const real *restrict c) {{\n{''.join(shared)}"
            f"#pragma GCC ivdep\n    for (int l = 0; l < {GROUP}; l++) {{\n{body}    }}\n{unused}}}\n"
        )

    def _places(self) -> Places:
        def refused(_: int) -> str:
            raise AssertionError("lanes have no delay lines")

        return Places(
            state=lambda i: f"x[{i * GROUP} + l]",
            ring=refused,
            sample=lambda i: f"u{i}",
            output=lambda i: f"o[{i * GROUP} + l]",
            carried=lambda i: f"c[{i * GROUP} + l]",
        )

    def _judge(self) -> str:
        """One step of the judge; `o` holds the outputs of the lanes, `a` receives the adopted lanes."""
        ring_start = self.feedback_start + len(self.graph.feedback) - len(self.graph.judge.state)
        places = Places(
            state=lambda i: f"x[{self.judge_start + i}]",
            ring=lambda i: f"x[{ring_start + self.judge.ring_start[i]} + k % {self.graph.rings[i][1]}]",
            sample=self._seen,
            output=self._said,
            carried=lambda i: f"c[{i}]",
        )
        unused = "".join(f"    (void){name};\n" for name in ("x", "u", "o", "y", "c", "k"))
        return (
            f"static void {self.name}_judge(real *restrict x, const real *restrict u, const real *restrict o, "
            f"real *restrict y, real *restrict a, const real *restrict c, long k) {{\n"
            f"{self.judge.body(places, '    ')}{unused}}}\n"
        )

    def _seen(self, position: int) -> str:
        inputs = len(self.graph.sample)
        if position < inputs:
            return f"u[{position}]"
        lane, output = divmod(position - inputs, self.put_out)
        return f"o[{(lane // GROUP * self.put_out + output) * GROUP + lane % GROUP}]"

    def _gathered(self, positions: Sequence[int], lane: str) -> str | None:
        """C of one output of a lane by the lane's number; None unless it is this output of lanes 0, 1, ... in order."""
        first = positions[0] - len(self.graph.sample)
        if not 0 <= first < self.put_out or list(positions) != [
            positions[0] + self.put_out * number for number in range(len(positions))
        ]:
            return None
        return f"o[({lane} / {GROUP} * {self.put_out} + {first}) * {GROUP} + {lane} % {GROUP}]"

    def _said(self, position: int) -> str:
        given = len(self.graph.output)
        if position < given:
            return f"y[{position}]"
        adopted = position - given
        if adopted < self.graph.count:
            return f"a[{adopted}]"
        return f"x[{self.feedback_start + adopted - self.graph.count}]"

    def _adopt(self) -> str:
        # The states are copied first: lanes may exchange theirs.
        count, block = self.graph.count, self.width * GROUP
        if not block:
            return f"static void {self.name}_adopt(real *restrict x, const real *restrict a) {{ (void)x; (void)a; }}\n"
        adopts = f"a[i] >= R(0.0) && a[i] < R({count}.0)"
        column = f"j / {GROUP} * {block} + j % {GROUP}"
        return (
            f"static void {self.name}_adopt(real *restrict x, const real *restrict a) {{\n"
            f"    real old[{count * self.width}];\n    int kept[{count}] = {{0}}, n = 0;\n"
            f"    for (int i = 0; i < {count}; i++) {{\n        if (!({adopts}) || kept[(int)a[i]])\n"
            f"            continue;\n        const int j = (int)a[i];\n        const real *from = &x[{column}];\n"
            f"        for (int s = 0; s < {self.width}; s++)\n"
            f"            old[n * {self.width} + s] = from[s * {GROUP}];\n        kept[j] = ++n;\n    }}\n"
            f"    for (int i = 0; n && i < {count}; i++) {{\n        if (!({adopts}))\n            continue;\n"
            f"        const real *from = &old[(kept[(int)a[i]] - 1) * {self.width}];\n"
            f"        real *to = &x[i / {GROUP} * {block} + i % {GROUP}];\n"
            f"        for (int s = 0; s < {self.width}; s++)\n            to[s * {GROUP}] = from[s];\n    }}\n}}\n"
        )

    def _sample(self) -> str:
        graph, name = self.graph, self.name
        return (
            f"static void {name}_sample(real *restrict x, const real *restrict u, real *restrict y, "
            f"const real *restrict c, long k) {{\n"
            f"    TIEROD_ALIGNED real o[{max(graph.groups * self.put_out * GROUP, 1)}];\n    real a[{graph.count}];\n"
            f"    for (int g = 0; g < {graph.groups}; g++)\n"
            f"        {name}_lanes(&x[g * {self.width * GROUP}], u, &x[{self.feedback_start}], "
            f"&o[g * {self.put_out * GROUP}], &c[g * {len(self.lane.carried) * GROUP}]);\n"
            f"    {name}_judge(x, u, o, y, a, &c[{self.carried}], k);\n    {name}_adopt(x, a);\n}}\n"
        )

    def _scan(self) -> str:
        signature = (
            f"void {self.name}_scan(long n, real *restrict x, const real *restrict u, real *restrict y, "
            "const real *restrict c, long k0)"
        )
        return (
            f"{signature};\n{signature} {{\n    for (long i = 0; i < n; i++)\n"
            f"        {self.name}_sample(x, &u[i * {len(self.graph.sample)}], &y[i * {len(self.graph.output)}], c, "
            "k0 + i);\n}\n"
        )
