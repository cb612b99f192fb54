"""Tracing, printing, compiling and running blocks; nothing else in tierod imports CasADi."""

from tierod.graph.bank import KEEP, Bank, JudgeSample, Verdict
from tierod.graph.derivatives import jacobian
from tierod.graph.lanes import batch
from tierod.graph.runtime import Stream, scan
from tierod.graph.samples import Memory, Result
from tierod.graph.trace import Graph, trace

__all__ = [
    "KEEP",
    "Bank",
    "Graph",
    "JudgeSample",
    "Memory",
    "Result",
    "Stream",
    "Verdict",
    "batch",
    "jacobian",
    "scan",
    "trace",
]
