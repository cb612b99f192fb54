"""Digest of a block's behaviour: of its traced graph and its tuning, independent of its source text and its place."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import Any

from tierod.core.block import Block, tuning
from tierod.core.graph.bank_graph import BankGraph
from tierod.core.graph.trace import Graph, trace


def graph_digest(*blocks: Block) -> str:
    """The SHA-256 of the operations and of the floats of blocks, in hexadecimal.

    A change of a threshold or of an equation changes it; a renamed or moved file, class or comment does not.

    Raises:
        TraceError: a block cannot be traced
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
