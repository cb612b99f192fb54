"""The bank of filters on CommonRoad's multi-body car, with faults of its motion sensors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tierod.core.claims import Claim, at_least, exactly
from tierod.core.content import Heading, Item, Table
from tierod_lab.papers.condition import real_cars, tables
from tierod_lab.papers.condition.drives import DRIFT, OFFSETS, STUCK, Injected
from tierod_lab.papers.condition.real_cars import Judged, judged
from tierod_lab.papers.condition.scoring import DriveScore
from tierod_lab.papers.condition.summary import isolated, summary
from tierod_lab.papers.foreign.multibody_car import MultibodyCar
from tierod_lab.papers.foreign.reported import CAR, SENSORS
from tierod_lab.studies.effort import Effort

GOAL = "goal of tierod, as on real cars"
LEARNING, STARTS, LASTING = 30.0, (33.0, 42.0, 51.0), 6.0
"""Learning time at the start of the drive, instants of the injected faults, and duration of a fault [s].

They are those of the highway recording in the study of real cars.
"""
TEXT = (
    "CommonRoad's multi-body car turns by its own Magic Formula tyres, springs and load transfer. Its vehicle file has "
    "its masses and lengths, and a stiffness from its tyres. The bank keeps the limits that were found on the RAV4. "
    "Faults are those of the study of real cars, and besides a reading that stands still and one that drifts by a "
    "tenth of the offset a second, put into the recording alone. The seed follows from the judged monitor.",
)


CAUSE = (
    "Missed by kind: {missed}. The bank keeps the limits that were found on the RAV4's minutes, and the faults last "
    "six seconds: a drift ends at six tenths of the offset that is found at once, and a reading that stands still "
    "shows only as far as the car has turned away from it. Limits from this car's own fault-free drives (identify "
    "thresholds) would mend a part."
)


def faults_of(sensor: str, start: float, lasting: float) -> tuple[Injected, ...]:
    """The faults of a sensor: those of the study of real cars, a stuck reading and a drift.

    Args:
        start: start of the faults on the clock of the recording [s]
        lasting: duration of the faults; an outlier lasts a second [s]
    """
    end = start + lasting
    return (
        *real_cars.faults_of(sensor, start, lasting),
        Injected(sensor, STUCK, start=start, end=end),
        Injected(sensor, DRIFT, 0.1 * OFFSETS[sensor], start, end),
    )


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Sensors of CommonRoad's car", TEXT)
    car = MultibodyCar(
        "CommonRoad's car", ("", ""), "rav4", None, LEARNING, STARTS, LASTING, seed=SENSORS.of(CAR, 1)[0]
    )
    recording = car.recording()
    if recording is None:
        yield Heading("Not judged", ("The package commonroad-vehicle-models is not installed.",))
        return
    yield from shown(judged(car, recording, quick=effort.quick, kinds=faults_of))


def by_kind(found: list[DriveScore]) -> Mapping[str, list[DriveScore]]:
    """Scores by kind of fault, the kind with the most missed faults first."""
    kinds: dict[str, list[DriveScore]] = {}
    for each in found:
        kinds.setdefault(each.drive.injected[0].kind, []).append(each)
    return dict(sorted(kinds.items(), key=lambda pair: (-summary(pair[1]).missed, isolated(pair[1]).right)))


def shown(of: Judged) -> Iterator[Item]:
    """Tables and claims of the judged recording.

    Args:
        of: scores of the fault-free drive and of every fault
    """
    rows = []
    for kind, found in by_kind(of.found).items():
        known, isolation = summary(found), isolated(found)
        latest = f"{max(known.delays_shown):.2f}" if len(known.delays_shown) else "–"
        cells = (len(found), known.missed, known.not_testable, f"{isolation.right:.3f}", f"{isolation.ambiguous:.3f}")
        rows.append((kind, *map(str, cells), f"{known.wrong:.4f}", latest))
    header = ("kind", "faults", "missed", "never observable", "named rightly", "ambiguous", "time wrong", "longest [s]")
    yield Table("Faults of the sensors of CommonRoad's car, by kind", header, tuple(rows), "Worst kind first.")
    yield tables.named("What went by which name: CommonRoad's car", of.found)
    known, isolation = summary(of.found), isolated(of.found)
    kinds = ", ".join(
        f"{kind} {summary(found).missed} of {len(found)}"
        for kind, found in by_kind(of.found).items()
        if summary(found).missed
    )
    for key, claim, measured, goal in (
        ("missed", "Faults missed on CommonRoad's car", float(known.missed), exactly(0.0)),
        ("named", "Faults named and nothing else on CommonRoad's car", isolation.right, at_least(0.9)),
        ("wrong", "Time of the faults with a fault-free sensor named on CommonRoad's car", known.wrong, exactly(0.0)),
        ("alarms", "False alarms where nothing was injected on CommonRoad's car", of.quiet.false_alarms, exactly(0.0)),
    ):
        cause = CAUSE.format(missed=kinds) if key in ("missed", "named") else ""
        yield Claim(f"cars.multibody-{key}", f"{claim}.", GOAL, None, float(measured), goal, cause=cause)
