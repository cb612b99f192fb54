"""Judge a recording: a verdict in the terminal, an HTML report, JSON with --json."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from tierod.core.findings import Diagnosis


RecordingPath = Annotated[
    Path, typer.Argument(help="A recording: MF4, Parquet, CSV, a CAN log and others (see 'tierod formats').")
]
VehicleName = Annotated[
    str | None,
    typer.Option(
        help="A vehicle's name (see 'tierod vehicles') or the path of its TOML file; the one that the recording "
        "names where not given."
    ),
]
MonitorName = Annotated[
    str | None,
    typer.Option(
        help="What to watch (see 'tierod monitors'); what the vehicle file names where not given, else friction."
    ),
]
VariantName = Annotated[
    str | None, typer.Option(help="How to watch it; the monitor's default where not given and it has one.")
]
Databases = Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")]
ChannelMap = Annotated[
    Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
]
ReportPath = Annotated[
    Path | None, typer.Option("--output", "-o", help="Where the HTML report goes; beside you where not given.")
]
OwnLevelPath = Annotated[
    Path | None,
    typer.Option(help="File with this car's own level; written by the first healthy recording, then judged against."),
]
MemoryPath = Annotated[
    Path | None,
    typer.Option(help="Fault memory that takes the recording as one operation cycle; see 'tierod faults read'."),
]
SignalsPath = Annotated[
    Path | None,
    typer.Option(
        help="Recording to write: what the monitor reads and estimates over time, with what replaces a faulty sensor "
        "(.parquet, .csv, .mf4)."
    ),
]
WithReport = Annotated[bool, typer.Option(help="Write the HTML report.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")]


def diagnose(
    recording: RecordingPath,
    vehicle: VehicleName = None,
    monitor: MonitorName = None,
    variant: VariantName = None,
    dbc: Databases = None,
    channel_map: ChannelMap = None,
    output: ReportPath = None,
    own_level: OwnLevelPath = None,
    memory: MemoryPath = None,
    signals: SignalsPath = None,
    report: WithReport = True,
    as_json: AsJson = False,
) -> int:
    """Judge a recording of a drive: healthy (0), fault (1), could not judge (2), bad input (3)."""
    from tierod.cli.terminal import messages, progress
    from tierod.cli.terminal import output as console
    from tierod.monitors.diagnose import diagnose as run
    from tierod.monitors.diagnose import usual_monitor
    from tierod.vehicles import load

    vehicle = _named_in(recording, dbc, channel_map) if vehicle is None else vehicle
    car = load(vehicle)
    monitor = monitor or usual_monitor(car)
    target = output or Path(f"{recording.stem}-{monitor}.html") if report else None
    _refuse_what_cannot_be_written(
        target, signals, own_level, [recording, vehicle, *(dbc or []), channel_map, own_level, memory]
    )
    with progress(f"reading {recording.name}") as advance:
        diagnosis = run(
            recording,
            car,
            monitor,
            variant,
            dbc=dbc or None,
            channel_map=channel_map,
            own_level=own_level,
            memory=memory,
            signals=signals,
            command=shlex.join(["tierod", *sys.argv[1:]]),
            progress=advance,
        )
    show(diagnosis, as_json, target, console, messages)
    remarks = [] if signals is None else [f"signals: {signals}"]
    remarks += [
        f"{name}: {diagnosis.remarks[name]}" for name in ("baseline", "fault memory") if name in diagnosis.remarks
    ]
    for line in remarks:
        (messages() if as_json else console()).print(line, soft_wrap=True, markup=False)
    return diagnosis.findings[0].status.exit_code


def _named_in(recording: Path, dbc: list[Path] | None, channel_map: Path | None) -> str:
    """The vehicle that a recording names; a message says which."""
    from tierod.cli.terminal import messages
    from tierod.monitors.harness.named_vehicle import vehicle_named_in

    name = vehicle_named_in(recording, dbc or None, channel_map)
    messages().print(
        f"vehicle: {name}, as the recording names it; --vehicle takes another", soft_wrap=True, markup=False
    )
    return name


def _refuse_what_cannot_be_written(
    report: Path | None, signals: Path | None, own_level: Path | None, given: Sequence[Path | str | None]
) -> None:
    """Before the memory takes the recording: judged once more, it would count twice."""
    from tierod.cli.terminal import refuse_to_overwrite
    from tierod.core.files import require_folder

    refuse_to_overwrite(report, given)
    refuse_to_overwrite(signals, [*given, report], "recording", "--signals")
    for path in filter(None, (report, own_level)):
        require_folder(path)


def show(
    diagnosis: Diagnosis,
    as_json: bool,
    path: Path | None,
    console: Callable[[], Console],
    messages: Callable[[], Console],
) -> None:
    """Report file first, so that a failure to write it comes before the verdict; then table or JSON."""
    from tierod.report import print_table, to_json, write_html

    if path is not None:
        write_html(diagnosis, path)
    if as_json:
        from tierod.cli.terminal import print_json

        print_json(to_json(diagnosis))
    else:
        print_table(diagnosis, console())
    if path is not None:
        (messages() if as_json else console()).print(f"report: {path}", soft_wrap=True, markup=False)
