"""Judge a recording: a verdict in the terminal, an HTML report, JSON with --json."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import command_line, report_path

if TYPE_CHECKING:
    from tierod.core.findings import Diagnosis
    from tierod.core.recording import Recording
    from tierod.vehicles import Vehicle


RecordingPaths = Annotated[
    list[Path],
    typer.Argument(
        help="Recordings: MF4, Parquet, CSV, CAN logs and others (see 'tierod formats'); several on one page."
    ),
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
        help="Monitor to run (see 'tierod monitors'), or all. If not given: the one that the vehicle file names, for "
        "a single recording; else every monitor that can run."
    ),
]
VariantName = Annotated[str | None, typer.Option(help="Variant of the monitor; its default, if it has one.")]
StretchStart = Annotated[
    float | None, typer.Option("--from", help="Start of the stretch that is judged, in the recording's time [s].")
]
StretchStop = Annotated[float | None, typer.Option("--to", help="End of that stretch [s].")]
Databases = Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")]
ChannelMap = Annotated[
    Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
]
ReportPath = Annotated[
    Path | None, typer.Option("--output", "-o", help="HTML report to write; in the current folder if not given.")
]
BaselinePath = Annotated[
    Path | None,
    typer.Option(help="Baseline file of this car: written from the first healthy recording, read for all later ones."),
]
FaultFree = Annotated[
    bool,
    typer.Option(
        "--fault-free",
        help="You know that the car was fault-free in this recording: the baseline is learnt from it though guesses in "
        "the vehicle file forbid a verdict.",
    ),
]
MemoryPath = Annotated[
    Path | None,
    typer.Option(help="Fault memory to update, with the recording as one operation cycle; see 'tierod faults read'."),
]
SignalsPath = Annotated[
    Path | None,
    typer.Option(
        help="Recording to write: what the monitor reads and estimates over time, with what replaces a faulty sensor "
        "(.parquet, .csv, .mf4)."
    ),
]
WithSpread = Annotated[
    bool,
    typer.Option(
        help="Include the uncertainty of the parameters in intervals and verdict; without it, the run is faster."
    ),
]
WithReport = Annotated[bool, typer.Option(help="Write the HTML report.")]
Details = Annotated[
    bool, typer.Option("--details", help="Print all figures, limits and remarks, not the answer alone.")
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")]


def diagnose(
    recordings: RecordingPaths,
    vehicle: VehicleName = None,
    monitor: MonitorName = None,
    variant: VariantName = None,
    start: StretchStart = None,
    stop: StretchStop = None,
    dbc: Databases = None,
    channel_map: ChannelMap = None,
    output: ReportPath = None,
    baseline: BaselinePath = None,
    fault_free: FaultFree = False,
    memory: MemoryPath = None,
    signals: SignalsPath = None,
    spread: WithSpread = True,
    report: WithReport = True,
    details: Details = False,
    as_json: AsJson = False,
) -> int:
    """Judge recordings: healthy (0), fault (1), could not judge (2), bad input (3); of several recordings the worst."""
    from tierod.core.errors import ParameterError
    from tierod.monitors.diagnose import ALL
    from tierod.vehicles import load

    if fault_free and baseline is None:
        raise ParameterError("--fault-free lets a baseline be learnt: name its file with --baseline")
    named = [_named_in(each, dbc, channel_map) if vehicle is None else vehicle for each in recordings]
    cars = {name: load(name) for name in named}
    alone = len(recordings) == 1
    what = monitor or (cars[named[0]].monitor if alone else None) or ALL
    stem = recordings[0].stem if alone else "recordings"
    target = report_path(output, report, f"{stem}-{what}.html")
    given = [*recordings, *named, *(dbc or []), channel_map, baseline, memory]
    _refuse_what_cannot_be_written(target, signals, baseline, given)
    reading = {"dbc": dbc or None, "channel_map": channel_map, "start": start, "stop": stop}
    if not alone or what == ALL:
        options = {"--variant": variant, "--baseline": baseline, "--memory": memory, "--signals": signals}
        _refuse_options_of_one(options, alone)
        drives = [(recording, cars[name]) for recording, name in zip(recordings, named, strict=True)]
        return _all(drives, None if what == ALL else [what], reading | {"spread": spread}, target, as_json, details)
    kept = {"baseline": baseline, "fault_free": fault_free, "memory": memory, "signals": signals, "spread": spread}
    return _one(recordings[0], cars[named[0]], what, variant, reading, kept, target, as_json, details)


def _one(
    recording: Path,
    car: Vehicle,
    monitor: str,
    variant: str | None,
    reading: dict[str, Any],
    kept: dict[str, Any],
    target: Path | None,
    as_json: bool,
    details: bool,
) -> int:
    """Judge one recording with one monitor, including the options that only apply to this case."""
    from tierod.cli.terminal import progress, say_where
    from tierod.monitors.diagnose import diagnose as run
    from tierod.monitors.diagnose import source_of

    read = {name: reading[name] for name in ("dbc", "channel_map")}
    with progress(f"reading {recording.name}") as advance:
        source = source_of(recording, car, *reading.values())
        with _naming_others(source, car, monitor, read):
            diagnosis = run(source, car, monitor, variant, **read, **kept, command=command_line(), progress=advance)
    show(diagnosis, as_json, target, details)
    written = [] if kept["signals"] is None else [("signals", str(kept["signals"]))]
    for what, text in (*written, *((name, diagnosis.remarks.get(name, "")) for name in ("baseline", "fault memory"))):
        if text:
            say_where(as_json, what, text)
    return diagnosis.status.exit_code


@contextmanager
def _naming_others(source: Path | Recording, car: Vehicle, monitor: str, read: Mapping[str, Any]) -> Iterator[None]:
    """Add the monitors that can run to the error of a monitor that cannot."""
    from tierod.core.errors import DamagedFile, InputError, ParameterError, TierodError
    from tierod.monitors.diagnose import able
    from tierod.monitors.registry import MONITORS

    try:
        yield
    except DamagedFile:
        raise
    except (InputError, ParameterError) as error:
        unable = isinstance(error, InputError) or "cannot run as" in str(error)
        if not unable or monitor not in MONITORS or (isinstance(source, Path) and not source.is_file()):
            raise
        try:
            others = [name for name in able(source, car, *read.values()) if name != monitor]
        except TierodError:
            raise error from None
        if not others:
            raise
        hint = f"The recording can be judged with --monitor {' or '.join(others)}"
        raise type(error)(f"{str(error).rstrip('.')}. {hint}") from None


def _all(
    drives: Sequence[tuple[Path, Vehicle]],
    monitors: list[str] | None,
    reading: dict[str, Any],
    target: Path | None,
    as_json: bool,
    details: bool,
) -> int:
    """Judge several recordings, or with every monitor: one page, one document, and the worst exit code."""
    from tierod.cli.terminal import origin, print_json, progress, say_where
    from tierod.cli.terminal import output as terminal
    from tierod.cli.terminal import show as show_items
    from tierod.core.errors import InputError, MissingExtra
    from tierod.core.files import write_text
    from tierod.io.readers.opening import require_there
    from tierod.monitors.diagnose import judge, not_judged
    from tierod.report import several
    from tierod.report.display import without_advice

    for recording, _ in drives:
        require_there(recording)
    judged = []
    for place, (recording, car) in enumerate(drives):
        with progress(f"judging {recording.name} ({place + 1} of {len(drives)})") as advance:
            try:
                judged.append(judge(recording, car, monitors, **reading, command=command_line(), progress=advance))
            except (InputError, MissingExtra) as error:
                if len(drives) == 1:
                    raise
                judged.append(not_judged(recording, car, monitors, " ".join(str(error).split())))
    if not any(one.diagnoses for one in judged):
        reasons = "; ".join(_of(name, without_advice(reason)) for _, name, reason in several.not_run(judged))
        given = ", ".join(str(recording) for recording, _ in drives)
        raise InputError(f"no monitor can run on {given}: {reasons}. 'tierod inspect' shows the details")
    if target is not None:
        write_text(target, several.render(judged, origin()))
    if as_json:
        print_json(several.to_json(judged, origin()))
    elif details:
        show_items(several.tables(judged, narrow=True))
    else:
        several.answer(judged, terminal())
    if target is not None:
        say_where(as_json, "report", target)
    return several.status_of(judged).exit_code


def _of(monitors: str, reason: str) -> str:
    from tierod.monitors.diagnose import ALL

    return reason if monitors == ALL else f"{monitors}: {reason}"


def _refuse_options_of_one(options: Mapping[str, object], alone: bool) -> None:
    from tierod.core.errors import ParameterError

    for name, value in options.items():
        if value is not None:
            cure = "name one with --monitor" if alone else "judge the recordings one by one, each with --monitor"
            raise ParameterError(f"{name} works with one monitor and one recording only; {cure}, or leave it out")


def _named_in(recording: Path, dbc: list[Path] | None, channel_map: Path | None) -> str:
    """Name of the vehicle that a recording states; prints a message with the name."""
    from tierod.cli.terminal import print_remark
    from tierod.monitors.acceptance import vehicle_named_in

    name = vehicle_named_in(recording, dbc or None, channel_map)
    print_remark(f"vehicle: {name}, named by the recording; choose another with --vehicle")
    return name


def _refuse_what_cannot_be_written(
    report: Path | None, signals: Path | None, baseline: Path | None, given: Sequence[Path | str | None]
) -> None:
    """Check the paths before the fault memory takes the recording: a repeated run would count it twice."""
    from tierod.cli.terminal import refuse_to_overwrite
    from tierod.core.files import require_folder

    refuse_to_overwrite(report, given)
    refuse_to_overwrite(signals, [*given, report], "recording", "--signals")
    for path in filter(None, (report, baseline)):
        require_folder(path)


def show(diagnosis: Diagnosis, as_json: bool, path: Path | None, details: bool = False) -> None:
    """Write the report first, so that a failure to write it precedes the verdict; then print the table or JSON."""
    from tierod.cli.terminal import output, print_json, say_where
    from tierod.report import print_table, to_json, write_html

    if path is not None:
        write_html(diagnosis, path)
    if as_json:
        print_json(to_json(diagnosis))
    else:
        print_table(diagnosis, output(), details)
    if path is not None:
        say_where(as_json, "report", path)
