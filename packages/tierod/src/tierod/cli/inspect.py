"""Show the content of a recording: channels, rates, gaps, ranges, and which monitor can run on it."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tierod.cli.terminal import messages, output, print_json, print_remark, progress, rows

if TYPE_CHECKING:
    from tierod.core.findings import ChannelQuality
    from tierod.io.proposal import Proposal
    from tierod.monitors.acceptance import Readiness
    from tierod.monitors.inspection import Inspection
    from tierod.vehicles import Vehicle

_SHOWN = 40  # Number of channels without a canonical name that are listed without --all


def inspect(
    recording: Annotated[Path, typer.Argument(help="A recording (see 'tierod formats').")],
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
    ] = None,
    vehicle: Annotated[str | None, typer.Option(help="A vehicle whose database and map to use.")] = None,
    write_map: Annotated[
        Path | None,
        typer.Option(help="Channel map to write: signal, unit and sign of every column as proposed, with reasons."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a channel map that is there.")] = False,
    every: Annotated[bool, typer.Option("--all", help="List all channels, also those without a known name.")] = False,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
) -> None:
    """Show the channels of a recording with their quality, and the unmet requirements of each monitor."""
    from tierod.monitors.inspection import inspect as run

    if write_map is not None:
        _write_map(recording, write_map, dbc, channel_map, vehicle, overwrite, json)
        return
    with progress(f"reading {recording.name}") as advance:
        found = run(recording, vehicle, dbc=dbc, channel_map=channel_map, progress=advance)
    if json:
        print_json(found.document())
    else:
        _show(found, every, channel_map)
        _say_which_vehicle(found.vehicle)


def _write_map(
    recording: Path,
    target: Path,
    dbc: list[Path] | None,
    channel_map: Path | None,
    vehicle: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    from tierod.cli.terminal import refuse_to_overwrite
    from tierod.core.errors import OutputError, ParameterError
    from tierod.core.files import require_folder, write_text
    from tierod.io.proposal import propose, text_of
    from tierod.vehicles import load
    from tierod.vehicles.vehicle import read_by

    if channel_map is not None or as_json:
        raise ParameterError(f"--write-map and {'--json' if as_json else '--map'} exclude each other; give one of them")
    if target.suffix != ".toml":
        raise OutputError(f"{target} is not the name of a channel map, which ends in .toml; write car.channels.toml")
    refuse_to_overwrite(target, [recording, *(dbc or [])], "channel map", "--write-map")
    require_folder(target)
    if target.exists() and not overwrite:
        raise OutputError(f"{target} exists already; name another file, or replace it with --overwrite")
    car = None if vehicle is None else load(vehicle)
    with progress(f"reading {recording.name}") as advance:
        found = propose(recording, read_by(car, dbc)[0], advance)
    write_text(target, text_of(found))
    _show_proposal(found, target, None if car is None else str(vehicle), dbc or [])


def _show_proposal(found: Proposal, target: Path, vehicle: str | None, dbc: Sequence[Path]) -> None:
    console = output()
    cells = [
        (e.signal, e.column.name, e.unit.unit.name, f"{e.sign.sign:+d}", "yes" if e.doubtful else "")
        for e in found.entries
    ]
    console.print(rows(("signal", "column", "unit", "sign", "check"), cells))
    if found.unmatched:
        count = len(found.unmatched)
        which = "1 column was" if count == 1 else f"{count} columns were"
        console.print(f"{which} not matched; the map lists {'it' if count == 1 else 'them'}", markup=False)
    if found.texts:
        names = ", ".join(found.texts[:5]) + (" and more" if len(found.texts) > 5 else "")
        advice = "before the export, empty the values that such a flag marks as invalid"
        console.print(f"not read, since they hold text: {names}; {advice}", markup=False)
    console.print(f"channel map: {target}: it holds the reasons; edit it where it is wrong", markup=False)
    databases = [word for each in dbc for word in ("--dbc", str(each))]
    if vehicle is not None:
        words = ["diagnose", str(found.path), "--vehicle", vehicle, *databases, "--map", str(target)]
    else:
        name = target.name.removesuffix(".channels.toml") if target.name.endswith(".channels.toml") else ""
        own = target.with_name(f"{name or 'car'}.toml")
        named = [] if name else ["--map", str(target)]
        words = ["new", str(own), "--class", "midsize", *named, *databases[:2], "--drive", str(found.path)]
    console.print(f"go on with: tierod {shlex.join(words)}", markup=False, soft_wrap=True)
    if vehicle is None:
        console.print("and add values from the data sheet, such as mass=1480 wheelbase=2.68", markup=False)


def _show(found: Inspection, every: bool, channel_map: Path | None) -> None:
    from rich.text import Text

    from tierod.core.signals import SIGNALS
    from tierod.report.display import without_advice

    console, whole = output(), found.recording
    first, last = whole.span
    console.print(
        Text(f"{whole.metadata.get('path', 'recording')}: {len(found.quality)} channels, {last - first:.6g} s")
    )
    known = [row for row in found.quality if row.name in SIGNALS]
    others = [row for row in found.quality if row.name not in SIGNALS]
    hidden = 0 if every else max(len(others) - _SHOWN, 0)
    shown = known + others[: len(others) - hidden]
    titles = ("channel", "in the file", "unit", "samples", "rate [Hz]", "missing", "gap [s]", "lowest", "highest")
    cells = [_cells(row, whole.channels[row.name].source) for row in shown]
    console.print(rows(titles, cells, right=(3, 4, 5, 6, 7, 8)))
    if hidden:
        console.print(f"... and {hidden} channels without a known name; list them with --all")
    remarks = [f"{row.name}: {remark}" for row in shown for remark in row.remarks]
    for title, lines in (("Remarks", remarks), ("Warnings", found.warnings)):
        if lines:
            console.print(f"\n[bold]{title}[/bold]")
            for line in lines:
                console.print(Text(f"  - {line}"))
    console.print("\n[bold]Monitors[/bold]")
    verdict = "can run" if found.vehicle else "can run with a vehicle file"
    for each in found.monitors:
        console.print(Text(f"  {each.monitor.name}: {'cannot run' if each.reason else _can_run(each, verdict)}"))
        if each.reason:
            console.print(Text(f"    - {without_advice(each.reason)}"))
    if any(each.obstacles for each in found.monitors):
        messages().print(
            "Signals under other names need a channel map: --write-map car.channels.toml proposes one"
            if channel_map is None
            else f"Signals under other names need an entry in {channel_map}; see docs/how-to/read-recordings.md",
            soft_wrap=True, markup=False, highlight=False,
        )  # fmt: skip


def _can_run(ready: Readiness, verdict: str) -> str:
    free = ready.variants
    alone = "" if not ready.monitor.default or len(free) == len(ready.reasons) else f", as {', '.join(free)} only"
    return f"{verdict}{ready.choice}{alone}"


def _say_which_vehicle(car: Vehicle | None) -> None:
    if car is None:
        text = "no vehicle is named: a typical car is assumed; name yours with --vehicle"
    else:
        text = f"checked for the vehicle {car.name}; choose another with --vehicle"
    print_remark(text)


def _cells(row: ChannelQuality, source: str) -> tuple[str, ...]:
    from tierod.core.shown import shown
    from tierod.report.display import number, share

    factor, label = shown(row.unit)
    figures = (number(row.rate, 4), share(row.missing_share), number(row.longest_gap, 3))
    return (
        row.name,
        "" if source == row.name else source,
        label,
        str(row.samples),
        *figures,
        number(row.minimum * factor),
        number(row.maximum * factor),
    )
