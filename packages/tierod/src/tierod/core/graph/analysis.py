"""Cost and digest of a step of a block, read from its graph."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from tierod.core.block import Block, tuning
from tierod.core.graph.bank import BankGraph
from tierod.core.graph.operations import LOGICAL, program
from tierod.core.graph.trace import Graph, trace

FUSED = ("fma", "fms", "fnma")  # Operations that are a multiplication and an addition in one

TRIGONOMETRIC = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")
FUNCTIONS = ("sqrt", "hypot", "exp", "expm1", "log", "log1p", "pow", "sinh", "cosh", "tanh")
OTHER_DECISIONS = ("if", "select", "fabs", "sign", "floor", "ceil")


@dataclass(frozen=True)
class OperationCount:
    """Number of operations of one step; those on constants and tuning alone are computed beforehand and not counted."""

    # multiplications, additions: subtractions are additions; a fused multiply-add counts once as each
    multiplications: int
    additions: int
    divisions: int
    trigonometric: int  # trigonometric functions and their inverses
    functions: int  # roots, powers, exponentials, logarithms, hyperbolic functions
    decisions: int  # comparisons, logic, selections, absolute values, signs and roundings
    states: int  # numbers that are stored from one step to the next, delay lines included


def operation_count(block: Block) -> OperationCount:
    """The operations of one step of a block, equal ones counted once."""
    graph = trace(block)
    counts = _counts(graph)
    fused = sum(counts[name] for name in FUSED)

    def total(*names: str) -> int:
        return sum(counts[name] for name in names)

    return OperationCount(
        multiplications=counts["mul"] + fused,
        additions=total("add", "sub") + fused,
        divisions=total("div", "inverse"),
        trigonometric=total(*TRIGONOMETRIC),
        functions=total(*FUNCTIONS),
        decisions=total(*LOGICAL, *OTHER_DECISIONS),
        states=graph.memory,
    )


def _counts(graph: Graph | BankGraph) -> Counter[str]:
    """Number of operations of each kind that one step needs; every lane of a bank counts."""
    if not isinstance(graph, BankGraph):
        return program(graph.function).counts()
    total = program(graph.judge.function).counts()
    for name, count in program(graph.lane.function).counts().items():
        total[name] += graph.count * count
    return total


def graph_digest(*blocks: Block) -> str:
    """The SHA-256 of the operations and of the floats of blocks, in hexadecimal.

    A change of a threshold or of an equation changes it; a renamed or moved file, class or comment does not.
    """
    digest = hashlib.sha256()
    for block in blocks:
        for part in (*_of_graph(trace(block)), *(value.hex() for _, value in tuning(block))):
            digest.update(part.encode() + b"\0")
    return digest.hexdigest()


def _of_graph(graph: Graph | BankGraph) -> Iterator[str]:
    if isinstance(graph, BankGraph):
        yield f"bank {graph.count}"
        yield from _of_graph(graph.lane)
        yield from _of_graph(graph.judge)
        return
    import casadi

    yield from (f"{size}" for _, size in graph.rings)
    function: Any = graph.function
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        constant = float(function.instruction_constant(k)).hex() if operation == casadi.OP_CONST else ""
        yield f"{operation} {function.instruction_input(k)} {function.instruction_output(k)} {constant}"
