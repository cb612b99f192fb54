"""Plan of a campaign: its drives and verdicts, each with the key of all that decides it, and the results at hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tierod.experiments.fingerprint import fingerprint, ground_code, tower_code
from tierod.experiments.judged import Window
from tierod.experiments.matrix import Point
from tierod.experiments.rows import FAULT, FAULT_FREE
from tierod.experiments.store import Store, slug
from tierod.monitors.harness.session import Monitor, Variant
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class Judge:
    """A monitor of the campaign, ready to judge.

    Args:
        label: as the campaign calls it
        monitor, variant: by name
        belief: parameters of the car that it assumes
        learns: whether it judges against the baseline from the first fault-free drive of the same car
    """

    label: str
    monitor: str
    variant: str
    belief: Vehicle
    learns: bool

    def found(self) -> tuple[Monitor, Variant]:
        """The monitor itself."""
        from tierod.monitors.diagnose import find

        return find(self.monitor, self.variant)


@dataclass(frozen=True)
class Cell:
    """One drive of the campaign.

    Args:
        point: where it stands in the matrix
        scenario: what is driven, with its seed
        key: of all that decides the drive
        reference: number of the cell whose drive sets the baseline of this one's car; None where nothing is learnt,
            or where this is the reference itself
    """

    point: Point
    scenario: Any
    key: str
    reference: int | None

    @property
    def name(self) -> str:
        """Name of the cell's files."""
        return slug(self.point.place)

    @property
    def faulty(self) -> bool:
        """Whether a fault is given."""
        return self.point.place[FAULT] != FAULT_FREE


@dataclass(frozen=True)
class Plan:
    """All cells and monitors.

    Args:
        cells: in the order of the matrix
        judges: that judge every drive
        settling: see `tierod.experiments.definition.CampaignFile`
        keep: whether recordings are kept
    """

    cells: Sequence[Cell]
    judges: Sequence[Judge]
    settling: float
    keep: bool

    def verdict_key(self, cell: Cell, judge: Judge) -> str:
        """Key of a verdict, from the drive, the monitor with its vehicle, its baseline, and the code."""
        reference = None if cell.reference is None or not judge.learns else self.cells[cell.reference].key
        belief = {name: getattr(judge.belief, name) for name in ("name", "torque_unit", "parameters")}
        return fingerprint(
            cell.key, judge.monitor, judge.variant, belief, reference, self.settling, cell.faulty, tower_code()
        )

    def verdict_name(self, cell: Cell, judge: Judge) -> str:
        """File name of a verdict."""
        return f"{cell.name}_{slug({'label': judge.label}, 40)}"

    def done(self, cell: Cell, store: Store) -> bool:
        """Whether the drive, its recording where it is kept, and every verdict are there."""
        drive = store.drive(cell.name, cell.key)
        if drive is None or not drive["lasting"] or (self.keep and self.lacks_recording(drive, store)):
            return False
        return drive["outcome"] != "driven" or not self.open_judges(cell, store)

    def lacks_recording(self, drive: Mapping[str, Any], store: Store) -> bool:
        """Whether a drive has samples that should be kept and are not."""
        return drive["outcome"] != "failed" and not store.has_recording(drive)

    def open_judges(self, cell: Cell, store: Store) -> list[Judge]:
        """The monitors whose verdict is not there, or could not be made for a reason that may have passed."""
        return [
            judge for judge in self.judges if not (self.verdict(cell, judge, store) or {"lasting": False})["lasting"]
        ]

    def verdict(self, cell: Cell, judge: Judge, store: Store) -> dict[str, Any] | None:
        """The record of a verdict."""
        return store.verdict(self.verdict_name(cell, judge), self.verdict_key(cell, judge))


DECIDING = ("car", "course", "duration", "seed", "sensors", "faults", "scatter", "files")
"""Fields of a scenario that decide its drive; names and descriptions do not."""


def drive_key(scenario: Any, known: dict[int, tuple[Any, str]] | None = None) -> str:
    """Key of a drive, from all that decides it: the scenario and the code that drives.

    Args:
        scenario: what is driven
        known: fingerprints of parts by their identity, kept with the parts themselves from one scenario to the next:
            those that differ in their seed share a car
    """
    known = {} if known is None else known
    prints = {}
    for name in DECIDING:
        part = getattr(scenario, name)
        if id(part) not in known:
            known[id(part)] = (part, fingerprint(part))
        prints[name] = known[id(part)][1]
    return fingerprint(prints, ground_code())


def window_of(windows: Sequence[Mapping[str, Any]]) -> Window | None:
    """Window from the first start to the last end of a drive's faults; None where no fault came."""
    came = [each for each in windows if each["start"] is not None]
    if not came:
        return None
    return Window(min(float(each["start"]) for each in came), max(float(each["end"]) for each in came))


def reference_drives(points: Sequence[Point], same_car: Sequence[str]) -> list[int | None]:
    """Per cell the number of the first fault-free one of the same car; None for that one itself, -1 without one."""
    first: dict[tuple[str, ...], int] = {}
    cars = [tuple(point.place[axis] for axis in same_car) for point in points]
    for number, (point, car) in enumerate(zip(points, cars, strict=True)):
        if point.place[FAULT] == FAULT_FREE:
            first.setdefault(car, number)
    found = [first.get(car, -1) for car in cars]
    return [None if reference == number else reference for number, reference in enumerate(found)]
