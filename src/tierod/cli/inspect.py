"""Show what a recording holds: channels, rates, gaps, ranges, and which monitor can run on it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import messages, output, print_json, progress, rows

if TYPE_CHECKING:
    from tierod.core.findings import ChannelQuality
    from tierod.core.recording import Recording
    from tierod.monitors.harness.session import Monitor
    from tierod.vehicles import Vehicle

_SHOWN = 40
"""Channels without a canonical name that are listed without --all."""


def inspect(
    recording: Annotated[
        Path, typer.Argument(help="MF4, Parquet, CSV, MATLAB 5, or a CAN log (candump, ASC, BLF, TRC).")
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
    with progress(f"reading {recording.name}") as advance:
        whole = _read(recording, dbc, channel_map, vehicle)
        advance(1.0)
    from tierod.io.derive import complete
    from tierod.io.quality import channel_quality
    from tierod.io.signs import sign_warnings
    from tierod.io.turns import turn_warnings
    from tierod.monitors.harness.acceptance import refusals
    from tierod.monitors.registry import MONITORS

    car = _vehicle(whole, vehicle)
    reasons = {name: refusals(monitor, car, whole) for name, monitor in MONITORS.items()}
    whole = complete(whole)
    quality = [channel_quality(channel) for channel in whole.channels.values()]
    warnings = (*whole.warnings, *sign_warnings(whole), *turn_warnings(whole))
    if json:
        print_json(_document(whole, quality, warnings, reasons))
    else:
        _show(whole, quality, warnings, reasons, every, "can run" if car else "can run with a vehicle file")
        _say_which_vehicle(car)


def _read(path: Path, dbc: list[Path] | None, channel_map: Path | None, vehicle: str | None) -> Recording:
    from tierod.io.readers import read
    from tierod.vehicles import load

    car = load(vehicle) if vehicle else None
    databases = dbc or ([car.database] if car and car.database else None)
    return read(path, dbc=databases, channel_map=channel_map or (car.channel_map if car else None))


def _vehicle(whole: Recording, name: str | None) -> Vehicle | None:
    """The vehicle as which a diagnosis would judge the recording: the one given, or the one that it names."""
    from tierod.core.errors import TierodError
    from tierod.monitors.harness.named_vehicle import vehicle_named_in
    from tierod.vehicles import load

    if name is not None:
        return load(name)
    try:
        return load(vehicle_named_in(whole, None, None))
    except TierodError:
        return None


def _document(
    whole: Recording, quality: list[ChannelQuality], warnings: tuple[str, ...], reasons: dict[str, Mapping[str, str]]
) -> dict[str, Any]:
    import dataclasses

    from tierod.io.writers.layout import plain
    from tierod.monitors.registry import MONITORS

    return {
        "schema": "tierod.inspection/2",
        "metadata": plain(whole.metadata),
        "start": whole.span[0],
        "end": whole.span[1],
        "channels": [dataclasses.asdict(row) for row in quality],
        "warnings": list(warnings),
        "monitors": [
            {
                "name": name,
                "can_run": any(not reason for reason in each.values()),
                "condition": MONITORS[name].condition,
                "obstacles": _obstacles(MONITORS[name], each),
                "variants": [{"name": variant, "obstacle": reason} for variant, reason in each.items()],
            }
            for name, each in reasons.items()
        ],
    }


def _show(
    whole: Recording,
    quality: list[ChannelQuality],
    warnings: tuple[str, ...],
    reasons: dict[str, Mapping[str, str]],
    every: bool,
    verdict: str,
) -> None:
    from rich.text import Text

    from tierod.core.signals import SIGNALS
    from tierod.monitors.registry import MONITORS

    console = output()
    first, last = whole.span
    console.print(Text(f"{whole.metadata.get('path', 'recording')}: {len(quality)} channels, {last - first:.6g} s"))
    known = [row for row in quality if row.name in SIGNALS]
    others = [row for row in quality if row.name not in SIGNALS]
    hidden = 0 if every else max(len(others) - _SHOWN, 0)
    shown = known + others[: len(others) - hidden]
    titles = ("channel", "unit", "samples", "rate [Hz]", "missing", "gap [s]", "lowest", "highest")
    console.print(rows(titles, [_cells(row) for row in shown], right=(2, 3, 4, 5, 6, 7)))
    if hidden:
        console.print(f"... and {hidden} channels without a known name; list them with --all")
    remarks = [f"{row.name}: {remark}" for row in shown for remark in row.remarks]
    for title, lines in (("Remarks", remarks), ("Warnings", warnings)):
        if lines:
            console.print(f"\n[bold]{title}[/bold]")
            for line in lines:
                console.print(Text(f"  - {line}"))
    console.print("\n[bold]Monitors[/bold]")
    for name, each in reasons.items():
        lack = _obstacles(MONITORS[name], each)
        console.print(Text(f"  {name}: {'cannot run' if lack else _can_run(MONITORS[name], each, verdict)}"))
        # Other variants than the default lack as much, or they would run in its place.
        for obstacle in dict.fromkeys(map(_short, lack[:1] if MONITORS[name].default else lack)):
            console.print(Text(f"    - {obstacle}"))
    if any(_obstacles(MONITORS[name], each) for name, each in reasons.items()):
        messages().print("Signals under other names need a channel map: --map map.toml; see docs/recordings.md")


def _obstacles(monitor: Monitor, reasons: Mapping[str, str]) -> list[str]:
    """Why no variant runs, the default's reason first and each reason once; empty where one would."""
    if not all(reasons.values()):
        return []
    return list(dict.fromkeys(reasons[name] for name in sorted(reasons, key=lambda name: name != monitor.default)))


def _short(reason: str) -> str:
    """A reason without its advice, which is printed once for all monitors below the list."""
    return re.split(r"; did you mean|; known: |; none of the|\\. (?=[A-Z])", reason)[0].rstrip(".")


def _can_run(monitor: Monitor, reasons: Mapping[str, str], verdict: str) -> str:
    """That it can run, on what condition, as which variant, and whether one must be chosen."""
    from tierod.monitors.harness.acceptance import taken

    free = taken(monitor, reasons)
    condition = f" if {monitor.condition}" if monitor.condition else ""
    if monitor.default is None:
        return f"{verdict}{condition}; choose --variant {' or '.join(free)}"
    alone = "" if len(free) == len(reasons) else f", as {', '.join(free)} only"
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
