"""Seeds of drives that are reported: they follow from the monitor that is judged, so that nothing is tuned on them."""

from __future__ import annotations

from tierod.core.block import Block
from tierod.core.graph.graph_digest import graph_digest


def reported_seed(*blocks: Block) -> int:
    """Seed of reported drives, from the graphs and the tuning of the judged monitor.

    Whoever changes a threshold or an equation draws new drives, and whoever moves a file draws the same ones.

    Args:
        blocks: of the monitor, with the parameters of the vehicle file as it is shipped

    Returns:
        from 0 to 16 777 215
    """
    return int(graph_digest(*blocks)[:6], 16)
