"""Simulate a drive whose friction rises half-way, judge it, and print the verdict and the report's path."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for recording and report.")] = Path("out"),
    minutes: Annotated[float, typer.Option(help="Duration of the drive in minutes.")] = 13.0,
    healthy: Annotated[float, typer.Option(help="Friction of the first half [N*m].")] = 4.0,
    risen: Annotated[float, typer.Option(help="Friction of the second half [N*m].")] = 8.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of road, driver and sensors.")] = 1,
) -> int:
    """Simulate a drive, write it as a recording, and judge it: a demonstration of tierod in one command."""
    from tierod.cli.diagnose import show
    from tierod.cli.terminal import messages, progress
    from tierod.cli.terminal import output as console
    from tierod.io.writers import write
    from tierod.monitors.diagnose import diagnose
    from tierod_lab.ground import FrictionCourse, drive

    terminal = console()
    course = FrictionCourse.step(healthy, risen, at=30.0 * minutes)
    terminal.print(
        f"simulating {minutes:g} minutes of driving; friction {healthy:g} N·m, from half-way on {risen:g} N·m"
    )
    with progress("driving") as advance:
        recording = drive(minutes=minutes, friction=course, seed=seed)
        advance(1.0)
    output.mkdir(parents=True, exist_ok=True)
    path = output / "demo-drive.parquet"
    write(recording, path)
    terminal.print(f"recording: {path}", soft_wrap=True, markup=False)
    command = shlex.join(["tierod", "diagnose", str(path), "--vehicle", "midsize-eps"])
    terminal.print(f"judging it, as this command does: {command}", soft_wrap=True, markup=False)
    diagnosis = diagnose(path, "midsize-eps", command=command)
    show(diagnosis, as_json=False, path=output / "demo-friction.html", console=console, messages=messages)
    return 0
