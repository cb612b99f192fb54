"""Commands that write, what they need beforehand, and what whole files of theirs are."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

CAMPAIGN = """name = "lost signals"
description = "Signals that are lost."
scenario = "base.toml"
seeds = [1, 2, 3]

[faults.yaw-rate]
element = "yaw_rate"
behaviour = "total-loss"
start = "10 s"

[[monitors]]
monitor = "friction"
vehicle = "midsize-eps"
baseline = "none"
"""
BASE = """name = "country"
description = "A country road."
car = "midsize-eps-light"
course = "country"
seconds = 20.0
"""


def _whole_page(path: Path) -> None:
    text = path.read_text(encoding="utf-8").lower()
    assert text.startswith("<!doctype html>")
    assert text.rstrip().endswith("</html>")


def _whole_json(path: Path) -> None:
    json.loads(path.read_text(encoding="utf-8"))


def _whole_recording(path: Path) -> None:
    from tierod.io.readers import read

    assert read(path).names


def _whole_table(path: Path) -> None:
    from tierod_lab.campaign.summary import read_table

    assert read_table(path)


def _whole_memory(path: Path) -> None:
    from tierod.diagnosis.fault_memory import FaultMemory

    assert not FaultMemory.opened(path).open


def _whole_baseline(path: Path) -> None:
    from tierod.monitors.baseline import load_baseline

    load_baseline(path)


def _whole_vehicle(path: Path) -> None:
    from tierod.vehicles import load

    load(path)


WHOLE = {
    "*.html": _whole_page,
    "memory*.json": _whole_memory,
    "car.json": _whole_baseline,
    "*.json": _whole_json,
    "*.toml": _whole_vehicle,
    "cells.parquet": _whole_table,
    "*.parquet": _whole_recording,
    "*.mf4": _whole_recording,
    "*.csv": _whole_recording,
}
"""What a whole file is, by its name; the first that fits counts."""


@dataclass(frozen=True)
class Command:
    """A command that writes.

    Args:
        name: of the case
        arguments: of the command line; inputs lie in ../inputs
        inputs: makes them, given their folder
        before: commands whose results lie there already
        once: whether a second run is refused where the first one has counted
        resumes: whether runs go on from what a killed one has finished; begun anew once a page is there
    """

    name: str
    arguments: tuple[str, ...]
    inputs: Callable[[Path], None]
    before: tuple[tuple[str, ...], ...] = ()
    once: bool = False
    resumes: bool = False


def _drives(folder: Path) -> None:
    from tierod.core.recording import Recording
    from tierod.io.writers import write
    from tierod_lab.ground import drive

    first = Recording(drive(minutes=4.0, seed=3).channels)
    write(first, folder / "first.parquet")
    write(first.slice(0.0, 225.0), folder / "second.parquet")


def _campaign(folder: Path) -> None:
    (folder / "c.toml").write_text(CAMPAIGN)
    (folder / "base.toml").write_text(BASE)


def _motor(folder: Path) -> None:
    from tierod.io.writers import write
    from tierod.vehicles.vehicle import SHIPPED
    from tierod_lab.ground.scenarios import load

    write(load("motor-bench-multisine").run().recording, folder / "drive.parquet")
    shutil.copy(SHIPPED / "motor-bench.toml", folder / "motor.toml")


def _judged(recording: str) -> tuple[str, ...]:
    kept = ("--baseline", "car.json", "--memory", "memory.json", "--signals", "signals.parquet", "-o", "page.html")
    return ("diagnose", f"../inputs/{recording}.parquet", "--vehicle", "midsize-eps", "--no-spread", *kept)


COMMANDS = (
    Command("diagnose anew", _judged("first"), _drives, once=True),
    Command("diagnose again", _judged("second"), _drives, (_judged("first"),), once=True),
    Command("clear faults", ("faults", "clear", "memory.json"), _drives, (_judged("first"),)),
    Command("campaign", ("campaign", "../inputs/c.toml", "-o", "runs", "--workers", "2"), _campaign, resumes=True),
    Command("simulate", ("simulate", "mixed-drive-healthy", "--seconds", "10", "-o", "drive.mf4"), lambda _: None),
    Command(
        "identify",
        ("identify", "motor", "../inputs/drive.parquet", "--vehicle", "../inputs/motor.toml", "-o", "found.toml",
         "--report", "page.html"),
        _motor,
    ),
)  # fmt: skip
