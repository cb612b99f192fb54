"""Catalogue of analyses; a subject is a file of this package and an entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from tierod.core.recording import Recording
from tierod.report.analysis.analysis import Analysis
from tierod.vehicles import Vehicle


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
