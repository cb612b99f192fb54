"""Identification of parameters from recordings: subjects, JSON document, page and vehicle file."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tierod.core.content import Fold, Item, Table
from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.files import holding, sha256_of, write_text
from tierod.core.recording import Recording
from tierod.core.shown import written
from tierod.core.user_files import read_text
from tierod.io.readers import ChannelMap, read
from tierod.io.readers.opening import Paths
from tierod.methods.identification.experiment import Found
from tierod.monitors.diagnose import source_of
from tierod.report.display import number
from tierod.report.html import Analysis, Origin, render_analysis
from tierod.vehicles import QUANTITIES, Vehicle, load
from tierod.vehicles.vehicle import read_by
from tierod.vehicles.writer import Change, changed, with_thresholds

# Module and attribute of each subject, by its name on the command line
SUBJECTS = {
    "column": "tierod.report.identification.column:COLUMN",
    "motor": "tierod.report.identification.motor:MOTOR",
    "inverter": "tierod.report.identification.motor:INVERTER",
    "thresholds": "tierod.report.identification.vehicle:THRESHOLDS",
    "vehicle": "tierod.report.identification.vehicle:VEHICLE",
}


@dataclass(frozen=True)
class Identification:
    """Result of an identification."""

    subject: Subject
    vehicle: Vehicle
    result: Any  # parameters and their fit, in the type of the subject
    recordings: Mapping[str, Recording]
    files: tuple[Path, ...] = ()  # paths of the recordings; empty if they were passed as objects

    @property
    def found(self) -> tuple[Found, ...]:
        """Parameters, in the order of the vehicle file."""
        found: tuple[Found, ...] = self.result.found
        return found

    @property
    def remarks(self) -> tuple[str, ...]:
        remarks: tuple[str, ...] = self.result.remarks
        return remarks

    @property
    def doubt(self) -> str:
        """Reason why the values must not be used; "" if they can be."""
        doubt: str = self.result.doubt
        return doubt

    @property
    def sources(self) -> list[str]:
        """Name and first digits of the SHA-256 of every file; names of recordings that were passed as objects."""
        return [_source(path) for path in self.files] or list(self.recordings)

    @property
    def analysis(self) -> Analysis:
        """Summary, remarks, tables and charts, for page and terminal."""
        warnings = (f"{name}: {text}" for name, each in self.recordings.items() for text in each.warnings)
        title = f"{self.subject.title} of {self.vehicle.name}, identified"
        items = list(self.subject.items(self.result))
        return Analysis(title, (self.subject.summary,), items, {}, (*self.remarks, *warnings))

    def document(self, origin: Origin | None = None) -> dict[str, Any]:
        """Content of the JSON document."""
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
        """Write the vehicle file with the identified values; comments and everything else stay unchanged."""
        origin = origin or Origin.now()
        made = f"on {origin.created[:10]} by tierod {origin.version}: {origin.command}"
        source = f"identified from {', '.join(self.sources)} {made}"
        changes = {each.name: Change(each.value, each.deviation, source) for each in self.found}
        # The file stays locked from reading to writing, because another identification may change it at the same time.
        with holding(Path(path)) as place:
            text = read_text(self.vehicle.path, "the vehicle file", ParameterError, keep_line_ends=True)
            text = changed(text, changes)
            for of, table in getattr(self.result, "thresholds", {}).items():
                text = with_thresholds(text, of, table)
            return write_text(place, text)

    def write_html(self, path: str | Path, origin: Origin | None = None) -> Path:
        """Write the HTML page of the identification."""
        car = self.vehicle
        facts = (("vehicle", car.name), ("vehicle file", str(car.path)), ("recordings", ", ".join(self.sources)))
        return write_text(path, render_analysis(self.analysis, facts, origin or Origin.now(), kind="identification"))


def subject_of(name: str) -> Subject:
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
    """Identify parameters of a vehicle from recordings of a test bench or a drive.

    Args:
        recordings: paths, or recordings by name; each is one experiment
        free: names of the parameters to identify; empty for the usual ones of the subject
        dbc: path(s) of CAN databases; None for those of the vehicle
        channel_map: path of a channel map; None for that of the vehicle
        start, stop: limits of the evaluated stretch of every file [s]; None for the whole file
        hours: for thresholds only: mean time between false alarms [h]; None for 1000
    """
    wanted = subject_of(subject)
    car = vehicle if isinstance(vehicle, Vehicle) else load(vehicle)
    if hours is not None and not wanted.takes_false_alarms:
        raise ParameterError(f"the identification of '{subject}' does not use a time between false alarms")
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
    """A recording read as for a diagnosis, reduced to the given signals; None for all of them."""
    source = source_of(path, car, dbc, channel_map, start, stop, signals)
    if isinstance(source, Recording):
        return source
    databases, used = read_by(car, dbc, channel_map)
    return read(source, dbc=databases, channel_map=used, names=signals)


def _source(path: Path) -> str:
    if not path.is_file():  # data from a pipe cannot be read a second time
        return path.name
    return f"{path.name} ({sha256_of(path)[:12]})"


_NOTE = "σ and interval hold with residuals that are coloured, and for this model."


class Subject(NamedTuple):
    """A subject of identification."""

    title: str
    summary: str  # description of the method, for the page
    identify: Callable[..., Any]  # function of vehicle, recordings, names of free parameters, and progress callback
    items: Callable[[Any], Iterable[Item]]  # tables and charts; a terminal shows the tables that are in no fold
    document: Callable[[Any], dict[str, Any]]  # entries of the JSON document besides the parameters
    takes_false_alarms: bool = False  # whether `identify` also takes the required hours between false alarms
    # returns the signals that are read, so that others can be skipped; None for all
    signals: Callable[[], tuple[str, ...] | None] = lambda: None


def before(vehicle: Vehicle) -> dict[str, tuple[float, float | None]]:
    """Value and standard deviation of every parameter in the vehicle file."""
    return {name: (each.value, each.standard_deviation) for name, each in vehicle.parameters.items()}


def found_table(found: Sequence[Found], beyond: str = "") -> Table:
    """Table of every parameter before and after identification."""
    rows = tuple(
        (
            each.name,
            f"{number(each.before)}" + (f" ± {number(each.before_deviation, 2)}" if each.before_deviation else ""),
            number(each.value, 6),
            number(each.deviation, 2),
            f"{number(each.low, 5)} to {number(each.high, 5)}",
            f"{100.0 * each.change:+.2f} %".replace("-", "−") if np.isfinite(each.change) else "–",
            written(QUANTITIES[each.name].unit),
            each.method,
        )
        for each in found
    )
    header = ("parameter", "before", "found", "σ", "95 % interval", "change", "unit", "by")
    return Table("Parameters before and after", header, rows, f"{_NOTE} {beyond}".strip())


def correlations(title: str, names: Sequence[str], covariance: np.ndarray) -> Fold:
    """Correlation of every pair of estimates; zero where one of them has no variance."""
    deviations = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        values = np.nan_to_num(covariance / np.outer(deviations, deviations))
    rows = tuple((name, *(f"{v:+.2f}".replace("-", "−") for v in row)) for name, row in zip(names, values, strict=True))
    return Fold(title, [Table("", ("", *names), rows)])
