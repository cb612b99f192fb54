"""Content of a campaign file: base scenario, matrix of its variations, monitors, and gates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE

LEARNT = "first fault-free drive"
"""Name of the baseline that is learnt from the first fault-free drive of the same car."""


@dataclass(frozen=True)
class Axis:
    """One axis of the matrix, with the changes of every level.

    Args:
        set: dotted name in the scenario that takes the `values`; the name of the axis if empty
        values: values of the levels, which are named as they are written
        levels: alternative to values: name -> changes of the scenario by dotted name; an empty table changes nothing
    """

    set: str = ""
    values: tuple[Any, ...] = ()
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
    """A monitor with its parameters.

    Args:
        monitor: name, as listed by `tierod monitors`
        vehicle: parameter set of the monitor, a name or a file
        variant: variant of the monitor; its default if empty
        label: name in the campaign; monitor and variant if empty
    """

    monitor: str
    vehicle: str
    baseline: Literal["none", "first fault-free drive"]
    variant: str = ""
    label: str = ""


@dataclass(frozen=True)
class GateEntry:
    """A gate: a limit on a figure of the campaign.

    Args:
        figure: field of `tierod_lab.campaign.pools.Pool`
        where: axis -> level, or a list of levels; the whole campaign if empty
        monitor: label; optional if there is one monitor only
    """

    figure: str
    goal: str
    where: Mapping[str, Any] = field(default_factory=dict)
    monitor: str = ""


@dataclass(frozen=True)
class CampaignFile:
    """Content of a campaign file.

    Args:
        name: short name, for titles
        scenario: base scenario of all drives: name of a shipped scenario, or a file beside this one
        monitors: monitors that judge every drive
        seeds: seeds of the drives; the innermost axis
        changes: changes of the scenario by dotted name, for all drives
        axes: name -> axis, outermost first
        faults: name -> table of a fault as in a scenario, with its `sizes`, one level each; `together` lists further
            faults that act at the same time; the faults form one axis, after the fault-free drive
        exclude: axis -> level or levels: cells that are removed
        include: axis -> level or levels, and "seeds": cells that are added; other axes take all their levels
        same_car: axes that define a car: drives with equal levels of them are drives of the same car
        settling: enabled time from the onset of a fault until estimates are attributed to the fault
    """

    name: str
    description: str
    scenario: str
    monitors: tuple[MonitorChoice, ...]
    seeds: Seeds | tuple[int, ...]
    changes: Mapping[str, Any] = field(default_factory=dict)
    axes: Mapping[str, Axis] = field(default_factory=dict)
    faults: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    fault_free: bool = True
    exclude: tuple[Mapping[str, Any], ...] = ()
    include: tuple[Mapping[str, Any], ...] = ()
    same_car: tuple[str, ...] | None = None
    settling: Annotated[float, "s", NOT_NEGATIVE] = 50.0
    keep: Literal["recordings", "verdicts"] = "recordings"
    gates: tuple[GateEntry, ...] = ()


def label(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)


def labels(levels: object) -> list[str]:
    return [label(level) for level in (levels if isinstance(levels, list | tuple) else [levels])]
