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


def levels_of(file: CampaignFile, document: Document) -> list[list[Level]]:
    """Levels of every axis, the faults last."""
    axes = []
    for name, axis in file.axes.items():
        if name in (FAULT, SIZE, SEED, SEEDS):
            raise document.error(("axes", name), f"an axis cannot be called '{name}', which every campaign has")
        levels = [
            Level({name: label}, changes, ("axes", name, *location)) for label, changes, location in axis.changes(name)
        ]
        axes.append(_distinct(levels, document))
    faults = [Level({FAULT: FAULT_FREE, SIZE: ""}, {}, ("fault_free",))] if file.fault_free else []
    for name in file.faults:
        if name == FAULT_FREE:
            raise document.error(
                ("faults", name), f"a fault cannot be called '{FAULT_FREE}', which is a drive without one"
            )
        faults += _distinct(_sizes(file, name, document), document)
    if not faults:
        raise document.error(
            ("fault_free",), "the matrix is empty: there are no faults, and fault-free drives are left out"
        )
    return [*axes, faults]


def _sizes(file: CampaignFile, name: str, document: Document) -> list[Level]:
    table = dict(file.faults[name])
    location: Location = ("faults", name)
    sizes, together = table.pop("sizes", None), table.pop("together", [])
    if not isinstance(together, list) or not (sizes is None or (isinstance(sizes, list) and sizes)):
        raise document.error(location, "'sizes' is a list of sizes, 'together' a list of further faults; correct that")
    if sizes is not None and "size" in table:
        raise document.error((*location, "size"), "'size' and 'sizes' state the same; leave one out")
    others = [fault_of(each, document, (*location, "together", at)) for at, each in enumerate(together)]
    table.setdefault("name", name)
    levels = []
    for at, size in enumerate([None] if sizes is None else sizes):
        sized = table if size is None else table | {"size": size}
        faults = (fault_of(sized, document, location), *others)
        place = {FAULT: name, SIZE: "" if size is None else label(size)}
        levels.append(
            Level(place, {}, location if size is None else (*location, "sizes", at), faults, (sized, *together))
        )
    return levels


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


def _distinct(levels: Sequence[Level], document: Document) -> list[Level]:
    seen: dict[tuple[str, ...], Level] = {}
    for level in levels:
        key = tuple(level.place.values())
        if key in seen:
            raise document.error(level.location, f"there are two levels '{' '.join(filter(None, key))}'; take one out")
        seen[key] = level
    return list(levels)


def points(file: CampaignFile, document: Document) -> list[Point]:
    """All cells of the matrix, in its order; included cells are last."""
    axes = levels_of(file, document)
    seeds = _checked_seeds(file.seeds, ("seeds",), document)
    found = {_key(point): point for point in _product(axes, seeds, document, ("seeds",))}
    for number, where in enumerate(file.exclude):
        location = ("exclude", number)
        check_where(where, axes, seeds, document, location)
        gone = [key for key, point in found.items() if is_at(point.place, where)]
        if not gone:
            raise document.error(location, "this excludes no cell that is left; take it out")
        for key in gone:
            del found[key]
    for number, where in enumerate(file.include):
        for point in _included(where, axes, seeds, document, ("include", number)):
            found.setdefault(_key(point), point)
    if not found:
        raise document.error(("exclude",), "every cell of the matrix is excluded; leave some")
    return list(found.values())


def _product(
    axes: Sequence[Sequence[Level]], seeds: Sequence[int], document: Document, location: Location
) -> list[Point]:
    cells = math.prod(map(len, axes)) * len(seeds)
    if cells > MOST_CELLS:
        raise document.error(location, f"with these seeds the matrix has {cells} cells; give at most {MOST_CELLS}")
    made = []
    for levels in itertools.product(*axes):
        place: dict[str, str] = {}
        for level in levels:
            place |= level.place
        made += [Point(place | {SEED: str(seed)}, levels, seed) for seed in seeds]
    return made


def _included(
    where: Mapping[str, object], axes: list[list[Level]], seeds: tuple[int, ...], document: Document, location: Location
) -> list[Point]:
    own = where.get(SEEDS)
    if own is not None:
        seeds = _checked_seeds(own, (*location, SEEDS), document)
    chosen = {axis: level for axis, level in where.items() if axis != SEEDS}
    check_where(chosen, axes, seeds, document, location)
    return [point for point in _product(axes, seeds, document, location) if is_at(point.place, chosen)]


def _checked_seeds(seeds: Any, location: Location, document: Document) -> tuple[int, ...]:
    if isinstance(seeds, Mapping) and set(seeds) == {"first", "count"} and _whole(seeds.values()):
        seeds = Seeds(**seeds)
    if isinstance(seeds, Seeds):
        if seeds.count > MOST_CELLS:
            raise document.error(location, f"these are {seeds.count} seeds; give at most {MOST_CELLS}")
        seeds = tuple(range(seeds.first, seeds.first + seeds.count))
    if not isinstance(seeds, list | tuple) or not seeds or not _whole(seeds) or len(set(seeds)) != len(seeds):
        raise document.error(
            location, "seeds are whole numbers from 0 on, each once: a list, or a table with first and count"
        )
    return tuple(seeds)


def _whole(numbers: Iterable[object]) -> bool:
    return all(isinstance(each, int) and not isinstance(each, bool) and each >= 0 for each in numbers)


def check_where(
    where: Mapping[str, object],
    axes: Iterable[Sequence[Level]],
    seeds: Sequence[int] | None,
    document: Document,
    location: Location,
) -> None:
    """Reject a choice of levels with an unknown axis or level."""
    known: dict[str, list[str]] = {}
    for level in itertools.chain(*axes):
        for axis, name in level.place.items():
            known.setdefault(axis, []).append(name)
    known[SEED] = [] if seeds is None else [str(seed) for seed in seeds]
    for axis, wanted in where.items():
        if axis not in known:
            raise document.error((*location, axis), f"no axis is called '{axis}'{nearest(axis, known)}")
        for name in labels(wanted):
            if name not in known[axis] and not (axis == SEED and seeds is None):
                near = nearest(name, filter(None, known[axis]))
                raise document.error((*location, axis), f"the axis '{axis}' has no level '{name}'{near}")


def _key(point: Point) -> tuple[str, ...]:
    return tuple(point.place.values())
