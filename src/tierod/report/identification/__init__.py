"""Identification of parameters from recordings: what can be identified, its document, its page, the vehicle file."""

from __future__ import annotations

import hashlib
import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.files import holding, write_text
from tierod.core.recording import Recording
from tierod.core.user_files import read_text
from tierod.io.readers import ChannelMap, read
from tierod.io.readers.opening import Paths
from tierod.methods.identification.experiment import Found
from tierod.monitors.several import source_of
from tierod.report.analysis.analysis import Analysis, render_analysis
from tierod.report.html import Origin
from tierod.report.identification.subject import Subject
from tierod.vehicles import QUANTITIES, Vehicle, load
from tierod.vehicles.reading import read_by
from tierod.vehicles.writer import Change, changed, with_thresholds

SUBJECTS = {
    "column": "tierod.report.identification.column:COLUMN",
    "motor": "tierod.report.identification.motor:MOTOR",
    "inverter": "tierod.report.identification.motor:INVERTER",
    "thresholds": "tierod.report.identification.thresholds:THRESHOLDS",
    "vehicle": "tierod.report.identification.vehicle:VEHICLE",
}
"""Where each is defined, by the name that the command line takes."""


@dataclass(frozen=True)
class Identification:
    """Result of an identification.

    Args:
        subject: what was asked for
        vehicle: where the search started
        result: parameters and how well they fit, in the terms of the subject
        recordings: by their names
        files: where they came from; empty where they were given as recordings
    """

    subject: Subject
    vehicle: Vehicle
    result: Any
    recordings: Mapping[str, Recording]
    files: tuple[Path, ...] = ()

    @property
    def found(self) -> tuple[Found, ...]:
        """Parameters, in the order of the vehicle file."""
        found: tuple[Found, ...] = self.result.found
        return found

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the identification."""
        remarks: tuple[str, ...] = self.result.remarks
        return remarks

    @property
    def doubt(self) -> str:
        """Why the values may not be used; empty where they may."""
        doubt: str = self.result.doubt
        return doubt

    @property
    def sources(self) -> list[str]:
        """Name and begin of the SHA-256 of every file; names where recordings were given."""
        return [_source(path) for path in self.files] or list(self.recordings)

    def document(self, origin: Origin | None = None) -> dict[str, Any]:
        """The same as data for JSON.

        Args:
            origin: how it came about
        """
        origin = origin or Origin.now()
        return {
            "schema": "tierod.identification/1",
            "subject": self.subject.title.lower(),
            "created": origin.created,
            "version": origin.version,
            "command": origin.command,
            "vehicle": self.vehicle.name,
            "recordings": self.sources,
            "parameters": [
                {
                    "name": each.name,
                    "unit": QUANTITIES[each.name].unit,
                    "before": each.before if each.before == each.before else None,
                    "before_standard_deviation": each.before_deviation,
                    "value": each.value,
                    "standard_deviation": each.deviation,
                    "interval": [each.low, each.high],
                    "method": each.method,
                }
                for each in self.found
            ],
            **self.subject.document(self.result),
            "remarks": list(self.remarks),
        }

    def write_vehicle(self, path: str | Path, origin: Origin | None = None) -> Path:
        """Write the vehicle file with the values found; its comments and all else stay as they are.

        Args:
            path: of the new file, or of the vehicle's own
            origin: how the values came about, for their source
        """
        origin = origin or Origin.now()
        made = f"on {origin.created[:10]} by tierod {origin.version}: {origin.command}"
        source = f"identified from {', '.join(self.sources)} {made}"
        changes = {each.name: Change(each.value, each.deviation, source) for each in self.found}
        # Read and written as one: another parameter may be found at the same time.
        with holding(Path(path)) as place:
            text = read_text(self.vehicle.path, "the vehicle file", ParameterError, keep_line_ends=True)
            text = changed(text, changes)
            for of, table in getattr(self.result, "thresholds", {}).items():
                text = with_thresholds(text, of, table)
            return write_text(place, text)

    def write_html(self, path: str | Path, origin: Origin | None = None) -> Path:
        """Write the page.

        Args:
            path: of the page
            origin: how it came about
        """
        origin, car = origin or Origin.now(), self.vehicle
        facts = (("vehicle", car.name), ("vehicle file", str(car.path)), ("recordings", ", ".join(self.sources)))
        warnings = (f"{name}: {text}" for name, each in self.recordings.items() for text in each.warnings)
        page = Analysis(
            f"{self.subject.title} of {car.name}, identified",
            (self.subject.summary,),
            list(self.subject.items(self.result)),
            {},
            (*self.remarks, *warnings),
        )
        return write_text(path, render_analysis(page, facts, origin, kind="identification"))


def subject_of(name: str) -> Subject:
    """Subject of identification under a name.

    Raises:
        ParameterError: there is no such subject
    """
    if name not in SUBJECTS:
        raise ParameterError(f"'{name}' cannot be identified{nearest(name, SUBJECTS)}")
    module, _, attribute = SUBJECTS[name].partition(":")
    subject: Subject = getattr(importlib.import_module(module), attribute)
    return subject


def identify(
    subject: str,
    recordings: Sequence[str | Path] | Mapping[str, Recording],
    vehicle: Vehicle | str | Path,
    free: Sequence[str] = (),
    *,
    dbc: Paths = None,
    channel_map: str | Path | ChannelMap | None = None,
    start: float | None = None,
    stop: float | None = None,
    hours: float | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Identification:
    """Parameters of a vehicle from recordings of a bench or a drive.

    Args:
        subject: "vehicle", "column", "motor", "inverter" or "thresholds"
        recordings: paths, or recordings by name; one experiment each or more
        vehicle: where the search starts: a parameter set, its name, or the path of its file
        free: names of the parameters to find; the usual ones of the subject where not given
        dbc: path(s) of CAN databases; the vehicle's own where not given
        channel_map: path of a channel map; the vehicle's own where not given
        start, stop: of the stretch of every file that is looked at [s]; all of it where not given
        hours: of thresholds: wanted mean time between false alarms [h]; 1000 where not given
        progress: called with the share done, 0 to 1

    Raises:
        InputError: a recording cannot be read, is given twice, or does not hold what is needed
        ParameterError: no such subject, vehicle or parameter
    """
    wanted = subject_of(subject)
    car = vehicle if isinstance(vehicle, Vehicle) else load(vehicle)
    if hours is not None and not wanted.takes_false_alarms:
        raise ParameterError(f"the identification of '{subject}' makes no use of a time between false alarms")
    if isinstance(recordings, Mapping):
        files: tuple[Path, ...] = ()
        known = dict(recordings)
    else:
        files = tuple(map(Path, recordings))
        _refuse_twice(files)
        read_one = partial(_read, car, dbc, channel_map, start, stop, wanted.signals())
        known = {_name(path, files): read_one(path) for path in files}
    rate = {} if hours is None else {"hours": hours}
    result = wanted.identify(car, known, tuple(free), progress, **rate)
    return Identification(wanted, car, result, known, files)


def _refuse_twice(paths: Sequence[Path]) -> None:
    for path in paths:
        if any(path.resolve() == other.resolve() for other in paths if other is not path):
            raise InputError(f"{path} is given twice; every experiment counts once")


def _name(path: Path, paths: Sequence[Path]) -> str:
    """A name of its own for one of several files."""
    return path.name if [each.name for each in paths].count(path.name) == 1 else str(path)


def _read(
    car: Vehicle,
    dbc: Paths,
    channel_map: str | Path | ChannelMap | None,
    start: float | None,
    stop: float | None,
    signals: tuple[str, ...] | None,
    path: Path,
) -> Recording:
    """A recording as a diagnosis reads it, with the signals that are looked at, all where None."""
    source = source_of(path, car, dbc, channel_map, start, stop, signals)
    if isinstance(source, Recording):
        return source
    databases, used = read_by(car, dbc, channel_map)
    return read(source, dbc=databases, channel_map=used, names=signals)


def _source(path: Path) -> str:
    if not path.is_file():  # what came through a pipe cannot be read again
        return path.name
    with path.open("rb") as file:
        return f"{path.name} ({hashlib.file_digest(file, 'sha256').hexdigest()[:12]})"
