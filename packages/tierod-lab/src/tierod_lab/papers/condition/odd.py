"""Verdicts of the whole monitor on unusual driving, wiring and logging of a fault-free vehicle."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.claims import Claim, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.errors import TierodError
from tierod.core.findings import Diagnosis
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import Vehicle
from tierod_lab.papers.condition.odd_drives import NOT_HEALTHY, odd_drives
from tierod_lab.papers.condition.runs import BEST, VARIANTS, calibrations
from tierod_lab.papers.condition.sensors import GOAL
from tierod_lab.studies.effort import Effort

MONITOR = "condition"
TEXT = (
    "A fault-free vehicle that stands, reverses, slides, is logged from the middle of a drive on, lacks a sensor from "
    "the start or loses what it reads on the way, or was wired or scaled wrongly. The whole monitor runs over each "
    "recording; it may not call any sensor or actuator faulty, not for a moment, and must say what keeps it from "
    "judging.",
)
_JUDGED = (Status.HEALTHY, Status.FAULT, Status.SUSPECT)


def items(effort: Effort) -> Iterator[Item]:
    if BEST not in VARIANTS:
        return
    vehicle = calibrations((BEST,), (1,), effort)[VARIANTS[BEST].module, 1].vehicle
    drives = odd_drives(1)
    shown = dict(list(drives.items())[::5]) if effort.quick else drives
    found = {name: said(recording, vehicle) for name, recording in shown.items()}
    yield Heading("Odd recordings of a fault-free vehicle", TEXT)
    rows = tuple((name, *row(each, shown[name])) for name, each in found.items())
    header = ("recording", "verdict", "at fault", "time declared faulty [s]", "not judged", "cause")
    yield Table("Verdicts of the monitor", header, rows)
    note = f"Of {len(found)}."
    wrong = [name for name, each in found.items() if declared_faulty(each)]
    claim = "Recordings of a fault-free vehicle, odd in one way each, in which something is declared faulty."
    yield Claim("healthy.odd", claim, GOAL, None, len(wrong), exactly(0.0), "", note, cause=f"{'; '.join(wrong)}.")
    times = {name: time_declared_faulty(each, shown[name]) for name, each in found.items()}
    longest = max(times, key=times.__getitem__)
    claim = "Time over all of them in which something is declared faulty, every sensor and actuator by itself."
    cause = f"The longest: {longest}, {times[longest]:.2f} s."
    yield Claim("healthy.odd-time", claim, GOAL, None, sum(times.values()), exactly(0.0), "s", note, cause=cause)
    unexpected = {name: each for name, each in found.items() if not as_expected(name, each)}
    claim = "Odd recordings whose final verdict or cause is not the expected one."
    cause = "; ".join(_unlike(name, each) for name, each in unexpected.items())
    yield Claim("healthy.odd-named", claim, GOAL, None, len(unexpected), exactly(0.0), "", note, cause=f"{cause}.")


def _unlike(name: str, each: Diagnosis | str) -> str:
    if isinstance(each, str):
        return f"{name}: refused, {each}"
    finding = each.findings[0]
    expected = NOT_HEALTHY.get(name, Status.HEALTHY)
    return f"{name}: {finding.status} in place of {expected}, since {finding.cause or finding.headline}"


def said(recording: Recording, vehicle: Vehicle) -> Diagnosis | str:
    """Diagnosis of a recording, or the reason for its refusal."""
    try:
        return diagnose(recording, vehicle, MONITOR)
    except TierodError as error:
        return str(error)


def declared_faulty(each: Diagnosis | str) -> tuple[str, ...]:
    """Elements that were declared faulty."""
    if isinstance(each, str):
        return ()
    return tuple(element.name for element in each.elements if element.status == Status.FAULT)


def time_declared_faulty(each: Diagnosis | str, recording: Recording) -> float:
    """Time for which elements are declared faulty, summed over all of them [s]."""
    if isinstance(each, str):
        return 0.0
    end = recording.span[1]
    episodes = [episode for element in each.elements for episode in element.episodes if not episode.candidates]
    return sum((end if episode.end is None else episode.end) - episode.start for episode in episodes)


def as_expected(name: str, each: Diagnosis | str) -> bool:
    """Whether a recording ends with the expected verdict, and with a cause unless it is healthy."""
    if isinstance(each, str):
        return False
    finding = each.findings[0]
    return finding.status is NOT_HEALTHY.get(name, Status.HEALTHY) and (
        finding.status is Status.HEALTHY or bool(finding.cause)
    )


def row(each: Diagnosis | str, recording: Recording) -> tuple[str, str, str, str, str]:
    """Table row: verdict, faulty elements, time declared faulty, elements not judged, and cause."""
    if isinstance(each, str):
        return "refused", "", "", "", each
    finding = each.findings[0]
    time = f"{time_declared_faulty(each, recording):.2f}" if declared_faulty(each) else ""
    return (
        str(finding.status),
        ", ".join(declared_faulty(each)),
        time,
        _unjudged(each),
        finding.cause or finding.headline,
    )


def _unjudged(each: Diagnosis) -> str:
    states = {status: [e.name for e in each.elements if e.status is status] for status in Status}
    words = [
        f"{'all' if len(names) == len(each.elements) else ', '.join(names)} ({status})"
        for status, names in states.items()
        if names and status not in _JUDGED
    ]
    return "; ".join(words)
