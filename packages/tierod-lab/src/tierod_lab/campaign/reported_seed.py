"""Seeds of reported drives, derived from the judged monitor, so that no monitor can be tuned on these drives."""

from __future__ import annotations

from tierod.core.block import Block
from tierod.core.graph.analysis import graph_digest


def reported_seed(*blocks: Block) -> int:
    """Seed of reported drives, from the graphs and the tuning of the judged monitor.

    A change of a threshold or an equation changes the drives; moving a file does not.
    """
    return int(graph_digest(*blocks)[:6], 16)
