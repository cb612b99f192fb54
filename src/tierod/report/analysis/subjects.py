"""What can be analysed; a subject is a file of this package and an entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tierod.recording import Recording
from tierod.studies.content import Chart, Heading, Table
from tierod.vehicles import Vehicle

Shown = Heading | Table | Chart


@dataclass(frozen=True)
class Analysis:
    """What an analysis found.

    Args:
        title: a few words
        summary: paragraphs: what it comes to
        items: headings, tables and charts, one after the other; the terminal shows the tables
        document: the same as data, SI units, for JSON
        remarks: what a reader must know
        fits: whether the recording, where there is one, fits the model
    """

    title: str
    summary: tuple[str, ...]
    items: Sequence[Shown]
    document: Mapping[str, Any]
    remarks: tuple[str, ...] = field(default=())
    fits: bool = True


@dataclass(frozen=True)
class Subject:
    """One subject.

    Args:
        name: as given on the command line
        title: what is analysed, a few words
        analyse: from a vehicle, and a recording or None, its analysis; raises ParameterError where the vehicle lacks a
            parameter, InputError where the recording lacks a signal
        recordings: whether it makes use of a recording
    """

    name: str
    title: str
    analyse: Callable[[Vehicle, Recording | None], Analysis]
    recordings: bool = False


def _column(vehicle: Vehicle, recording: Recording | None) -> Analysis:
    from tierod.report.analysis.column import analyse

    return analyse(vehicle, recording)


def _sideslip(vehicle: Vehicle, recording: Recording | None) -> Analysis:
    from tierod.report.analysis.sideslip import analyse

    return analyse(vehicle)


SUBJECTS: Mapping[str, Subject] = {
    subject.name: subject
    for subject in (
        Subject("column", "modes, observability and reductions of a steering column", _column, True),
        Subject("sideslip", "what shows the sideslip of a car steered by wire", _sideslip),
    )
}
"""By name, as given on the command line."""
