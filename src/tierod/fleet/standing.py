"""Persistent faults of every car, from its last verdicts: a repeated fault counts, a single odd drive does not."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.findings import Status

if TYPE_CHECKING:
    import pyarrow as pa

LAST = 3
"""Number of last judged drives that are considered."""

OFTEN = 2
"""Number of these with a fault from which the fault is persistent; one if there is only one drive."""

JUDGED = (Status.HEALTHY, Status.RISING, Status.SUSPECT, Status.FAULT)


@dataclass(frozen=True)
class Standing:
    """A persistent fault.

    Args:
        vehicle, monitor, judged: the car, the monitor, and the judged element
        kind: kind of fault, in words; "" if unknown
        faults, of: number of the last judged drives with the fault, and number of drives considered
        rows: rows of the drives with the fault in the findings
        action: recommended action of the last drive, in words
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
    """All persistent faults, those with most drives first.

    Args:
        findings: findings as given by `tierod.fleet.results.findings_of`, in the order of vehicle and time
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
