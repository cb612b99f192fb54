"""The study of own cars: brochure values, one drive to identify the car, other drives to judge it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from tierod.core.block import Block
from tierod.core.content import Item
from tierod.vehicles import load
from tierod_lab.papers.own_car.judging import KNOWN, Case, over_cars, over_real_cars
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.seeds import ReportedSeeds
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame


def _monitors() -> Sequence[Block]:
    """The judged monitors, each with the file of one car; other files change only numbers in the same graph."""
    from tierod.monitors.condition.definition import condition_monitor
    from tierod.monitors.driver_torque.hands import HandsMonitor
    from tierod.monitors.driver_torque.observer import ColumnObserver
    from tierod.monitors.friction.definition import FrictionMonitor
    from tierod.monitors.sideslip.estimator import CombinedSideslip

    car, step = load("midsize-eps"), 0.01
    column = ColumnObserver.of_vehicle(car, step), HandsMonitor.of_vehicle(car, step)
    motion = CombinedSideslip.of_vehicle(car, step), condition_monitor(load("rav4"))
    return FrictionMonitor.of_vehicle(car, step), *column, *motion


CARS = "cars and drives"
SEEDS = ReportedSeeds(_monitors, {CARS: 0}, "the monitors of friction, hands, sideslip and condition")


def _cases(effort: Effort) -> list[Case]:
    """One of every base car; the thorough study has nearly three of each, and drives each for two hours."""
    seed = SEEDS.of(CARS, 1)[0]
    if effort.quick:
        return [Case(number, seed, 2.0, 2.5, 1) for number in range(3)]
    minutes, drives, cars = (30.0, 4, 20) if effort.thorough else (13.0, 1, 7)
    return [Case(number, seed, 13.0, minutes, drives) for number in range(cars)]


DATASETS = (
    Dataset("cars", "Virtual cars that are not known", over_cars, _cases),
    Dataset("real", "Real cars with files that are not theirs", over_real_cars, lambda effort: KNOWN, missing=NO_DATA),
)
"""The datasets, in the order of the report."""


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress)
    yield SEEDS.table()
