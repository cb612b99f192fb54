"""Convert recordings between all supported formats; several files become one drive."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def convert(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings, or folders (ROS 2 bag, parts of one drive).")],
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write: .mf4, .mcap, .parquet, .csv or .mat.")],
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database; may be given more than once.")] = None,
    channel_map: Annotated[
        Path | None, typer.Option("--map", help="TOML file: source name, unit, sign and offset of each signal.")
    ] = None,
    canonical: Annotated[
        bool, typer.Option(help="Name known signals as tierod does, in SI; as recorded where not given.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> None:
    """Convert recordings, and list what the format cannot represent."""
    import dataclasses

    from tierod.cli.terminal import messages, print_json, progress, refuse_to_overwrite
    from tierod.cli.terminal import output as console
    from tierod.io.conversion import convert as run

    refuse_to_overwrite(output, [*recordings, *(dbc or []), channel_map], "recording")
    with progress(f"converting {recordings[0].name}") as advance:
        done = run(recordings, output, dbc=dbc or None, channel_map=channel_map, canonical=canonical, progress=advance)
    if as_json:
        print_json({"output": str(output), **dataclasses.asdict(done)})
    else:
        text = f"{output}: {done.channels} channels, {done.samples} samples, {done.seconds:.6g} s"
        console().print(text, soft_wrap=True, markup=False)
    for line in (*done.warnings, *done.lost):
        (messages() if as_json else console()).print(f"  - {line}", soft_wrap=True, markup=False)
