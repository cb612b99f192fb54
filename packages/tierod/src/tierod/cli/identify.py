"""Identify parameters of a vehicle from recordings of a bench or a drive, and write them into its file."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tierod.cli.diagnose import ChannelMap, Databases, StretchStop

if TYPE_CHECKING:
    from tierod.report.identification import Subject
    from tierod.vehicles import Vehicle


StretchStart = Annotated[
    float | None,
    typer.Option("--from", help="Start of the stretch that is used of every recording, in its own time [s]."),
]


def identify(
    subject: Annotated[str, typer.Argument(help="What to identify: vehicle, column, motor, inverter or thresholds.")],
    recordings: Annotated[
        list[Path], typer.Argument(help="Recordings of bench or drive, each with one experiment or more.")
    ],
    vehicle: Annotated[str, typer.Option(help="A vehicle's name or TOML file, from which the search starts.")],
    free: Annotated[
        str | None,
        typer.Option(
            help="Parameters to identify, separated by commas; for a column, damping and friction if not given."
        ),
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Vehicle file to write; else none.")] = None,
    in_place: Annotated[bool, typer.Option("--in-place", help="Write into the vehicle file that was given.")] = False,
    report: Annotated[Path | None, typer.Option(help="HTML page to write; none if not given.")] = None,
    start: StretchStart = None,
    stop: StretchStop = None,
    dbc: Databases = None,
    channel_map: ChannelMap = None,
    false_alarms: Annotated[
        str | None, typer.Option(help='For thresholds: accepted rate of false alarms; "1 per 1000 h" if not given.')
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Fit parameters to recordings and write them back: done (0), unusable values (2), bad input (3)."""
    from tierod.cli.app import HEALTHY, NOT_JUDGED
    from tierod.cli.terminal import origin, print_json, print_remark, progress, show_analysis
    from tierod.report.identification import identify as run
    from tierod.report.identification import subject_of
    from tierod.vehicles import load

    wanted, car = subject_of(subject), load(vehicle)
    hours = _wanted_hours(wanted, subject, false_alarms)
    # Drives add to the file of their car: naming it as input and output permits overwriting it.
    in_place, output = _same_file(subject, car, output, in_place)
    target = _target(car, output, in_place)
    _require_places(car, [*recordings, *(dbc or []), channel_map], target, in_place, report)
    with progress(f"identifying the {subject} of {car.name}") as advance:
        found = run(
            subject, recordings, car, _names(free), dbc=dbc, channel_map=channel_map, start=start, stop=stop,
            hours=hours, progress=advance,
        )  # fmt: skip
    if report is not None:
        found.write_html(report, origin())
    if found.doubt:
        print_remark(f"{target} is not written: {found.doubt}" if target else found.doubt)
        target = None
    if target is not None:
        found.write_vehicle(target, origin())
    if as_json:
        places = {"vehicle_file": target and str(target), "page": report and str(report)}
        print_json(found.document(origin()) | places)
    else:
        show_analysis(found.analysis)
    for what, path in (("vehicle file", target), ("page", report)):
        if path is not None:
            print_remark(f"{what}: {path}")
    if subject == "vehicle" and not found.doubt:
        print_remark(_next(recordings, target, start, stop, dbc, channel_map))
    return NOT_JUDGED if found.doubt else HEALTHY


def _next(
    recordings: list[Path],
    written: Path | None,
    start: float | None = None,
    stop: float | None = None,
    dbc: list[Path] | None = None,
    channel_map: Path | None = None,
) -> str:
    """The next command, with the same options for reading, or the option that was missing."""
    if written is None:
        return "no vehicle file is written; to write one, give --output car.toml"
    words = ["tierod", "diagnose", *map(str, recordings), "--vehicle", str(written)]
    reading = [("--from", start), ("--to", stop), *(("--dbc", each) for each in dbc or []), ("--map", channel_map)]
    words += [str(word) for option in reading if option[1] is not None for word in option]
    return f"go on with: {shlex.join(words)}"


def _wanted_hours(wanted: Subject, subject: str, false_alarms: str | None) -> float | None:
    """Required mean time between false alarms [h]; None if not given."""
    from tierod.cli.design import seconds_between
    from tierod.core.errors import ParameterError

    if false_alarms is None:
        return None
    if not wanted.takes_false_alarms:
        raise ParameterError(f"the identification of '{subject}' does not use --false-alarms; leave it out")
    return seconds_between(false_alarms) / 3600.0


def _names(free: str | None) -> tuple[str, ...]:
    return tuple(name.strip() for name in (free or "").split(",") if name.strip())


def _same_file(subject: str, car: Vehicle, output: Path | None, in_place: bool) -> tuple[bool, Path | None]:
    if subject == "vehicle" and output is not None and output.resolve() == car.path.resolve():
        return True, None
    return in_place, output


def _target(car: Vehicle, output: Path | None, in_place: bool) -> Path | None:
    """Path of the vehicle file to write; None if none is to be written."""
    from tierod.core.errors import OutputError
    from tierod.vehicles.vehicle import SHIPPED

    if in_place and output is not None:
        raise OutputError("--in-place and --output name two places for the vehicle file; give one of them")
    if in_place and car.path.parent == SHIPPED:
        raise OutputError(
            f"{car.name} is shipped with tierod and cannot be overwritten; give --output eps-identified.toml"
        )
    return car.path if in_place else output


def _require_places(
    car: Vehicle,
    given: Sequence[Path | None],
    target: Path | None,
    in_place: bool,
    report: Path | None,
) -> None:
    """Check, before the search, that vehicle file and page can be written and overwrite no input."""
    from tierod.cli.terminal import refuse_to_overwrite
    from tierod.core.files import require_folder

    refuse_to_overwrite(report, [*given, car.path, target], "page", "--report")
    if not in_place:
        refuse_to_overwrite(target, [car.path], "vehicle file", "--output, or give --in-place")
    refuse_to_overwrite(target, given, "vehicle file")
    for path in filter(None, (target, report)):
        require_folder(path)
