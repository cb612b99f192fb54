"""Faults inside the control loop: the automated driver acts on the faulty reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Recording
from tierod_lab.papers.condition.drives import Drive, sensor_tests
from tierod_lab.papers.condition.recorded import each
from tierod_lab.papers.condition.reported import vehicles
from tierod_lab.papers.condition.runs import BEST, calibrations, diagnosed
from tierod_lab.papers.condition.scoring import FOUND, DriveScore, score
from tierod_lab.papers.condition.truth import truth_of
from tierod_lab.papers.condition.vehicles import SHORT
from tierod_lab.studies.effort import Effort

TEXT = (
    "The same tests of wheel speeds, yaw rate and steering angle, but the automated driver uses what the faulty "
    "sensor reads: it brakes, accelerates and steers by it, and what the other sensors show changes with it. It is not "
    "given the value that replaces the sensor. A lost wheel makes it accelerate beyond what the tyres hold; a lost "
    "steering angle makes it steer farther and faster than in any calibration. Some of these runs end before the fault "
    "does, since the simulation diverges.",
)


class Driven(NamedTuple):
    """A drive with a fault inside the loop."""

    score: DriveScore  # score of the diagnosis
    seconds: Annotated[float, "s"]  # duration of the run
    farthest: Annotated[float, "m"]  # largest distance from the middle of the lane


def drives(effort: Effort) -> list[Drive]:
    """Tests of the sensors that the automated driver uses, on the short round."""
    found = [
        drive
        for number in vehicles(effort)
        for drive in sensor_tests(number, in_the_loop=True)
        if drive.course == SHORT and not drive.injected[0].in_recording_alone
    ]
    return found[::2] if effort.quick else found


def items(effort: Effort) -> Iterator[Item]:
    chosen = drives(effort)
    known = calibrations((BEST,), (drive.vehicle for drive in chosen), effort)
    found = each(partial(_driven, known), chosen, effort)
    yield Heading("Faults inside the loop", TEXT)
    header = (
        *("sensor", "fault", "drives", "found", "longest delay [s]", "accuracy", "worst", "wrong name"),
        *("false alarms", "ended early", "off the lane [m]"),
    )
    groups = dict.fromkeys((one.score.drive.injected[0].element, one.score.drive.injected[0].kind) for one in found)
    yield Table("Faults that the driver acts on", header, tuple(_row(*group, found) for group in groups))


def _row(element: str, kind: str, found: list[Driven]) -> tuple[str, ...]:
    def belongs(one: Driven) -> bool:
        injected = one.score.drive.injected[0]
        return (injected.element, injected.kind) == (element, kind)

    those = [one for one in found if belongs(one)]
    faults = [one.score.faults[0] for one in those]
    accuracies = [fault.accuracy for fault in faults]
    return (
        element,
        kind,
        str(len(those)),
        str(sum(fault.outcome == FOUND for fault in faults)),
        f"{max(fault.delay for fault in faults):.2f}",
        f"{np.mean(accuracies):.4f}",
        f"{min(accuracies):.4f}",
        f"{np.mean([one.score.wrong_share for one in those]):.3f}",
        str(sum(one.score.false_alarms for one in those)),
        str(sum(one.seconds < one.score.drive.seconds - 0.5 for one in those)),
        f"{max(one.farthest for one in those):.1f}",
    )


def _driven(known: Mapping[tuple[str, int], Any], drive: Drive, recording: Recording) -> Driven:
    scored = score(drive, truth_of(drive, recording), diagnosed(BEST, drive, recording, known))
    first, last = recording.span
    return Driven(scored, last - first, float(np.max(np.abs(recording["truth_lateral_offset"].values))))
