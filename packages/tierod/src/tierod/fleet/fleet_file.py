"""The fleet file: vehicle, parameters, cohort and mileage of each recording.

    [[recordings]]
    pattern = 'recordings/(?P<vehicle>[^/]+)/(?P<climate>cold|warm)_.*[.]parquet'
    parameters = "midsize-eps"
    cohort = {supplier = "A"}

    [vehicles.car-17]
    parameters = "car-17.toml"
    cohort = {batch = "B7"}

The first matching entry of `recordings` applies. Entries of `[vehicles.NAME]` take precedence for a vehicle.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE
from tierod.core.files import expanded
from tierod.core.toml import Document, build
from tierod.core.units import scale
from tierod.fleet.places import fits, regular

OWN_GROUPS = ("vehicle", "mileage", "start")
"""Groups of a pattern with a fixed meaning; every other group is a label of the cohort."""


@dataclass(frozen=True)
class Entry:
    """Entry of the fleet file for some recordings, and the way to identify the vehicle of each."""

    # wildcard pattern that a recording's path, or its end from some folder on, must match; "" matches all
    files: str = ""
    # regular expression (RE2) searched for in the path; its group `vehicle` names the vehicle, `mileage` is a number,
    # `start` an ISO date and time (UTC where it has no offset), and other groups label the cohort
    pattern: str = ""
    vehicle: str = ""  # name of the vehicle of all these recordings
    metadata: str = ""  # entry of a recording's metadata that names the vehicle
    column: str = ""  # text column of a Parquet file that names the vehicle
    parameters: str = ""  # vehicle file or shipped name; if empty, the vehicle named in the recording
    cohort: Mapping[str, str] = field(default_factory=dict)  # labels of all these recordings
    cohort_metadata: tuple[str, ...] = ()  # entries of a recording's metadata that label the cohort
    mileage: Annotated[float, "m", NOT_NEGATIVE] | None = None  # mileage of the vehicle [m]
    mileage_metadata: str = ""
    mileage_unit: str = "km"

    def __post_init__(self) -> None:
        groups = regular(self.pattern).groupindex
        fits("", self.files)  # raises where it is no pattern
        ways = [self.vehicle, self.metadata, self.column, "vehicle" if "vehicle" in groups else ""]
        if sum(map(bool, ways)) != 1:
            raise ParameterError(
                "an entry of 'recordings' names the vehicle in one way: give one of 'vehicle', 'metadata', 'column', "
                "or a 'pattern' with a group (?P<vehicle>...)"
            )
        scale(self.mileage_unit, "m")

    @property
    def looks_inside(self) -> bool:
        """Whether the recording has to be opened to determine its vehicle, cohort or mileage."""
        return bool(self.metadata or self.column or self.cohort_metadata or self.mileage_metadata)


@dataclass(frozen=True)
class Single:
    """Description of one vehicle."""

    parameters: str = ""  # vehicle file or shipped name; if empty, that of the entry
    cohort: Mapping[str, str] = field(default_factory=dict)  # labels in addition to those of the entry
    # mileage if neither the entry nor the recording states it [m]
    mileage: Annotated[float, "m", NOT_NEGATIVE] | None = None


@dataclass(frozen=True)
class Assigned:
    """Vehicle assigned to a recording."""

    vehicle: str  # name of the individual vehicle
    parameters: str = ""  # path of its vehicle file, or a shipped name; "" for the vehicle named in the recording
    cohort: Mapping[str, str] = field(default_factory=dict)  # labels by kind of cohort
    mileage: Annotated[float, "m"] | None = None  # mileage [m]; None if unknown
    # start of the recording from its name, in seconds since 1970, UTC; None if the name has none
    start: Annotated[float, "s"] | None = None


@dataclass(frozen=True)
class Fleet:
    """Content of a fleet file."""

    recordings: tuple[Entry, ...]  # entries, of which the first that matches applies
    vehicles: Mapping[str, Single] = field(default_factory=dict)
    source: str = "the fleet"  # path of the file, for messages

    def entry(self, name: str) -> Entry:
        """The entry that matches a recording."""
        for each in self.recordings:
            if (not each.files or fits(name, each.files)) and regular(each.pattern).search(name):
                return each
        raise ParameterError(f"no entry of 'recordings' in {self.source} fits it: give it one with its vehicle")

    def assigned(self, name: str, metadata: Mapping[str, Any], column: str | None = None) -> Assigned:
        """Vehicle, cohort and mileage of a recording."""
        entry = self.entry(name)
        found = regular(entry.pattern).search(name)
        groups = {key: value for key, value in (found.groupdict() if found else {}).items() if value}
        vehicle = groups.get("vehicle") or entry.vehicle
        if entry.metadata:
            vehicle = _text(metadata, entry.metadata)
        elif entry.column:
            if not column:
                raise ParameterError(f"it has no text column '{entry.column}', which would name its vehicle")
            vehicle = column
        labels = {key: value for key, value in groups.items() if key not in OWN_GROUPS}
        labels |= {key: _text(metadata, key) for key in entry.cohort_metadata}
        single = self.vehicles.get(vehicle, Single())
        mileage = _mileage(entry, groups, metadata)
        return Assigned(
            vehicle,
            single.parameters or entry.parameters,
            dict(sorted({**entry.cohort, **labels, **single.cohort}.items())),
            single.mileage if mileage is None else mileage,
            _date(groups["start"]) if "start" in groups else None,
        )


def _text(metadata: Mapping[str, Any], key: str) -> str:
    value = metadata.get(key)
    if not isinstance(value, str | int) or value == "":
        raise ParameterError(f"its metadata hold no text '{key}'{nearest(key, map(str, metadata))}")
    return str(value)


def _mileage(entry: Entry, groups: Mapping[str, str], metadata: Mapping[str, Any]) -> float | None:
    given: Any = groups.get("mileage")
    if given is None and entry.mileage_metadata:
        given = metadata.get(entry.mileage_metadata)
    if given is None:
        return entry.mileage
    try:
        return float(scale(entry.mileage_unit, "m")(float(given)))
    except (TypeError, ValueError):
        raise ParameterError(f"its mileage is {str(given)[:40]!r}, which is not a number") from None


def _date(text: str) -> float:
    shown = text.replace("_", "T") if "T" not in text else text
    try:
        date = dt.datetime.fromisoformat(shown)
    except ValueError:
        raise ParameterError(f"by its name it begins at '{text}', which is not an ISO date and time") from None
    return (date if date.tzinfo else date.replace(tzinfo=dt.UTC)).timestamp()


def one_vehicle(parameters: str) -> Fleet:
    """Fleet without a file: all recordings belong to the vehicle of one vehicle file."""
    return Fleet((Entry(vehicle=Path(parameters).stem if "/" in parameters else parameters, parameters=parameters),))


def load(path: str | Path) -> Fleet:
    """Read a fleet file; relative paths in it start from its own folder.

    Raises:
        ParameterError: the file cannot be read, or has an error; the message names the line
    """
    document = Document.read(path, "fleet")
    fleet: Fleet = build(Fleet, {**document.content, "source": str(path)}, document)
    if not fleet.recordings:
        raise ParameterError(f"{path}: no [[recordings]]; assign the recordings to their vehicles")
    folder = expanded(path).absolute().parent
    entries = tuple(replace(each, parameters=_beside(folder, each.parameters)) for each in fleet.recordings)
    singles = {k: replace(each, parameters=_beside(folder, each.parameters)) for k, each in fleet.vehicles.items()}
    return replace(fleet, recordings=entries, vehicles=singles)


def _beside(folder: Path, parameters: str) -> str:
    """Absolute path of a vehicle file given relative to the fleet file; a shipped name is kept."""
    return str(folder / parameters) if parameters.endswith(".toml") or "/" in parameters else parameters
