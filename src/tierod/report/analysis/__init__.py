"""Catalogue of analyses; each subject is a module of this package and an entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from tierod.core.recording import Recording
from tierod.report.analysis.analysis import Analysis
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class Subject:
    """One subject of analysis.

    Args:
        name: as given on the command line
        title: analysed matter in a few words
        analyse: returns the analysis of a vehicle and a recording or None; raises ParameterError if the vehicle lacks a
            parameter, InputError if the recording lacks a signal
        recordings: whether the analysis can use a recording
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
"""Subjects by name, as given on the command line."""
