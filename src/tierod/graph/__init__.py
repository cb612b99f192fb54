"""Tracing, printing, compiling and running blocks; nothing else in tierod imports CasADi."""

from tierod.graph.derivatives import jacobian
from tierod.graph.runtime import Memory, Result, Stream, batch, scan
from tierod.graph.trace import Graph, trace

__all__ = ["Graph", "Memory", "Result", "Stream", "batch", "jacobian", "scan", "trace"]
