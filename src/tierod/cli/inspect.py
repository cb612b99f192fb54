"""Show what a recording holds: channels, rates, gaps, ranges, and which monitor can run on it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tierod.cli.terminal import messages, output, print_json, progress, rows

if TYPE_CHECKING:
    from tierod.core.findings import ChannelQuality
    from tierod.monitors.inspection import Inspection, Readiness
    from tierod.vehicles import Vehicle

_SHOWN = 40
"""Channels without a canonical name that are listed without --all."""


def inspect(
    recording: Annotated[
        Path, typer.Argument(help="A recording: MF4, Parquet, CSV, a CAN log and others (see 'tierod formats').")
    ],
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
    ] = None,
    vehicle: Annotated[str | None, typer.Option(help="A vehicle whose database and map to use.")] = None,
    every: Annotated[bool, typer.Option("--all", help="List all channels, also those without a known name.")] = False,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
) -> None:
    """Show the channels of a recording with their quality, and for each monitor what it lacks."""
    from tierod.monitors.inspection import inspect as run

    with progress(f"reading {recording.name}") as advance:
        found = run(recording, vehicle, dbc=dbc, channel_map=channel_map, progress=advance)
    if json:
        print_json(found.document())
    else:
        _show(found, every)
        _say_which_vehicle(found.vehicle)


def _show(found: Inspection, every: bool) -> None:
    from rich.text import Text

    from tierod.core.signals import SIGNALS

    console, whole = output(), found.recording
    first, last = whole.span
    console.print(
        Text(f"{whole.metadata.get('path', 'recording')}: {len(found.quality)} channels, {last - first:.6g} s")
    )
    known = [row for row in found.quality if row.name in SIGNALS]
    others = [row for row in found.quality if row.name not in SIGNALS]
    hidden = 0 if every else max(len(others) - _SHOWN, 0)
    shown = known + others[: len(others) - hidden]
    titles = ("channel", "unit", "samples", "rate [Hz]", "missing", "gap [s]", "lowest", "highest")
    console.print(rows(titles, [_cells(row) for row in shown], right=(2, 3, 4, 5, 6, 7)))
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
        lack = each.obstacles
        console.print(Text(f"  {each.monitor.name}: {'cannot run' if lack else _can_run(each, verdict)}"))
        # Other variants than the default lack as much, or they would run in its place.
        for obstacle in dict.fromkeys(map(_short, lack[:1] if each.monitor.default else lack)):
            console.print(Text(f"    - {obstacle}"))
    if any(each.obstacles for each in found.monitors):
        messages().print(
            "Signals under other names need a channel map: --map map.toml; see docs/how-to/read-recordings.md"
        )


def _short(reason: str) -> str:
    """A reason without its advice, which is printed once for all monitors below the list."""
    return re.split(r"; did you mean|; known: |; none of the|\\. (?=[A-Z])", reason)[0].rstrip(".")


def _can_run(ready: Readiness, verdict: str) -> str:
    """That it can run, on what condition, as which variant, and whether one must be chosen."""
    monitor, free = ready.monitor, ready.variants
    condition = f" if {monitor.condition}" if monitor.condition else ""
    if monitor.default is None:
        return f"{verdict}{condition}; choose --variant {' or '.join(free)}"
    alone = "" if len(free) == len(ready.reasons) else f", as {', '.join(free)} only"
    return f"{verdict}{condition}{alone}"


def _say_which_vehicle(car: Vehicle | None) -> None:
    """What the list of monitors rests on."""
    if car is None:
        text = "no vehicle is named, so only signals were looked at; --vehicle looks at its parameters too"
    else:
        text = f"looked at as the vehicle {car.name}; --vehicle takes another"
    messages().print(text, soft_wrap=True, markup=False)


def _cells(row: ChannelQuality) -> tuple[str, ...]:
    from tierod.core.shown import shown
    from tierod.report.display import number, share

    factor, label = shown(row.unit)
    figures = (number(row.rate, 4), share(row.missing_share), number(row.longest_gap, 3))
    return row.name, label, str(row.samples), *figures, number(row.minimum * factor), number(row.maximum * factor)
