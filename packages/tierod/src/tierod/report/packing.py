"""Packed series of a page, at the finest resolution that its size permits."""

from __future__ import annotations

import base64
import heapq
from collections.abc import Iterable, Mapping

from tierod.core.decimation import Packed, coarser, pack
from tierod.core.findings import Trace
from tierod.core.signals import SIGNALS

BUDGET = 900_000
"""Characters available for all series of a page, which keeps the page with its charting library below 2 MB."""

LEAST = 2000
"""Smallest number of bins of a series, as many as a chart of the whole recording draws."""

RECORDED, COMPUTED = 12, 16
"""Bits per value: recorded signals are noise below 1/4000 of their range, estimates settle within a small part."""


def packed_series(traces: Mapping[str, Trace], names: Iterable[str], budget: int = BUDGET) -> dict[str, Packed]:
    """Pack the named traces; the largest are coarsened until all fit, and traces that cannot be packed are left out."""
    packed = {name: each for name in names if (each := _pack(traces[name], 1)) is not None}
    steps = dict.fromkeys(packed, 1)
    largest = [(-_size(each), name) for name, each in packed.items() if each.count > LEAST]
    heapq.heapify(largest)
    total = sum(map(_size, packed.values()))
    while total > budget and largest:
        size, name = heapq.heappop(largest)
        steps[name] *= 2
        each = packed[name] = _pack(traces[name], steps[name]) or packed[name]
        total += size + _size(each)
        if each.count > LEAST:
            heapq.heappush(largest, (-_size(each), name))
    return packed


def heads(packed: Mapping[str, Packed]) -> dict[str, dict[str, object]]:
    """Packed traces as JSON content for the script of the page."""
    return {
        name: {
            "start": each.start,
            "width": each.width,
            "count": each.count,
            "lowest": each.lowest,
            "step": each.step,
            "data": base64.b64encode(each.data).decode("ascii"),
        }
        for name, each in packed.items()
    }


def _pack(trace: Trace, step: int) -> Packed | None:
    return pack(coarser(trace, step), RECORDED if trace.name in SIGNALS else COMPUTED)


def _size(packed: Packed) -> int:
    return 4 * len(packed.data) // 3
