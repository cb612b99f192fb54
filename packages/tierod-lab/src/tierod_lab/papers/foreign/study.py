"""The study of foreign plants: motion sensors of a car, friction of a column, and motors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from tierod.core.block import Block
from tierod.core.content import Item
from tierod.vehicles import load
from tierod_lab.papers.foreign import datasets
from tierod_lab.papers.foreign.motor_drives import MACHINES
from tierod_lab.papers.foreign.rubbing_column import LUGRE, MAXWELL
from tierod_lab.papers.friction.reported import monitor
from tierod_lab.papers.seeds import ReportedSeeds
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame


def _sensors() -> Sequence[Block]:
    from tierod.monitors.condition.definition import condition_monitor

    return (condition_monitor(load("rav4")),)


def _motors() -> Sequence[Block]:
    from tierod.monitors.motor_angle.definition import MotorAngleMonitor

    return (MotorAngleMonitor.of_vehicle(load("motor-bench"), 1e-4),)


CAR, COLUMN, MOTORS = "CommonRoad's car", "a foreign column", "motors of motulator"
SEEDS = {
    CAR: ReportedSeeds(_sensors, {CAR: 70_000}, "the condition monitor of rav4"),
    COLUMN: ReportedSeeds(lambda: (monitor(),), {COLUMN: 70_000}, "the friction monitor of midsize-eps"),
    MOTORS: ReportedSeeds(_motors, {MOTORS: 70_000}, "the motor-angle monitor of motor-bench"),
}
"""Seeds of every plant, from the monitor that is judged on it."""


def _seed(part: str) -> int:
    return SEEDS[part].of(part, 1)[0]


def _cars(effort: Effort) -> list[tuple[int, bool]]:
    return [(_seed(CAR), effort.quick)]


def _columns(effort: Effort) -> list[tuple[str, int, int, float]]:
    cars, minutes = (1, 6.0) if effort.quick else (3, 7.0)
    return [(law, number, _seed(COLUMN), minutes) for law in (LUGRE, MAXWELL) for number in range(cars)]


def _machines(effort: Effort) -> list[tuple[str, int, float]]:
    machines = list(MACHINES)[:1] if effort.quick else list(MACHINES)
    return [(name, _seed(MOTORS) + number, 10.0) for name in machines for number in range(3 if effort.thorough else 1)]


DATASETS = (
    Dataset(
        "sensors", "Sensors of CommonRoad's car", datasets.over_car, _cars, "commonroad-vehicle-models is missing."
    ),
    Dataset("column", "Friction on a foreign column", datasets.over_column, _columns),
    Dataset("motors", "Motors of motulator", datasets.over_motors, _machines, "motulator is missing."),
)
"""The datasets, in the order of the report."""


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress)
    for seeds in SEEDS.values():
        yield seeds.table()
