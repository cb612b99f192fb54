"""The bank of filters on CommonRoad's multi-body car, with faults of its motion sensors."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.content import Heading, Item
from tierod_lab.papers.condition import real_cars
from tierod_lab.papers.condition.drives import DRIFT, OFFSETS, STUCK, Injected
from tierod_lab.papers.foreign.multibody_car import MultibodyCar
from tierod_lab.papers.foreign.reported import CAR, SENSORS
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.engine import Measure, Overview
from tierod_lab.studies.metrics import Frame

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
    "The bank keeps the limits that were found on the RAV4's minutes, and the faults last six seconds: a drift ends at "
    "six tenths of the offset that is found at once, and a reading that stands still shows only as far as the car has "
    "turned away from it. Limits from this car's own fault-free drives (identify thresholds) would mend a part."
)
TABLE = Overview(
    "cars",
    "Faults of the sensors of CommonRoad's car, by kind",
    ("kind",),
    {
        "faults": "count",
        "missed": "sum missed",
        "named rightly": "mean right",
        "time wrong": "mean wrong",
        "longest delay (s)": "max delay_shown",
    },
    {"missed": ">= 0"},
)
OBSERVABLE = {"isolated": ["right", "partial", "wrong", "ambiguous", "nothing"]}
MEASURES = tuple(
    Measure(
        f"cars.multibody-{key}",
        f"{claim} on CommonRoad's car.",
        "cars",
        metric,
        goal,
        "goal of tierod, as on real cars",
        where,
        cause=CAUSE if key in ("missed", "named") else "",
    )
    for key, claim, metric, goal, where in (
        ("missed", "Faults missed", "sum missed", "= 0", {"missed": ">= 0"}),
        ("named", "Faults named and nothing else", "mean right", ">= 0.9", OBSERVABLE),
        ("wrong", "Time of the faults with a fault-free sensor named", "mean wrong", "= 0", {"missed": ">= 0"}),
        ("alarms", "False alarms, with and without a fault,", "sum alarms", "= 0", {}),
    )
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
    seed = SENSORS.of(CAR, 1)[0]
    car = MultibodyCar("CommonRoad's car", ("", ""), "rav4", None, LEARNING, STARTS, LASTING, seed=seed)
    frame = Frame.of("cars", real_cars.judged(car, effort.quick, faults_of))
    if len(frame):
        yield TABLE.of(frame)
    for each in MEASURES:
        yield each.of(frame, "The package commonroad-vehicle-models is not installed.")
