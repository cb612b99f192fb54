"""The study of the motor's angle: observers, motors unlike the vehicle file, sensor faults, real drives."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tierod.core.content import Item
from tierod_lab.papers.motor_angle import identification_datasets as identification
from tierod_lab.papers.motor_angle import monitor_datasets as monitor
from tierod_lab.papers.motor_angle import observer_datasets as observers
from tierod_lab.papers.motor_angle import robustness_datasets as robustness
from tierod_lab.papers.motor_angle.charts import charts
from tierod_lab.papers.motor_angle.fault_trials import Trial
from tierod_lab.papers.motor_angle.monitor_datasets import AngleCase, Course
from tierod_lab.papers.motor_angle.reported import SEEDS
from tierod_lab.papers.motor_angle.robustness_datasets import Case
from tierod_lab.papers.motor_angle.sensor_faults import STUCK, SWAPPED_PHASES, SWAPPED_SINE
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame

RATIOS = (1.0, 1.1, 1.5, 2.0, 3.0)  # Saliency ratios: q-axis over d-axis inductance
SPEEDS = (15.0, 30.0, 60.0, 100.0)  # Speeds of the strokes [rad/s]; below 10 rad/s nothing is compared


def seeds(part: str, quick: int, usual: int, effort: Effort, thorough: int = 0) -> range:
    """Seeds of a part, as many as the effort allows."""
    return SEEDS.of(part, quick if effort.quick else thorough if effort.thorough and thorough else usual)


def seconds(effort: Effort) -> float:
    """Duration of a drive of the bench [s]."""
    return 6.0 if effort.quick else 20.0


def _accuracy(effort: Effort) -> list[Case]:
    long = seconds(effort)
    temperatures = (-40.0, 20.0, 120.0) if effort.quick else (-40.0, -20.0, 0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0)
    few = seeds("temperature", 1, 3, effort)
    return [
        *(Case("drawn", seed, long) for seed in seeds("motors that differ", 3, 20, effort)),
        *(
            Case(kind, seed, long)
            for kind in ("warm", "warm, not learnt", "warming")
            for seed in seeds("a warmer winding", 1, 8, effort)
        ),
        *(Case("temperature", seed, long, degrees) for degrees in temperatures for seed in few),
        *(Case("ramp", seed, 60.0, *ends) for ends in ((-40.0, 120.0), (120.0, -40.0)) for seed in few),
    ]


def _commanded(effort: Effort) -> list[tuple[int, int, float]]:
    first, *others = seeds("voltages as commanded", 2, 9, effort)
    return [(first, seed, 8.0 if effort.quick else 20.0) for seed in others]


def _beginnings(effort: Effort) -> list[tuple[str, int, int, tuple[float, ...]]]:
    drawn = seeds("standing", 6, 60, effort)
    return [
        (begins, seed, drawn[number % 6], (0.1, 0.3, 0.5, 0.75))
        for begins in ("from rest", "reversing")
        for number, seed in enumerate(drawn)
    ]


def _faults(effort: Effort) -> list[Trial]:
    few = 1 if effort.quick else 10
    by_speed = SEEDS.of("faults by speed", few * len(SPEEDS))
    return [
        *(Trial(seed) for seed in seeds("faults while turning", 3, 40, effort)),
        *(Trial(seed, SPEEDS[number // few]) for number, seed in enumerate(by_speed)),
    ]


def _angles(effort: Effort) -> list[AngleCase]:
    drawn = seeds("three angles", 1, 3, effort)
    chosen = ("slalom",) if effort.quick else tuple(monitor.COURSES)
    kinds = [("", ""), *((angle, kind) for angle in monitor.ANGLES for kind in monitor.KINDS)]
    return [AngleCase(course, seed, *each) for each in kinds for course in chosen for seed in drawn]


def _salient(effort: Effort) -> list[Course]:
    right, wrong = (seeds("salient motors", 1, count, effort) for count in (6, 3))
    return [
        *(Course(ratio, seed, fast=fast) for fast in (False, True) for ratio in RATIOS for seed in right),
        *(Course(ratio, seed, name) for ratio in RATIOS[1:] for name in monitor.WRONG for seed in wrong),
    ]


def _identified(effort: Effort) -> list[tuple[int, float]]:
    few, long = (2, 5.0) if effort.quick else (12, 20.0)
    drawn = seeds("parameters from a drive", 4, 50, effort)
    return [(seed, long if number < few else 0.0) for number, seed in enumerate(drawn)]


DATASETS = (
    Dataset(
        "load",
        "A load that is not known makes the speed wrong",
        observers.loaded,
        lambda effort: seeds("a load that steps", 1, 4, effort),
    ),
    Dataset(
        "side-by-side",
        "The observers side by side",
        observers.beside,
        lambda effort: [(seed, seconds(effort)) for seed in seeds("the observers side by side", 1, 3, effort)],
    ),
    Dataset(
        "speeds",
        "The feedforward by speed",
        observers.fast,
        lambda effort: [(seeds("what a step costs", 1, 1, effort)[0], speed) for speed in (10.0, 30.0, 60.0, 100.0)],
    ),
    Dataset("operations", "What a step costs (Table 1)", observers.operations, lambda effort: [None]),
    Dataset(
        "car",
        "In the car (Figures 4 to 7)",
        observers.in_the_car,
        lambda effort: [
            ("slalom", 12.0 if effort.quick else 30.0, SEEDS.of("in the car", 2)[0]),
            ("parking", 30.0 if effort.quick else 40.0, SEEDS.of("in the car", 2)[1]),
        ],
    ),
    Dataset("accuracy", "Motors that differ from the vehicle file", robustness.accuracy, _accuracy),
    Dataset("commanded", "Voltages as commanded", robustness.commanded, _commanded),
    Dataset("standstill", "Standing", robustness.standstill, lambda effort: seeds("standing", 2, 6, effort)),
    Dataset("beginnings", "A wrong beginning", robustness.beginnings, _beginnings),
    Dataset("faults", "Faults of the angle sensor", monitor.faults, _faults),
    Dataset(
        "anywhere",
        "Faults that stall the drive",
        monitor.faults_anywhere,
        lambda effort: [
            (fault.name, seed)
            for fault in (STUCK, SWAPPED_SINE, SWAPPED_PHASES)
            for seed in seeds("faults anywhere", 3, 40, effort)
        ],
    ),
    Dataset(
        "fault-free",
        "Fault-free drives",
        monitor.fault_free,
        lambda effort: seeds("fault-free drives", 2, 75, effort, thorough=800),
    ),
    Dataset(
        "run-length",
        "Time between false alarms",
        monitor.run_length,
        lambda effort: [
            (number, wanted, 200_000 if effort.quick else 4_000_000)
            for wanted in (200.0, 1000.0)
            for number in range(len(monitor.RULES))
        ],
    ),
    Dataset("angles", "Which of three angles is wrong", monitor.three_angles, _angles),
    Dataset("salient", "Salient motors, and loads that step", monitor.salient, _salient),
    Dataset(
        "salient-offsets",
        "Offsets on salient motors",
        monitor.salient_offsets,
        lambda effort: [
            (ratio, seed, degrees)
            for ratio in RATIOS
            for seed in seeds("faults of salient motors", 2, 15, effort)
            for degrees in (-5.0, 5.0)
        ],
    ),
    Dataset(
        "salient-fault-free",
        "Fault-free drives of salient motors",
        monitor.salient_fault_free,
        lambda effort: seeds("fault-free salient motors", 3, 60, effort, thorough=600),
    ),
    Dataset("identified", "Parameters from a drive", identification.identified, _identified),
    Dataset(
        "guaranteed",
        "Guaranteed intervals",
        identification.guaranteed,
        lambda effort: seeds("guaranteed intervals", 3, 30, effort),
    ),
    Dataset("real", "A real drive", identification.real_drive, lambda effort: ["dragged", "friction"], missing=NO_DATA),
)
"""The datasets, in the order of the report."""


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    yield SEEDS.table()
