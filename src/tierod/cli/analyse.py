"""Say what the parameters of a vehicle tell before it moves: modes, observability, reductions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tierod.recording import Recording
    from tierod.report.analysis.subjects import Analysis
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
        Path | None, typer.Option("--output", "-o", help="Where the HTML page goes; beside you where not given.")
    ] = None,
    report: Annotated[bool, typer.Option(help="Write the HTML page.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Analyse a part of a vehicle: tables to the terminal, a page with charts, JSON with --json."""
    from tierod.cli.terminal import messages, print_json
    from tierod.cli.terminal import output as console
    from tierod.errors import ParameterError, nearest
    from tierod.report.analysis.subjects import SUBJECTS
    from tierod.vehicles import load

    if subject not in SUBJECTS:
        raise ParameterError(f"'{subject}' cannot be analysed{nearest(subject, SUBJECTS)}")
    if recording is not None and not SUBJECTS[subject].recordings:
        raise ParameterError(f"the analysis of '{subject}' makes no use of a recording; leave --recording out")
    car = load(vehicle)
    target = (output or Path(f"{car.name}-{subject}.html")) if report else None
    _refuse_to_overwrite(target, [car.path, recording, channel_map, *(dbc or [])])
    found = SUBJECTS[subject].analyse(car, _read(recording, dbc, channel_map, car))
    if target is not None:
        _write(found, car, recording, target)
    if as_json:
        print_json({"schema": "tierod.analysis/1", "subject": subject, "vehicle": car.name, **found.document})
    else:
        _show(found)
    if target is not None:
        (messages() if as_json else console()).print(f"page: {target}", soft_wrap=True, markup=False)
    return 0


def _read(path: Path | None, dbc: list[Path] | None, channel_map: Path | None, car: Vehicle) -> Recording | None:
    if path is None:
        return None
    from tierod.derive import complete
    from tierod.readers import read

    databases = dbc or ([car.database] if car.database else None)
    return complete(read(path, dbc=databases, channel_map=channel_map or car.channel_map))


def _refuse_to_overwrite(target: Path | None, given: list[Path | None]) -> None:
    from tierod.errors import OutputError

    if target is not None and any(path is not None and path.resolve() == target.resolve() for path in given):
        raise OutputError(f"the page would overwrite {target}, which was given; name another place with --output")


def _write(found: Analysis, car: Vehicle, recording: Path | None, target: Path) -> None:
    import shlex
    import sys
    from datetime import UTC, datetime

    from tierod import __version__
    from tierod.files import write_text
    from tierod.report.analysis.page import Origin, render_analysis

    created = datetime.now(UTC).isoformat(timespec="seconds")
    origin = Origin(created, __version__, shlex.join(["tierod", *sys.argv[1:]]), recording.name if recording else "")
    write_text(target, render_analysis(found, car, origin))


def _show(found: Analysis) -> None:
    """Summary and tables."""
    from rich.text import Text

    from tierod.cli.terminal import output, rows
    from tierod.studies.content import Table

    console = output()
    console.print(Text(found.title, style="bold"))
    for paragraph in (*found.summary, *(f"To know: {remark}" for remark in found.remarks)):
        console.print(Text(paragraph))
    for item in found.items:
        if isinstance(item, Table):
            console.print(Text(f"\n{item.title}", style="bold"))
            console.print(rows(item.header, item.rows, right=item.numeric))
            if item.note:
                console.print(Text(item.note))
