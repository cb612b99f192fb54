"""A campaign from its file, checked completely before the first drive."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from tierod.core.claims import Goal
from tierod.core.errors import ParameterError, nearest
from tierod.core.files import expanded
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.monitors.runner import find
from tierod.vehicles import load as load_vehicle
from tierod_lab.campaign.matrix import (
    FAULT,
    LEARNT,
    SEED,
    SIZE,
    CampaignFile,
    Matrix,
    MonitorChoice,
    Point,
    is_at,
)
from tierod_lab.campaign.plan import Cell, Judge, Plan, drive_key, reference_drives
from tierod_lab.campaign.pools import Gate, Pool
from tierod_lab.campaign.scenarios import Scenes
from tierod_lab.campaign.store import Store
from tierod_lab.ground.recorder import TRUTH_RATE, channel_names

SHIPPED = Path(__file__).parent  # Folder of the campaigns that tierod ships


@dataclass(frozen=True)
class Campaign:
    """A campaign that is ready to run."""

    file: CampaignFile
    document: Document
    plan: Plan
    gates: tuple[Gate, ...]

    @property
    def axes(self) -> dict[str, list[str]]:
        """Levels of every axis in order; fault, size and seed are last."""
        found: dict[str, list[str]] = {}
        for cell in self.plan.cells:
            for axis, level in cell.point.place.items():
                levels = found.setdefault(axis, [])
                if level not in levels:
                    levels.append(level)
        return found

    @property
    def hours(self) -> float:
        """Driving time of all cells together [h]."""
        return float(sum(cell.scenario.duration for cell in self.plan.cells)) / 3600.0


def shipped() -> tuple[str, ...]:
    """The names of the campaigns that tierod ships, in alphabetical order."""
    return tuple(sorted(path.stem for path in SHIPPED.glob("*.toml")))


def load(name_or_path: str | Path) -> Campaign:
    """The campaign of a shipped name or of a file."""
    return from_document(Document.read(_find(str(name_or_path)), "campaign"))


def _find(given: str) -> Path:
    if given in shipped():
        return SHIPPED / f"{given}.toml"
    path = expanded(given)
    if path.suffix == ".toml" or path.parent != Path() or path.is_file():
        return path
    raise ParameterError(f"no campaign is called '{given}'{nearest(given, shipped())} A file is named by its path")


def from_document(document: Document) -> Campaign:
    """The campaign of a document; relative paths in it start at its folder."""
    file: CampaignFile = build(CampaignFile, document.content, document)
    whole = Matrix(file, document)
    matrix = whole.points()
    judges = _judges(file, document)
    scenes = Scenes.of(file, document)
    driven = [scenes.scenario(point) for point in matrix]
    scattered = any(scenario.scatter is not None for scenario in driven)
    learns = any(each.learns for each in judges)
    references = _reference_points(file, document, matrix, scattered) if learns else [None] * len(matrix)
    known: dict[int, tuple[object, str]] = {}
    keys = [drive_key(scenario, known) for scenario in driven]
    cells = [Cell(*each) for each in zip(matrix, driven, keys, references, strict=True)]
    plan = Plan(cells, judges, file.settling, file.keep == "recordings")
    return Campaign(file, document, plan, _gates(whole, matrix, [judge.label for judge in judges]))


def _judges(file: CampaignFile, document: Document) -> tuple[Judge, ...]:
    if not file.monitors:
        raise document.error(("monitors",), "no monitor judges the drives; add [[monitors]]")
    judges: dict[str, Judge] = {}
    for number, choice in enumerate(file.monitors):
        judge = _judge(choice, document, ("monitors", number))
        if judge.label in judges:
            message = f"two monitors are called '{judge.label}'; give one of them another label"
            raise document.error(("monitors", number), message)
        judges[judge.label] = judge
    return tuple(judges.values())


def _judge(choice: MonitorChoice, document: Document, location: tuple[str | int, ...]) -> Judge:
    try:
        monitor, variant = find(choice.monitor, choice.variant or None)
    except ParameterError as error:
        raise document.error((*location, "variant" if choice.variant else "monitor"), str(error)) from None
    beside = document.path.parent / choice.vehicle
    try:
        belief = load_vehicle(beside if beside.is_file() else choice.vehicle)
        variant.open(belief, monitor.rate, None)
    except ParameterError as error:
        raise document.error((*location, "vehicle"), str(error)) from None
    label = choice.label or f"{monitor.name}, {variant.name}"
    return Judge(label, monitor.name, variant.name, belief, choice.baseline == LEARNT)


def _reference_points(
    file: CampaignFile, document: Document, matrix: Sequence[Point], scattered: bool
) -> list[int | None]:
    if file.same_car is None:
        learnt = "'same_car' is missing: a baseline is learnt from the first fault-free drive of the same car"
        message = f"{learnt}; name the axes that define a car, of: {', '.join(matrix[0].place)}"
        raise document.error(("same_car",), message)
    for number, axis in enumerate(file.same_car):
        if axis not in matrix[0].place or axis in (FAULT, SIZE):
            known = [name for name in matrix[0].place if name not in (FAULT, SIZE)]
            raise document.error(("same_car", number), f"'{axis}' is not an axis of cars{nearest(axis, known)}")
    if scattered and SEED not in file.same_car:
        scatters = "the scenario scatters cars and sensors from seed to seed, so that 'seed' belongs to same_car"
        raise document.error(("same_car",), scatters)
    references = reference_drives(matrix, file.same_car)
    if -1 in references:
        place = matrix[references.index(-1)].place
        car = ", ".join(f"{axis} {place[axis]}" for axis in file.same_car) or "any car"
        lacks = f"there is no fault-free drive of the same car ({car}) to learn its baseline from"
        raise document.error(("same_car",), lacks)
    return references


def _gates(whole: Matrix, matrix: Sequence[Point], labels: Sequence[str]) -> tuple[Gate, ...]:
    gates, document = [], whole.document
    for number, entry in enumerate(whole.file.gates):
        location = ("gates", number)
        if entry.figure not in Pool._fields:
            near = nearest(entry.figure, Pool._fields)
            raise document.error((*location, "figure"), f"no figure is called '{entry.figure}'{near}")
        try:
            goal = Goal.read(entry.goal)
        except ParameterError as error:
            raise document.error((*location, "goal"), str(error)) from None
        whole.check(entry.where, None, (*location, "where"))
        if not any(is_at(point.place, entry.where) for point in matrix):
            raise document.error((*location, "where"), "no cell of the matrix is there; the gate would judge nothing")
        if entry.monitor not in labels and (entry.monitor or len(labels) > 1):
            near = nearest(entry.monitor, labels)
            raise document.error((*location, "monitor"), f"no monitor is called '{entry.monitor}'{near}")
        gates.append(Gate(entry.figure, goal, entry.where, entry.monitor or labels[0]))
    return tuple(gates)


TASTE = 10.0  # Duration of the trial drive from which the simulation speed is measured [s]

KEPT, JUDGED = 1.5, 1.1
"""Time for a drive with its verdicts divided by that for the drive alone, with and without keeping its recording;
measured on drives of 13 minutes of a mid-size car."""

START = 3.0  # Start-up time of the workers [s]


@dataclass(frozen=True)
class Estimate:
    """Estimated cost of a campaign."""

    cells: int  # number of cells of the matrix
    missing: int  # number of unfinished cells
    hours: Annotated[float, "h"]  # driving time of the unfinished cells
    seconds: Annotated[float, "s"]
    bytes: int


def estimate(campaign: Campaign, store: Store, processes: int) -> Estimate:
    """Estimate the cost of a campaign from a short trial drive."""
    plan = campaign.plan
    missing = [cell for cell in plan.cells if not plan.done(cell, store)]
    driven = sum(cell.scenario.duration for cell in missing)
    size = sum(_bytes_per_second(cell) * cell.scenario.duration for cell in missing) if plan.keep else 0.0
    beside = KEPT if plan.keep else JUDGED
    seconds = beside * driven / _speed(missing[0]) / max(processes, 1) + START if missing else 0.0
    return Estimate(len(plan.cells), len(missing), driven / 3600.0, seconds, round(size))


def _speed(cell: Cell) -> float:
    scenario = replace(cell.scenario, faults=()).with_run(seconds=min(TASTE, cell.scenario.duration))
    scenario.run()  # the first run includes the compilation
    began = time.perf_counter()
    scenario.run()
    return float(scenario.duration / (time.perf_counter() - began))


def _bytes_per_second(cell: Cell) -> float:
    """Data rate of a cell's recording without compression, which gains little on noise [byte/s]."""
    scenario = cell.scenario
    channels = channel_names(scenario.car)
    readings = sum(sensor.rate for name, sensor in scenario.sensors.items() if name in channels)
    return float(8.0 * (readings + TRUTH_RATE * len(channels)))
