"""Tracing, printing, compiling and running blocks; nothing else in tierod imports CasADi."""

from tierod.core.graph.bank import KEEP, Bank, JudgeSample, Verdict
from tierod.core.graph.runtime import Memory, Result, Scanner, Stream, batch, scan
from tierod.core.graph.trace import Graph, jacobian, trace

__all__ = [
    "KEEP",
    "Bank",
    "Graph",
    "JudgeSample",
    "Memory",
    "Result",
    "Scanner",
    "Stream",
    "Verdict",
    "batch",
    "jacobian",
    "scan",
    "trace",
]
