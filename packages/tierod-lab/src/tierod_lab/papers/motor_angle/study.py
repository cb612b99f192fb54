"""The study of the motor's angle: observers, motors unlike the vehicle file, sensor faults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from tierod.core.block import Block
from tierod.core.content import Chart, Item
from tierod.vehicles import load
from tierod_lab.papers.motor_angle import monitor_datasets as monitor
from tierod_lab.papers.motor_angle import observer_datasets as observers
from tierod_lab.papers.motor_angle.monitor_datasets import AngleCase
from tierod_lab.papers.motor_angle.observer_datasets import COLD, FAST, HELD, HOT, RAMP, CarDrive, Case
from tierod_lab.papers.seeds import ReportedSeeds
from tierod_lab.studies import engine
from tierod_lab.studies.charts import Curves, chart
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame


def _judged() -> Sequence[Block]:
    from tierod.monitors.motor_angle.definition import MotorAngleMonitor
    from tierod.monitors.motor_angle.observer import MotorAngleObserver

    vehicle, sample_time = load("motor-bench"), 1e-4
    commanded = MotorAngleObserver.of_vehicle(vehicle, sample_time, commanded=True)
    return MotorAngleMonitor.of_vehicle(vehicle, sample_time), commanded


SEEDS = ReportedSeeds(
    _judged,
    {
        "what a step costs": 20,
        "in the car": 30,
        "three angles": 60,
        "parameters from a drive": 400,
        "motors that differ": 700,
        "temperature": 1000,
        "faults while turning": 2000,
        "fault-free drives": 10_000,
        "salient motors": 40_000,
    },
    "the monitor of the motor's angle and its observer of commanded voltages",
)


def seeds(part: str, quick: int, usual: int, effort: Effort, thorough: int = 0) -> range:
    """Seeds of a part, as many as the effort allows."""
    return SEEDS.of(part, quick if effort.quick else thorough if effort.thorough and thorough else usual)


def _in_the_car(effort: Effort) -> list[tuple[str, float, int]]:
    slalom, parking = SEEDS.of("in the car", 2)
    return [
        ("slalom", 12.0 if effort.quick else 30.0, slalom),
        ("parking", 30.0 if effort.quick else 40.0, parking),
    ]


def _accuracy(effort: Effort) -> list[Case]:
    seconds = 6.0 if effort.quick else 20.0
    temperatures = (-40.0, 20.0, 120.0) if effort.quick else (-40.0, -20.0, 0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0)
    few = seeds("temperature", 1, 3, effort)
    return [
        *(Case("drawn", seed, seconds) for seed in seeds("motors that differ", 3, 20, effort)),
        *(Case("temperature", seed, seconds, each, each) for each in temperatures for seed in few),
        *(Case("temperature", seed, RAMP, *ends) for ends in ((COLD, HOT), (HOT, COLD)) for seed in few),
    ]


def _angles(effort: Effort) -> list[AngleCase]:
    drawn = seeds("three angles", 1, 3, effort)
    chosen = ("slalom",) if effort.quick else tuple(monitor.COURSES)
    kinds = [("", ""), *((angle, kind) for angle in monitor.ANGLES for kind in monitor.KINDS)]
    return [AngleCase(course, seed, *each) for each in kinds for course in chosen for seed in drawn]


DATASETS = (
    Dataset(
        "speeds",
        "The feedforward by speed",
        observers.fast,
        lambda effort: [(SEEDS.of("what a step costs", 1)[0], speed) for speed in (10.0, 30.0, 60.0, 100.0)],
    ),
    Dataset("operations", "What a step costs (Table 1)", observers.operations, lambda effort: [None]),
    Dataset("car", "In the car (Figures 4 to 7)", observers.in_the_car, _in_the_car),
    Dataset("accuracy", "Motors that differ from the vehicle file", observers.accuracy, _accuracy),
    Dataset(
        "faults",
        "Faults of the angle sensor",
        monitor.faults,
        lambda effort: seeds("faults while turning", 3, 40, effort),
    ),
    Dataset(
        "fault-free",
        "Fault-free drives",
        monitor.fault_free,
        lambda effort: seeds("fault-free drives", 2, 75, effort, thorough=800),
    ),
    Dataset("angles", "Which of three angles is wrong", monitor.three_angles, _angles),
    Dataset(
        "salient",
        "Salient motors, and loads that step",
        observers.salient,
        lambda effort: [
            (ratio, seed, fast)
            for fast in (False, True)
            for ratio in (1.0, 1.1, 1.5, 2.0, 3.0)
            for seed in seeds("salient motors", 1, 6, effort)
        ],
    ),
    Dataset(
        "identified",
        "Parameters from a drive",
        observers.identified,
        lambda effort: seeds("parameters from a drive", 4, 50, effort),
    ),
)
"""The datasets, in the order of the report."""


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """The paper's Figures 4 to 7."""
    for number, (name, title, span) in enumerate(
        (
            ("slalom", "Slalom (Figure 4)", None),
            ("parking", "Parking (Figure 5)", None),
            ("parking", "From lock to lock (Figure 6)", FAST),
            ("parking", "Held near the lock (Figure 7)", HELD),
        )
    ):
        seen = observers.car_drive(*next(task for task in _in_the_car(effort) if task[0] == name))
        yield chart(
            f"motor-angle-figure-{number + 4}",
            title,
            "Error of the angle by the methods as printed, with the load as a state, and by the default; within a "
            "section, from its beginning on.",
            "Without load the observers leave the true angle; with load they stay near it, the default nearest.",
            {("", "error of the angle (rad)"): _errors(seen, span)},
            every=4,
        )


def _errors(seen: CarDrive, span: tuple[float, float] | None) -> Curves:
    low, high = span or (-np.inf, np.inf)
    part = (seen.time >= low) & (seen.time <= high)
    away = {name: seen.error(each)[part] for name, each in observers.methods(observers.CAR).items()}
    return {name: (seen.time[part], each - (each[0] if span else 0.0)) for name, each in away.items()}


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    yield SEEDS.table()
