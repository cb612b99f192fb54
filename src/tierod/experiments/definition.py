"""Content of a campaign file: the base scenario, the matrix around it, the monitors, and the gates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE

LEARNT = "first fault-free drive"
"""Baseline that a monitor judges against: learnt from the first fault-free drive of the same car."""


@dataclass(frozen=True)
class Axis:
    """One direction of the matrix: what differs from level to level.

    Args:
        set: dotted name in the scenario that takes the `values`; the name of the axis where it is empty
        values: one level each, named as they are written
        levels: in place of values: name -> changes of the scenario by dotted name; an empty table changes nothing
    """

    set: str = ""
    values: tuple[Any, ...] = ()
    levels: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if bool(self.values) == bool(self.levels):
            raise ParameterError("an axis has either values or levels; give one of them")
        if self.set and self.levels:
            raise ParameterError("'set' belongs to values; levels say themselves what they change")

    def changes(self, name: str) -> list[tuple[str, Mapping[str, Any], tuple[str | int, ...]]]:
        """(level, changes of the scenario, where it stands in the axis) of every level."""
        if self.levels:
            return [(level, changes, ("levels", level)) for level, changes in self.levels.items()]
        return [(label(value), {self.set or name: value}, ("values", at)) for at, value in enumerate(self.values)]


@dataclass(frozen=True)
class Seeds:
    """Consecutive seeds."""

    first: Annotated[int, "", NOT_NEGATIVE]
    count: Annotated[int, "", POSITIVE]


@dataclass(frozen=True)
class MonitorChoice:
    """A monitor with its parameters.

    Args:
        monitor: as `tierod monitors` lists them
        vehicle: parameter set of the monitor, a name or a file
        variant: of the monitor; its default where empty
        baseline: baseline, "none" or learnt from the "first fault-free drive" (fault-free) of the same car
        label: how the campaign calls it; monitor and variant where empty
    """

    monitor: str
    vehicle: str
    baseline: Literal["none", "first fault-free drive"]
    variant: str = ""
    label: str = ""


@dataclass(frozen=True)
class GateEntry:
    """A limit on a figure of the campaign.

    Args:
        figure: of `tierod.experiments.pools.Pool`
        goal: "<= 60", ">= 0.999", "= 0" or "1 to 2"
        where: axis -> level, or a list of levels; the whole campaign where empty
        monitor: label; may be left out where there is one monitor only
    """

    figure: str
    goal: str
    where: Mapping[str, Any] = field(default_factory=dict)
    monitor: str = ""


@dataclass(frozen=True)
class CampaignFile:
    """A campaign file as a whole.

    Args:
        name: short, for titles
        description: one sentence
        scenario: what every drive begins from: name of a shipped scenario, or a file beside this one
        monitors: that judge every drive
        seeds: of the drives; the innermost axis
        changes: of the scenario by dotted name, for all drives
        axes: name -> axis, outermost first
        faults: name -> table of a fault as in a scenario, and its `sizes`, one level each; further faults that act with
            it stand in `together`; an axis of its own, with the fault-free drive before them
        fault_free: whether drives without a fault belong to the matrix
        exclude: axis -> level or levels: cells that are left out
        include: axis -> level or levels, and "seeds": cells that are added; axes that are not named have all levels
        same_car: axes that make a car what it is: drives that agree in them are drives of the same car
        settling: enabled time from the start of a fault until estimates count as those of the fault
        keep: whether recordings are kept beside the verdicts
        gates: limits on figures
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
    """Label of a level with this value."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)
