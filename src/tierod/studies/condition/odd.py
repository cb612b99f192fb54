"""Odd driving, wiring and logging of a sound vehicle: what the whole monitor says, and that it accuses nobody."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.errors import TierodError
from tierod.findings import Diagnosis, Status
from tierod.monitors.run import diagnose
from tierod.recording import Recording
from tierod.studies.claims import Claim, exactly
from tierod.studies.condition.odd_drives import all_lost, odd_drives
from tierod.studies.condition.runs import BEST, VARIANTS, calibrations
from tierod.studies.condition.sensors import GOAL
from tierod.studies.content import Heading, Item, Table
from tierod.studies.registry import Effort
from tierod.vehicles import Vehicle

MONITOR = "condition"
TEXT = (
    "A sound vehicle that stands, reverses, slides, is logged from the middle of a drive on, lacks a sensor, or was "
    "wired or scaled wrongly. The whole monitor runs over each recording; it may not call any sensor or actuator "
    "faulty.",
)
_JUDGED = (Status.HEALTHY, Status.FAULT, Status.SUSPECT)


def items(effort: Effort) -> Iterator[Item]:
    """One row for every odd recording."""
    if BEST not in VARIANTS:
        return
    vehicle = calibrations((BEST,), (1,), effort)[VARIANTS[BEST].module, 1].vehicle
    drives = odd_drives(1)
    shown = dict(list(drives.items())[::4]) if effort.quick else drives
    found = {name: said(recording, vehicle) for name, recording in shown.items()}
    lost = said(all_lost(1), vehicle)
    yield Heading("Odd recordings of a sound vehicle", TEXT)
    rows = tuple((name, *row(each)) for name, each in {**found, "all six sensors lost at 20 s": lost}.items())
    yield Table("What the monitor says", ("recording", "verdict", "at fault", "not judged", "cause"), rows)
    wrong = sum(bool(accused(each)) for each in found.values())
    claim = "Recordings of a sound vehicle, odd in one way each, in which something is called faulty."
    yield Claim("healthy.odd", claim, GOAL, None, wrong, exactly(0.0), "", f"Of {len(found)}.")


def said(recording: Recording, vehicle: Vehicle) -> Diagnosis | str:
    """What the monitor says of a recording, or why it cannot."""
    try:
        return diagnose(recording, vehicle, MONITOR)
    except TierodError as error:
        return str(error)


def accused(each: Diagnosis | str) -> tuple[str, ...]:
    """What is called faulty."""
    if isinstance(each, str):
        return ()
    return tuple(element.name for element in each.elements if element.status == Status.FAULT)


def row(each: Diagnosis | str) -> tuple[str, str, str, str]:
    """Verdict, what is at fault, what is not judged, and why."""
    if isinstance(each, str):
        return "refused", "", "", each
    states: Mapping[str, Status] = {element.name: element.status for element in each.elements}
    unjudged = [f"{name} ({status})" for name, status in states.items() if status not in _JUDGED]
    finding = each.findings[0]
    return str(finding.status), ", ".join(accused(each)), ", ".join(unjudged), finding.cause or finding.headline
