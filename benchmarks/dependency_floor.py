"""Lower bound on the time per step: the slowest cycle of dependent operations from one sample to the next.

Latencies of single operations are measured at run time; the bound of a block is the largest mean weight of a cycle in
its graph from state to next state (maximum cycle mean, Karp).
"""

from __future__ import annotations

import ctypes
import time

import numpy as np

from tierod.core.graph import Graph
from tierod.core.graph.compiler import load
from tierod.core.graph.operations import NEXT_STATE, STATE, Operation, Program, program

CHAINS = {
    "add": "x = x + a;",
    "mul": "x = x * a;",
    "div": "x = a / x;",
    "select": "x = (x < a ? b : x) + a;",
    "sqrt": "x = sqrt(x);",
    "fma": "x = fma(x, a, b);",
}
"""C statements that depend on their own result only; `select` needs an addition, which is subtracted again."""

UNROLLED, ROUNDS = 100, 20_000


def latencies() -> dict[str, float]:
    """Latency of each kind of operation on this machine [ns]."""
    source = "#include <math.h>\n"
    for name, line in CHAINS.items():
        signature = f"double chain_{name}(double x, double a, double b, long n)"
        loop = f"for (long i = 0; i < n; i++) {{ {line * UNROLLED} }}"
        source += f"{signature};\n{signature} {{ (void)b; (void)a; {loop} return x; }}\n"
    library = load(source, "latencies")
    measured = {}
    for name in CHAINS:
        chain = getattr(library, f"chain_{name}")
        chain.argtypes = [ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.c_long]
        chain.restype = ctypes.c_double
        measured[name] = min(_timed(chain) for _ in range(7))
    measured["select"] = max(measured["select"] - measured["add"], 0.0)
    return measured


def _timed(chain: ctypes._NamedFuncPointer) -> float:
    start = time.perf_counter()
    chain(1.000001, 0.9999999, 0.5, ROUNDS)
    return (time.perf_counter() - start) * 1e9 / (ROUNDS * UNROLLED)


def floor(graph: Graph) -> float:
    """Lower bound on the time per step, from the chain of dependent operations [ns]."""
    operations = program(graph.function)
    weights = _weights(operations, latencies())
    count = len(graph.state)
    paths = np.full((count, count), -np.inf)
    for index, operation in enumerate(operations.operations):
        if operation.name == "input" and operation.constant[0] == STATE:
            lengths = _longest(operations, weights, index)
            for (group, position), value in operations.outputs.items():
                if group == NEXT_STATE:
                    paths[operation.constant[1], position] = lengths[value]
    return _maximum_cycle_mean(paths)


def _weights(operations: Program, measured: dict[str, float]) -> list[float]:
    kinds = {"fms": "fma", "fnma": "fma", "sub": "add", "neg": "add", "inverse": "div", "fabs": "add", "if": "select"}
    free = ("input", "constant", "lt", "le", "eq", "ne", "and", "or", "not", "assign")

    def weight(operation: Operation) -> float:
        if operation.name in free:
            return 0.0
        return measured.get(kinds.get(operation.name, operation.name), measured["add"])

    return [weight(operation) for operation in operations.operations]


def _longest(operations: Program, weights: list[float], start: int) -> list[float]:
    lengths = [-np.inf] * len(weights)
    lengths[start] = 0.0
    for index, operation in enumerate(operations.operations):
        if operation.arguments:
            lengths[index] = max(lengths[a] for a in operation.arguments) + weights[index]
    return lengths


def _maximum_cycle_mean(paths: np.ndarray) -> float:
    count = len(paths)
    # Karp: longest walks of each length; the largest mean cycle weight follows from their differences.
    reach = np.full((count + 1, count), -np.inf)
    reach[0] = 0.0
    for k in range(1, count + 1):
        reach[k] = np.max(reach[k - 1][:, None] + paths, axis=0)
    with np.errstate(invalid="ignore"):
        means = (reach[count] - reach[:count]) / (count - np.arange(count))[:, None]
    finite = np.where(np.isfinite(reach[count]), np.nanmin(means, axis=0), -np.inf)
    return float(np.max(finite))
