"""Judge a recorded drive whose friction rises half-way, and print the verdict and the report's path."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from tierod.cli.diagnose import Details


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for recording and report.")] = Path("out"),
    details: Details = False,
) -> int:
    """Judge a recorded drive, and write the report: a demonstration of tierod in one command."""
    from tierod.cli.diagnose import show
    from tierod.cli.terminal import output as console
    from tierod.io.demo import VEHICLE, copied
    from tierod.monitors.diagnose import diagnose

    terminal = console()
    path = copied(output)
    terminal.print(
        f"recording: {path} (13 minutes; friction 4 N·m, from half-way on 8 N·m)", soft_wrap=True, markup=False
    )
    command = shlex.join(["tierod", "diagnose", str(path), "--vehicle", VEHICLE])
    terminal.print(f"judging it, as this command does: {command}", soft_wrap=True, markup=False)
    diagnosis = diagnose(path, VEHICLE, command=command)
    show(diagnosis, as_json=False, path=output / "demo-friction.html", details=details)
    return 0
