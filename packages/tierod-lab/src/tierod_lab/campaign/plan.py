"""Plan of a campaign: drives and verdicts, each with the key of everything that determines it, and existing results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tierod.monitors.session import Monitor, Variant
from tierod.vehicles import Vehicle
from tierod.work.fingerprint import fingerprint
from tierod_lab.campaign.code import ground_code, judging_code
from tierod_lab.campaign.judging import Window
from tierod_lab.campaign.matrix import FAULT, FAULT_FREE, Point
from tierod_lab.campaign.store import Store, slug


@dataclass(frozen=True)
class Judge:
    """A monitor of the campaign."""

    label: str
    monitor: str
    variant: str
    belief: Vehicle  # vehicle parameters of the monitor
    learns: bool  # whether it uses the baseline from the first fault-free drive of the same car

    def found(self) -> tuple[Monitor, Variant]:
        from tierod.monitors.runner import find

        return find(self.monitor, self.variant)


@dataclass(frozen=True)
class Cell:
    """One drive of the campaign."""

    point: Point
    scenario: Any
    key: str  # key of everything that determines the drive
    # number of the cell whose drive sets the baseline of the same car; None if nothing is learnt, or for this cell
    # itself
    reference: int | None

    @property
    def name(self) -> str:
        return slug(self.point.place)

    @property
    def faulty(self) -> bool:
        return self.point.place[FAULT] != FAULT_FREE


@dataclass(frozen=True)
class Plan:
    """All cells and monitors."""

    cells: Sequence[Cell]  # cells in the order of the matrix
    judges: Sequence[Judge]  # monitors that judge every drive
    settling: float  # see `tierod_lab.campaign.matrix.CampaignFile`
    keep: bool

    def verdict_key(self, cell: Cell, judge: Judge) -> str:
        """Key of a verdict, from drive, monitor with its vehicle, baseline, and code."""
        reference = None if cell.reference is None or not judge.learns else self.cells[cell.reference].key
        belief = {name: getattr(judge.belief, name) for name in ("name", "torque_unit", "parameters")}
        return fingerprint(
            cell.key, judge.monitor, judge.variant, belief, reference, self.settling, cell.faulty, judging_code()
        )

    def verdict_name(self, cell: Cell, judge: Judge) -> str:
        return f"{cell.name}_{slug({'label': judge.label}, 40)}"

    def done(self, cell: Cell, store: Store) -> bool:
        """Whether the drive, its recording if it is to be kept, and every verdict exist."""
        drive = store.drive(cell.name, cell.key)
        if drive is None or not drive["lasting"]:
            return False
        if self.keep and drive["outcome"] != "failed" and not store.has_recording(drive):
            return False
        return drive["outcome"] != "driven" or not self.open_judges(cell, store)

    def open_judges(self, cell: Cell, store: Store) -> list[Judge]:
        """Monitors whose verdict is missing, or failed for a reason that may no longer hold."""
        verdicts = ((judge, self.verdict(cell, judge, store)) for judge in self.judges)
        return [judge for judge, verdict in verdicts if verdict is None or not verdict["lasting"]]

    def verdict(self, cell: Cell, judge: Judge, store: Store) -> dict[str, Any] | None:
        """Record of a verdict, or None."""
        return store.verdict(self.verdict_name(cell, judge), self.verdict_key(cell, judge))


DECIDING = ("car", "course", "duration", "seed", "sensors", "faults", "scatter", "files")
"""Fields of a scenario that determine its drive; names and descriptions do not."""


def drive_key(scenario: Any, known: dict[int, tuple[Any, str]] | None = None) -> str:
    known = {} if known is None else known
    prints = {}
    for name in DECIDING:
        part = getattr(scenario, name)
        if id(part) not in known:
            known[id(part)] = (part, fingerprint(part))
        prints[name] = known[id(part)][1]
    return fingerprint(prints, ground_code())


def window_of(windows: Sequence[Mapping[str, Any]]) -> Window | None:
    """Window from the first start to the last end of a drive's faults; None if no fault started."""
    came = [Window(float(each["start"]), float(each["end"])) for each in windows if each["start"] is not None]
    return Window(min(each.start for each in came), max(each.end for each in came)) if came else None


def reference_drives(points: Sequence[Point], same_car: Sequence[str]) -> list[int | None]:
    """Number of the first fault-free cell of the same car, per cell; None for that cell itself, -1 if there is none."""
    first: dict[tuple[str, ...], int] = {}
    cars = [tuple(point.place[axis] for axis in same_car) for point in points]
    for number, (point, car) in enumerate(zip(points, cars, strict=True)):
        if point.place[FAULT] == FAULT_FREE:
            first.setdefault(car, number)
    return [None if first.get(car) == number else first.get(car, -1) for number, car in enumerate(cars)]
