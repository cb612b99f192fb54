"""Print a bank as C99: its lanes, eight at a time in loops that vectorise, its judge, and the adoption of states."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.graph.bank_graph import BankGraph
from tierod.core.graph.branching_printer import BranchingPrinter
from tierod.core.graph.c_functions import prelude
from tierod.core.graph.line_printer import LinePrinter, Places
from tierod.core.graph.memory_layout import GROUP
from tierod.core.graph.operations import SAMPLE, program
from tierod.core.graph.printer import legend, prefix, push

ALIGNED = """\
#ifdef __GNUC__
#define TIEROD_ALIGNED __attribute__((aligned(64)))
#else
#define TIEROD_ALIGNED
#endif
"""


def print_bank(graph: BankGraph) -> str:
    """C99 for a bank: `prepare`, `push` (one step on bound buffers) and `scan` (a loop over a recording).

    All functions take the same arguments as those of a single block.
    """
    return _BankPrinter(graph).text()


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

    # -- lanes ---------------------------------------------------------------------------------------------------

    def _lanes(self) -> str:
        """One step of a group of eight lanes: a loop over them."""
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

    # -- judge ---------------------------------------------------------------------------------------------------

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

    # -- the whole -----------------------------------------------------------------------------------------------

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
