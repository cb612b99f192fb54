"""Matrix of a campaign: all combinations of levels without excluded and with included cells."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.toml_document import Document
from tierod_lab.ground.faults import Fault, fault_of

FAULT_FREE = "fault-free"  # Level of the fault axis for drives without a fault

FAULT, SIZE, SEED = "fault", "size", "seed"  # Axes of every campaign

LEARNT = "first fault-free drive"  # Name of the baseline that is learnt from the first fault-free drive of the same car


@dataclass(frozen=True)
class Axis:
    """One axis of the matrix, with the changes of every level."""

    set: str = ""  # dotted name in the scenario that takes the `values`; the name of the axis if empty
    values: tuple[Any, ...] = ()  # values of the levels, which are named as they are written
    # alternative to values: name -> changes of the scenario by dotted name; an empty table changes nothing
    levels: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if bool(self.values) == bool(self.levels):
            raise ParameterError("an axis has either values or levels; give one of them")
        if self.set and self.levels:
            raise ParameterError("'set' works with values only; levels name what they change")

    def changes(self, name: str) -> list[tuple[str, Mapping[str, Any], tuple[str | int, ...]]]:
        """(level, changes of the scenario, place within the axis) of every level."""
        if self.levels:
            return [(level, changes, ("levels", level)) for level, changes in self.levels.items()]
        return [(label(value), {self.set or name: value}, ("values", at)) for at, value in enumerate(self.values)]


@dataclass(frozen=True)
class Seeds:
    """Consecutive seeds, from the first one on."""

    first: Annotated[int, "", NOT_NEGATIVE]
    count: Annotated[int, "", POSITIVE]


@dataclass(frozen=True)
class MonitorChoice:
    """A monitor with its parameters."""

    monitor: str  # name, as listed by `tierod monitors`
    vehicle: str  # parameter set of the monitor, a name or a file
    baseline: Literal["none", "first fault-free drive"]
    variant: str = ""  # variant of the monitor; its default if empty
    label: str = ""  # name in the campaign; monitor and variant if empty


@dataclass(frozen=True)
class GateEntry:
    """A gate: a limit on a figure of the campaign."""

    figure: str  # field of `tierod_lab.campaign.pools.Pool`
    goal: str
    # axis -> level, or a list of levels; the whole campaign if empty
    where: Mapping[str, Any] = field(default_factory=dict)
    monitor: str = ""  # label; optional if there is one monitor only


@dataclass(frozen=True)
class CampaignFile:
    """Content of a campaign file."""

    name: str  # short name, for titles
    description: str
    scenario: str  # base scenario of all drives: name of a shipped scenario, or a file beside this one
    monitors: tuple[MonitorChoice, ...]  # monitors that judge every drive
    seeds: Seeds | tuple[int, ...]  # seeds of the drives; the innermost axis
    changes: Mapping[str, Any] = field(default_factory=dict)  # changes of the scenario by dotted name, for all drives
    axes: Mapping[str, Axis] = field(default_factory=dict)  # name -> axis, outermost first
    # name -> table of a fault as in a scenario, with its `sizes`, one level each; `together` lists further faults that
    # act at the same time; the faults form one axis, after the fault-free drive
    faults: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    fault_free: bool = True
    exclude: tuple[Mapping[str, Any], ...] = ()  # axis -> level or levels: cells that are removed
    # axis -> level or levels, and "seeds": cells that are added; other axes take all their levels
    include: tuple[Mapping[str, Any], ...] = ()
    # axes that define a car: drives with equal levels of them are drives of the same car
    same_car: tuple[str, ...] | None = None
    # enabled time from the onset of a fault until estimates are attributed to the fault
    settling: Annotated[float, "s", NOT_NEGATIVE] = 50.0
    keep: Literal["recordings", "verdicts"] = "recordings"
    gates: tuple[GateEntry, ...] = ()


def label(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)


def labels(levels: object) -> list[str]:
    return [label(level) for level in (levels if isinstance(levels, list | tuple) else [levels])]


def is_at(place: Mapping[str, str], where: Mapping[str, object]) -> bool:
    return all(place.get(axis) in labels(levels) for axis, levels in where.items())


Location = tuple[str | int, ...]
SEEDS = "seeds"  # Key of the seeds of an included part

MOST_CELLS = 1_000_000  # Maximum size of a matrix before exclusions: a thousand cars every week for twenty years


@dataclass(frozen=True)
class Level:
    """One level of an axis; faults and their sizes form one axis with two names."""

    place: Mapping[str, str]
    changes: Mapping[str, Any]  # changes of the scenario, by dotted name
    location: Location  # place in the campaign file
    faults: tuple[Fault, ...] = ()
    tables: tuple[Mapping[str, Any], ...] = ()  # tables of these faults, as in a scenario


@dataclass(frozen=True)
class Point:
    """One cell of the matrix, before its scenario is built."""

    place: Mapping[str, str]  # axis -> level; fault, size and seed last
    levels: tuple[Level, ...]
    seed: int  # seed of all random numbers

    def changes(self, common: Mapping[str, object]) -> dict[str, Any]:
        """Changes of the scenario by dotted name; a later axis overrides an earlier one."""
        merged = dict(common)
        for level in self.levels:
            merged |= level.changes
        return merged

    @property
    def faults(self) -> tuple[Fault, ...]:
        return tuple(fault for level in self.levels for fault in level.faults)

    @property
    def tables(self) -> list[Mapping[str, Any]]:
        """Tables of these faults, as in a scenario."""
        return [table for level in self.levels for table in level.tables]


def with_changes(content: Mapping[str, object], changes: Mapping[str, object]) -> dict[str, Any]:
    """Nested tables with values set at dotted names; missing tables are created.

    A name that is written with dots in the tables (`"steering.ratio" = 0.07`) is found as it stands. Higher levels are
    set first, so that `car` and `car.parameters` may have any order; a text that gets values below it becomes the
    `name` of a table.
    """
    merged = dict(content)
    for path, value in sorted(changes.items(), key=lambda change: change[0].count(".")):
        if path in merged or "." not in path:
            merged[path] = value
            continue
        head, _, rest = path.partition(".")
        below = merged.get(head)
        below = {"name": below} if isinstance(below, str) else below
        merged[head] = with_changes(below if isinstance(below, Mapping) else {}, {rest: value})
    return merged


class Matrix:
    """All combinations of levels and seeds of a campaign, with the axes from which they are made, the faults last."""

    def __init__(self, file: CampaignFile, document: Document):
        self.file, self.document = file, document
        self.axes: list[list[Level]] = []
        for name, axis in file.axes.items():
            if name in (FAULT, SIZE, SEED, SEEDS):
                raise document.error(("axes", name), f"an axis cannot be called '{name}', which every campaign has")
            changes = axis.changes(name)
            levels = [Level({name: label}, change, ("axes", name, *place)) for label, change, place in changes]
            self.axes.append(self._distinct(levels))
        faults = [Level({FAULT: FAULT_FREE, SIZE: ""}, {}, ("fault_free",))] if file.fault_free else []
        for name in file.faults:
            if name == FAULT_FREE:
                without = f"a fault cannot be called '{FAULT_FREE}', which is a drive without one"
                raise document.error(("faults", name), without)
            faults += self._distinct(self._sizes(name))
        if not faults:
            empty = "the matrix is empty: there are no faults, and fault-free drives are left out"
            raise document.error(("fault_free",), empty)
        self.axes.append(faults)

    def _sizes(self, name: str) -> list[Level]:
        table, document = dict(self.file.faults[name]), self.document
        location: Location = ("faults", name)
        sizes, together = table.pop("sizes", None), table.pop("together", [])
        if not isinstance(together, list) or not (sizes is None or (isinstance(sizes, list) and sizes)):
            lists = "'sizes' is a list of sizes, 'together' a list of further faults; correct that"
            raise document.error(location, lists)
        if sizes is not None and "size" in table:
            raise document.error((*location, "size"), "'size' and 'sizes' state the same; leave one out")
        others = [fault_of(each, document, (*location, "together", at)) for at, each in enumerate(together)]
        table.setdefault("name", name)
        levels = []
        for at, size in enumerate([None] if sizes is None else sizes):
            sized = table if size is None else table | {"size": size}
            faults = (fault_of(sized, document, location), *others)
            place = {FAULT: name, SIZE: "" if size is None else label(size)}
            where = location if size is None else (*location, "sizes", at)
            levels.append(Level(place, {}, where, faults, (sized, *together)))
        return levels

    def _distinct(self, levels: list[Level]) -> list[Level]:
        seen: set[tuple[str, ...]] = set()
        for level in levels:
            key = tuple(level.place.values())
            if key in seen:
                twice = f"there are two levels '{' '.join(filter(None, key))}'; take one out"
                raise self.document.error(level.location, twice)
            seen.add(key)
        return levels

    def points(self) -> list[Point]:
        """All cells, in order; included ones are last."""
        seeds = self._checked_seeds(self.file.seeds, ("seeds",))
        found = {_key(point): point for point in self._product(seeds, ("seeds",))}
        for number, where in enumerate(self.file.exclude):
            location: Location = ("exclude", number)
            self.check(where, seeds, location)
            gone = [key for key, point in found.items() if is_at(point.place, where)]
            if not gone:
                raise self.document.error(location, "this excludes no cell that is left; take it out")
            for key in gone:
                del found[key]
        for number, where in enumerate(self.file.include):
            location = ("include", number)
            own = self._checked_seeds(where[SEEDS], (*location, SEEDS)) if SEEDS in where else seeds
            chosen = {axis: level for axis, level in where.items() if axis != SEEDS}
            self.check(chosen, own, location)
            for point in self._product(own, location):
                if is_at(point.place, chosen):
                    found.setdefault(_key(point), point)
        if not found:
            raise self.document.error(("exclude",), "every cell of the matrix is excluded; leave some")
        return list(found.values())

    def _product(self, seeds: Sequence[int], location: Location) -> list[Point]:
        cells = math.prod(map(len, self.axes)) * len(seeds)
        if cells > MOST_CELLS:
            most = f"with these seeds the matrix has {cells} cells; give at most {MOST_CELLS}"
            raise self.document.error(location, most)
        made = []
        for levels in itertools.product(*self.axes):
            place = {axis: name for level in levels for axis, name in level.place.items()}
            made += [Point(place | {SEED: str(seed)}, levels, seed) for seed in seeds]
        return made

    def _checked_seeds(self, seeds: Any, location: Location) -> tuple[int, ...]:
        if isinstance(seeds, Mapping) and set(seeds) == {"first", "count"} and _whole(seeds.values()):
            seeds = Seeds(**seeds)
        if isinstance(seeds, Seeds):
            if seeds.count > MOST_CELLS:
                raise self.document.error(location, f"these are {seeds.count} seeds; give at most {MOST_CELLS}")
            seeds = tuple(range(seeds.first, seeds.first + seeds.count))
        if not isinstance(seeds, list | tuple) or not seeds or not _whole(seeds) or len(set(seeds)) != len(seeds):
            wanted = "seeds are whole numbers from 0 on, each once: a list, or a table with first and count"
            raise self.document.error(location, wanted)
        return tuple(seeds)

    def check(self, where: Mapping[str, object], seeds: Sequence[int] | None, location: Location) -> None:
        """Reject a choice of levels with an unknown axis or level; any seed may be named if `seeds` is None."""
        known: dict[str, list[str]] = {}
        for level in itertools.chain(*self.axes):
            for axis, name in level.place.items():
                known.setdefault(axis, []).append(name)
        known[SEED] = [] if seeds is None else [str(seed) for seed in seeds]
        for axis, wanted in where.items():
            if axis not in known:
                unknown = f"no axis is called '{axis}'{nearest(axis, known)}"
                raise self.document.error((*location, axis), unknown)
            for name in labels(wanted):
                if name not in known[axis] and not (axis == SEED and seeds is None):
                    near = nearest(name, filter(None, known[axis]))
                    raise self.document.error((*location, axis), f"the axis '{axis}' has no level '{name}'{near}")


def _whole(numbers: Iterable[object]) -> bool:
    return all(isinstance(each, int) and not isinstance(each, bool) and each >= 0 for each in numbers)


def _key(point: Point) -> tuple[str, ...]:
    return tuple(point.place.values())
