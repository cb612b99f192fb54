"""Show what a recording holds: channels, rates, gaps, ranges, and which monitor can run on it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import messages, output, print_json, progress, rows

if TYPE_CHECKING:
    from tierod.findings import ChannelQuality
    from tierod.monitors.session import Monitor
    from tierod.recording import Recording

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
    from tierod.derive import complete
    from tierod.monitors.registry import MONITORS
    from tierod.quality import channel_quality, sign_warnings
    from tierod.turns import turn_warnings

    whole = complete(whole)
    quality = [channel_quality(channel) for channel in whole.channels.values()]
    warnings = (*whole.warnings, *sign_warnings(whole), *turn_warnings(whole))
    lacks = {name: fewest_obstacles(monitor, {row.name: row for row in quality}) for name, monitor in MONITORS.items()}
    if json:
        print_json(_document(whole, quality, warnings, lacks))
    else:
        _show(whole, quality, warnings, lacks, every)


def _read(path: Path, dbc: list[Path] | None, channel_map: Path | None, vehicle: str | None) -> Recording:
    from tierod.readers import read
    from tierod.vehicles import load

    car = load(vehicle) if vehicle else None
    databases = dbc or ([car.database] if car and car.database else None)
    return read(path, dbc=databases, channel_map=channel_map or (car.channel_map if car else None))


def fewest_obstacles(monitor: Monitor, quality: dict[str, ChannelQuality]) -> list[str]:
    """Those of the default, or of another variant that a diagnosis would take in its place.

    Args:
        monitor: with the signals and the rate that it needs
        quality: by name of the channel
    """
    found = obstacles(monitor, quality)
    others = [monitor.needing(each) for each in monitor.variants.values()] if monitor.default else []
    return found if all(obstacles(each, quality) for each in others) else []


def obstacles(monitor: Monitor, quality: dict[str, ChannelQuality]) -> list[str]:
    """Why a monitor cannot run on channels of this quality; empty where it can.

    Args:
        monitor: with the signals and the rate that it needs
        quality: by name of the channel
    """
    from tierod.monitors.quality_over_chunks import FEWEST

    found = []
    for name in monitor.required:
        row = quality.get(name)
        if row is None:
            found.append(f"{name} is missing")
        elif row.missing_share >= 1.0:
            found.append(f"{name} holds no values")
        elif row.samples < FEWEST:
            found.append(f"{name} has too few samples ({row.samples})")
        elif row.minimum == row.maximum:
            found.append(f"{name} is constant at {row.minimum:g}")
        elif row.rate < monitor.minimum_rate:
            found.append(f"{name} comes at {row.rate:.3g} Hz; {monitor.minimum_rate:g} Hz are needed")
    return found


def _document(
    whole: Recording, quality: list[ChannelQuality], warnings: tuple[str, ...], lacks: dict[str, list[str]]
) -> dict[str, Any]:
    import dataclasses

    from tierod.monitors.registry import MONITORS
    from tierod.writers.layout import plain

    return {
        "schema": "tierod.inspection/1",
        "metadata": plain(whole.metadata),
        "start": whole.span[0],
        "end": whole.span[1],
        "channels": [dataclasses.asdict(row) for row in quality],
        "warnings": list(warnings),
        "monitors": [
            {"name": name, "can_run": not lack, "condition": MONITORS[name].condition, "obstacles": lack}
            for name, lack in lacks.items()
        ],
    }


def _show(
    whole: Recording, quality: list[ChannelQuality], warnings: tuple[str, ...], lacks: dict[str, list[str]], every: bool
) -> None:
    from rich.text import Text

    from tierod.monitors.registry import MONITORS
    from tierod.signals import SIGNALS

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
    for name, lack in lacks.items():
        console.print(Text(f"  {name}: {'cannot run' if lack else _can_run(MONITORS[name])}"))
        for obstacle in lack:
            console.print(Text(f"    - {obstacle}"))
    if any(lacks.values()):
        messages().print("Signals under other names need a channel map: --map map.toml; see docs/recordings.md")


def _can_run(monitor: Monitor) -> str:
    """That it can run, on what condition, and whether a variant must be chosen."""
    condition = f" if {monitor.condition}" if monitor.condition else ""
    choice = "" if monitor.default else f"; choose --variant {' or '.join(monitor.variants)}"
    return f"can run{condition}{choice}"


def _cells(row: ChannelQuality) -> tuple[str, ...]:
    from tierod.report.display import number, share, shown

    factor, label = shown(row.unit)
    figures = (number(row.rate, 4), share(row.missing_share), number(row.longest_gap, 3))
    return row.name, label, str(row.samples), *figures, number(row.minimum * factor), number(row.maximum * factor)
