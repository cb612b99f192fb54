"""Analyse a vehicle from its parameters alone: modes, observability, model reduction."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tierod.core.recording import Recording
    from tierod.vehicles import Vehicle


def analyse(
    subject: Annotated[str, typer.Argument(help="What to analyse: column or sideslip.")],
    vehicle: Annotated[
        str, typer.Option(help="A vehicle's name (see 'tierod vehicles') or the path of its TOML file.")
    ],
    recording: Annotated[
        Path | None, typer.Option(help="A recording whose frequency response is compared with the model's.")
    ] = None,
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="HTML page to write; in the current folder if not given.")
    ] = None,
    report: Annotated[bool, typer.Option(help="Write the HTML page.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Analyse a part of a vehicle, in tables and charts: done (0), the recording does not fit (2), bad input (3)."""
    from tierod.cli.app import HEALTHY, NOT_JUDGED
    from tierod.cli.terminal import present, refuse_to_overwrite
    from tierod.core.errors import ParameterError, nearest
    from tierod.report.analysis import SUBJECTS
    from tierod.report.analysis.analysis import facts_of
    from tierod.vehicles import load

    if subject not in SUBJECTS:
        raise ParameterError(f"'{subject}' cannot be analysed{nearest(subject, SUBJECTS)}")
    if recording is not None and not SUBJECTS[subject].recordings:
        raise ParameterError(f"the analysis of '{subject}' does not use a recording; leave --recording out")
    car = load(vehicle)
    target = (output or Path(f"{car.name}-{subject}.html")) if report else None
    refuse_to_overwrite(target, [car.path, recording, channel_map, *(dbc or [])])
    found = SUBJECTS[subject].analyse(car, _read(recording, dbc, channel_map, car))
    content = {"subject": subject, "vehicle": car.name, "remarks": list(found.remarks), **found.document}
    facts = facts_of(car, recording.name if recording else "")
    present(found, {"schema": "tierod.analysis/1", **content}, as_json, target, facts, car.not_good_for)
    return HEALTHY if found.fits else NOT_JUDGED


def _read(path: Path | None, dbc: list[Path] | None, channel_map: Path | None, car: Vehicle) -> Recording | None:
    if path is None:
        return None
    from tierod.io.derive import complete
    from tierod.io.readers import read
    from tierod.vehicles.reading import read_by

    databases, used = read_by(car, dbc, channel_map)
    return complete(read(path, dbc=databases, channel_map=used))
