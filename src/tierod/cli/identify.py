"""Find parameters of a vehicle from recordings of a bench or a drive, and write them into its file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from tierod.cli.identified import Identified, Subject
    from tierod.core.recording import Recording
    from tierod.vehicles import Vehicle


def identify(
    subject: Annotated[str, typer.Argument(help="What to identify: column, motor, inverter or thresholds.")],
    recordings: Annotated[
        list[Path], typer.Argument(help="Recordings of bench or drive, one experiment each or more.")
    ],
    vehicle: Annotated[str, typer.Option(help="A vehicle's name, or its TOML file: where the search starts.")],
    free: Annotated[
        str | None,
        typer.Option(help="Parameters to find, with commas between; of a column damping and friction where not given."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Vehicle file to write; not written where not given.")
    ] = None,
    in_place: Annotated[bool, typer.Option("--in-place", help="Write into the vehicle file that was given.")] = False,
    report: Annotated[Path | None, typer.Option(help="HTML page to write; none where not given.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
    ] = None,
    false_alarms: Annotated[
        str | None, typer.Option(help='Of thresholds: false alarms that one can bear, "1 per 1000 h" where not given.')
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Fit parameters to recordings and write them back: done (0), values of no use (2), bad input (3)."""
    from tierod.cli.app import HEALTHY, NOT_JUDGED
    from tierod.cli.identified import SUBJECTS
    from tierod.cli.terminal import messages, print_json, progress
    from tierod.core.errors import ParameterError, nearest
    from tierod.vehicles import load

    if subject not in SUBJECTS:
        raise ParameterError(f"'{subject}' cannot be identified{nearest(subject, SUBJECTS)}")
    wanted, car = SUBJECTS[subject], load(vehicle)
    rate = _wanted_rate(wanted, subject, false_alarms)
    target = _target(car, output, in_place)
    _require_places(car, recordings, channel_map, target, in_place, report)
    known = _read(recordings, channel_map or car.channel_map, wanted.signals())
    with progress(f"identifying the {subject} of {car.name}") as advance:
        result = wanted.identify(car, known, _names(free), advance, **rate)
    if report is not None:
        _write_page(wanted, result, car, known, recordings, report)
    if target is not None and result.doubt:
        messages().print(f"{target} is not written: {result.doubt}", soft_wrap=True, markup=False)
        target = None
    if target is not None:
        _write_vehicle(result, car, recordings, target)
    if as_json:
        print_json(_document(wanted, result, car, recordings, target, report))
    else:
        _show(wanted, result)
    for what, path in (("vehicle file", target), ("page", report)):
        if path is not None:
            messages().print(f"{what}: {path}", soft_wrap=True, markup=False)
    return NOT_JUDGED if result.doubt else HEALTHY


def _wanted_rate(wanted: Subject, subject: str, false_alarms: str | None) -> dict[str, float]:
    """The wanted time between false alarms, where one is given and makes sense [h]."""
    from tierod.cli.design import seconds_between
    from tierod.core.errors import ParameterError

    if false_alarms is None:
        return {}
    if not wanted.takes_false_alarms:
        raise ParameterError(f"the identification of '{subject}' makes no use of --false-alarms; leave it out")
    return {"hours": seconds_between(false_alarms) / 3600.0}


def _names(free: str | None) -> tuple[str, ...]:
    return tuple(name.strip() for name in (free or "").split(",") if name.strip())


def _target(car: Vehicle, output: Path | None, in_place: bool) -> Path | None:
    """Where the vehicle file goes."""
    from tierod.core.errors import OutputError
    from tierod.vehicles.vehicle import SHIPPED

    if in_place and output is not None:
        raise OutputError("--in-place and --output say two places for the vehicle file; give one of them")
    if in_place and car.path.parent == SHIPPED:
        raise OutputError(
            f"{car.name} is shipped with tierod and is not written over; give --output eps-identified.toml"
        )
    return car.path if in_place else output


def _require_places(
    car: Vehicle,
    recordings: list[Path],
    channel_map: Path | None,
    target: Path | None,
    in_place: bool,
    report: Path | None,
) -> None:
    """See, before the search, that vehicle file and page can be written and write over nothing that was given."""
    from tierod.cli.analysed import refuse_to_overwrite
    from tierod.core.files import require_folder

    given = [*recordings, channel_map]
    refuse_to_overwrite(report, [*given, car.path, target], "page", "--report")
    if not in_place:
        refuse_to_overwrite(target, [car.path], "vehicle file", "--output, or say --in-place")
    refuse_to_overwrite(target, given, "vehicle file")
    for path in filter(None, (target, report)):
        require_folder(path)


def _read(paths: list[Path], channel_map: Path | None, signals: tuple[str, ...] | None) -> dict[str, Recording]:
    """Recordings by a name of their own, with the signals that are looked at, all where None."""
    from tierod.core.errors import InputError
    from tierod.io.readers import read

    found: dict[str, Recording] = {}
    for path in paths:
        if any(path.resolve() == other.resolve() for other in paths if other is not path):
            raise InputError(f"{path} is given twice; every experiment counts once")
        name = path.name if [each.name for each in paths].count(path.name) == 1 else str(path)
        found[name] = read(path, channel_map=channel_map, names=signals)
    return found


def _sources(recordings: list[Path]) -> list[str]:
    """Name and begin of the SHA-256 of every file."""
    import hashlib

    found = []
    for path in recordings:
        if not path.is_file():  # what came through a pipe cannot be read again
            found.append(path.name)
            continue
        with path.open("rb") as file:
            found.append(f"{path.name} ({hashlib.file_digest(file, 'sha256').hexdigest()[:12]})")
    return found


def _write_vehicle(result: Identified, car: Vehicle, recordings: list[Path], target: Path) -> None:
    from tierod.cli.analysed import origin
    from tierod.core.errors import ParameterError
    from tierod.core.files import holding, write_text
    from tierod.core.user_files import read_text
    from tierod.vehicles.writer import Change, changed, with_thresholds

    by = origin()
    made = f"on {by.created[:10]} by tierod {by.version}: {by.command}"
    source = f"identified from {', '.join(_sources(recordings))} {made}"
    changes = {each.name: Change(each.value, each.deviation, source) for each in result.found}
    with holding(target) as place:  # read and written as one: another parameter may be found at the same time
        text = changed(read_text(car.path, "the vehicle file", ParameterError, keep_line_ends=True), changes)
        for of, table in getattr(result, "thresholds", {}).items():
            text = with_thresholds(text, of, table)
        write_text(place, text)


def _write_page(
    subject: Subject, result: Any, car: Vehicle, known: dict[str, Recording], recordings: list[Path], target: Path
) -> None:
    from tierod.cli.analysed import origin
    from tierod.core.files import write_text
    from tierod.report.identification_page import IdentificationPage, render_identification

    by = origin()
    facts = (("vehicle", car.name), ("vehicle file", str(car.path)), ("recordings", ", ".join(_sources(recordings))))
    warnings = tuple(f"{name}: {text}" for name, each in known.items() for text in each.warnings)
    page = IdentificationPage(
        f"{subject.title} of {car.name}, identified",
        (subject.summary,),
        (*result.remarks, *warnings),
        facts,
        by.created,
        by.version,
        by.command,
    )
    write_text(target, render_identification(page, list(subject.items(result))))


def _show(subject: Subject, result: Any) -> None:
    from tierod.cli.terminal import output, rows

    console = output()
    for table in subject.tables(result):
        console.print(f"{table.title}:", markup=False)
        kept = [k for k, title in enumerate(table.header) if title not in ("95 % interval", "by")]
        cells = [[row[k] for k in kept] for row in table.rows]
        console.print(rows([table.header[k] for k in kept], cells, range(1, len(kept) - ("unit" in table.header))))
        console.print("")
    for line in (*subject.lines(result), *(f"To know: {remark}" for remark in result.remarks)):
        console.print(line, markup=False, soft_wrap=True)


def _document(
    subject: Subject, result: Any, car: Vehicle, recordings: list[Path], target: Path | None, report: Path | None
) -> dict[str, Any]:
    from tierod.cli.analysed import origin
    from tierod.vehicles.catalogue import QUANTITIES

    by = origin()
    return {
        "schema": "tierod.identification/1",
        "subject": subject.title.lower(),
        "created": by.created,
        "version": by.version,
        "command": by.command,
        "vehicle": car.name,
        "recordings": _sources(recordings),
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
            for each in result.found
        ],
        **subject.document(result),
        "remarks": list(result.remarks),
        "vehicle_file": None if target is None else str(target),
        "page": None if report is None else str(report),
    }
