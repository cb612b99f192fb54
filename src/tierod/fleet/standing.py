"""Standing of every car by its last verdicts: what keeps coming back counts, one odd drive does not."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.findings import Status

if TYPE_CHECKING:
    import pyarrow as pa

LAST = 3
"""Judged drives that are looked back at."""

OFTEN = 2
"""Of them with a fault, from which on it stands; one where there is only one."""

JUDGED = (Status.HEALTHY, Status.RISING, Status.SUSPECT, Status.FAULT)


@dataclass(frozen=True)
class Standing:
    """A fault that stands.

    Args:
        vehicle, monitor, judged: whose, who judged, and the thing
        kind: of the fault, in words; "" where it is not known
        faults, of: how many of the last judged drives had it, and how many there are
        rows: of these drives in the findings
        action: of the last one, in words
    """

    vehicle: str
    monitor: str
    judged: str
    kind: str
    faults: int
    of: int
    rows: tuple[int, ...]
    action: str


def standings(findings: pa.Table) -> list[Standing]:
    """Every fault that stands, those of most drives first.

    Args:
        findings: as `tierod.fleet.results.findings_of` gives them, in the order of vehicle and time
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    judged = pc.is_in(findings["status"], pa.array([str(each) for each in JUDGED]))
    rows = np.flatnonzero(judged.to_numpy())
    if not len(rows):
        return []
    keys = findings.select(["vehicle", "monitor", "judged"]).take(rows)
    codes = [
        keys[name].combine_chunks().fill_null("").dictionary_encode().indices.to_numpy() for name in keys.schema.names
    ]
    faulty = pc.equal(findings["status"], str(Status.FAULT)).to_numpy()[rows]
    order = np.lexsort((rows, *codes[::-1]))
    sorted_codes = np.stack([code[order] for code in codes])
    change = np.flatnonzero(np.any(np.diff(sorted_codes, axis=1) != 0, axis=0)) + 1
    bounds = np.concatenate(([0], change, [len(order)]))
    found = []
    for first, last in pairwise(bounds):
        recent = order[max(first, last - LAST) : last]
        with_fault = recent[faulty[recent]]
        if len(with_fault) >= min(OFTEN, len(recent)):
            found.append(_standing(findings, rows[with_fault], len(recent)))
    return sorted(found, key=lambda each: (-each.faults, each.vehicle))


def _standing(findings: pa.Table, rows: np.ndarray, of: int) -> Standing:
    last = int(rows[-1])
    names = ("vehicle", "monitor", "judged", "kind", "action")
    text = {name: findings[name][last].as_py() or "" for name in names}
    drives = tuple(map(int, rows))
    return Standing(
        text["vehicle"], text["monitor"], text["judged"], text["kind"], len(rows), of, drives, text["action"]
    )
