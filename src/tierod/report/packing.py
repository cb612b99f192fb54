"""The series of a page, packed into it as fine as its size allows."""

from __future__ import annotations

import base64
import heapq
from collections.abc import Iterable, Mapping

from tierod.core.decimation import Packed, coarser, pack
from tierod.core.findings import Trace
from tierod.core.signals import SIGNALS

BUDGET = 900_000
"""Characters of all series of a page; with the charting library and all else it stays below 2 MB."""

LEAST = 2000
"""Bins that every series keeps: as many as a chart of the whole recording draws."""

RECORDED, COMPUTED = 12, 16
"""Bits of a value: what was recorded is noise beyond a 4000th of its range, estimates settle on a small part of it."""


def packed_series(traces: Mapping[str, Trace], names: Iterable[str], budget: int = BUDGET) -> dict[str, Packed]:
    """The named traces packed; the largest are made coarser until all fit, and what cannot be packed is left out.

    Args:
        traces: of a diagnosis
        names: of those that its charts draw
        budget: characters that they may take in the page
    """
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
    """The packed traces as the page's script takes them from JSON."""
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
    """Characters that a packed trace takes in the page."""
    return 4 * len(packed.data) // 3
