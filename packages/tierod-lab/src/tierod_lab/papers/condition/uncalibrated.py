"""The bank on uncalibrated vehicles: detection, kinds and magnitudes of faults, and false alarms."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from tierod.core.claims import Claim, at_least, between, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Recording
from tierod.vehicles import load
from tierod_lab.papers.condition import causes
from tierod_lab.papers.condition.by_bank import Known, declare
from tierod_lab.papers.condition.drives import DELAY, GAIN, NOISE, OFFSET, Drive, healthy_drives, more_kinds
from tierod_lab.papers.condition.recorded import each
from tierod_lab.papers.condition.reported import vehicles
from tierod_lab.papers.condition.scoring import FOUND, DriveScore, score
from tierod_lab.papers.condition.sensors import GOAL
from tierod_lab.papers.condition.summary import share_within, summary
from tierod_lab.papers.condition.truth import truth_of
from tierod_lab.papers.condition.vehicles import LONG, SHORT, THIRD
from tierod_lab.studies.effort import Effort

TEXT = (
    "The same three vehicles, judged with the vehicle file as it is shipped: its parameters with their standard "
    "deviations, its limits that several vehicles need together, its substitutes with errors measured without "
    "calibration. Every sensor has an offset, half too much of a gain, noise, or a delay of 0.2 s, on rounds and with "
    "noises that no other part drives.",
)
PLANS = ((SHORT, 81), (LONG, 82), (THIRD, 83))  # Course and seed of every vehicle
LEAST_SIZE = {OFFSET: 0.0, GAIN: 1.0, NOISE: 0.0, DELAY: 0.0}
"""Kind of the tested faults -> bound that their size exceeds; other kinds are not tested."""
COVERED = between(0.93, 0.97)  # Goal of the coverage of 95 % intervals of the size
UNSURE = (
    "Predictions by the vehicle file as it is shipped have errors that last; where the motion changes little, a gain "
    "or a delay then fits no better than an offset. Calibrated vehicles have smaller ones."
)
WIDE = (
    "The intervals reckon with errors of predictions that several vehicles need together, so that they are wide for "
    "most; those of a calibrated vehicle are its own."
)
HOURS = 1.0  # Fault-free driving of the three vehicles together [h]


def items(effort: Effort) -> Iterator[Item]:
    plans = [(number, *plan) for number, plan in zip(vehicles(effort), PLANS, strict=False)]
    faulty = [drive for plan in plans for drive in more_kinds(*plan) if _chosen(drive)]
    faulty = faulty[::6] if effort.quick else faulty
    fault_free = healthy_drives(0.05 if effort.quick else HOURS, tuple(number for number, *_ in plans))
    found = each(_scored, [*faulty, *fault_free], effort)
    scored, quiet = found[: len(faulty)], summary(found[len(faulty) :])
    yield Heading("Without a calibration", TEXT)
    yield _by_kind(scored)
    known = summary(scored)
    wrong, hours = "Time of the faults with a fault-free element named.", f"{quiet.healthy_hours:.2g} h"
    alarms = causes.alarms(found[len(faulty) :])
    for key, claim, measured, goal, cause in (
        ("kinds", "Kinds named rightly on uncalibrated vehicles.", known.kinds, at_least(0.95), _of_kinds(scored)),
        ("covered", "Magnitudes within their estimated interval.", known.covered, COVERED, _of_sizes(scored)),
        ("wrong", wrong, known.wrong, exactly(0.0), causes.misnamed(scored)),
        ("alarms", f"False alarms in {hours}.", float(quiet.false_alarms), exactly(0.0), alarms),
    ):
        yield Claim(f"uncalibrated.{key}", claim, GOAL, None, measured, goal, cause=cause)


def _of_kinds(scored: list[DriveScore]) -> str:
    return f"{causes.kinds(scored)} {UNSURE}"


def _of_sizes(scored: list[DriveScore]) -> str:
    sizes = [f.size_covered for each in scored for f in each.faults if f.size_covered is not None]
    spread = float(np.sqrt(COVERED.low * (1.0 - COVERED.low) / max(len(sizes), 1)))
    return f"{causes.sizes(scored)} Of {len(sizes)} sizes the share itself varies by {spread:.3f}. {WIDE}"


def _chosen(drive: Drive) -> bool:
    (fault,) = drive.injected
    return fault.size > LEAST_SIZE.get(fault.kind, math.inf)


def _by_kind(scored: list[DriveScore]) -> Table:
    rows = []
    for kind in dict.fromkeys(drive.drive.injected[0].kind for drive in scored):
        own = [drive for drive in scored if drive.drive.injected[0].kind == kind]
        faults, known = [drive.faults[0] for drive in own], summary(own)
        rows.append(
            (
                kind,
                str(len(own)),
                str(sum(fault.outcome == FOUND for fault in faults)),
                str(known.missed),
                f"{share_within(known.delays_shown, 2.0):.3f}",
                str(sum(fault.kind_right is not None for fault in faults)),
                f"{known.kinds:.3f}",
                f"{known.size_error:.3f}",
                f"{known.covered:.3f}",
            )
        )
    header = (
        *("kind", "drives", "found", "missed", "within 2 s", "kind named", "kind right", "size within"),
        "interval holds",
    )
    note = "The rest never was observable. 95 % of the sizes are within the last column but one."
    return Table("Faults of uncalibrated vehicles", header, tuple(rows), note)


@lru_cache(maxsize=1)
def _shipped() -> Known:
    return Known(load("smartload"))


def _scored(drive: Drive, recording: Recording) -> DriveScore:
    return score(drive, truth_of(drive, recording), declare(_shipped(), recording, "uncalibrated"))
