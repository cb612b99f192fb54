"""Commands that write, killed at random moments: nothing breaks, what was finished is kept, and the next run works."""

from __future__ import annotations

import hashlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LEFT = re.compile(r"\..+\.[0-9a-f]{12}(\.\w+)?")
"""Names of files that were being written when their process was killed."""

SLOWEST = 300.0
"""Seconds after which a run that was not killed is taken for a hang."""

LAUNCH = """
import resource, signal, sys
last_byte = int(sys.argv.pop(1))
from tierod.cli import main
if last_byte:
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_FSIZE, (last_byte, last_byte))
if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
"""
"""A run that dies where any file that it writes, in memory or on the disk, reaches a size."""


def run(count: int, seed: int, folder: Path) -> dict[str, dict[str, int]]:
    """For each command what happened how often; all is well where broken, lost, hindered and strays are 0."""
    places = [_prepared(each, folder / each.name.replace(" ", "-"), folder / "cache") for each in COMMANDS]
    found = {each.name: dict.fromkeys(FIGURES, 0) for each in COMMANDS}
    for number in range(count):
        which = number % len(COMMANDS)
        kill = _killed(COMMANDS[which], places[which], random.Random(f"{seed} {number}"))
        for figure, value in kill.items():
            found[COMMANDS[which].name][figure] += value
    return found


FIGURES = ("runs", "killed", "while writing", "broken", "lost", "hindered", "strays")


@dataclass(frozen=True)
class Place:
    """Where a command is killed."""

    folder: Path
    seconds: float
    code: int
    kernels: Path


def _prepared(command: Command, folder: Path, kernels: Path) -> Place:
    """Inputs, what lies there before, and how long the command takes once its kernels are compiled."""
    for name in ("inputs", "before", "work"):
        (folder / name).mkdir(parents=True)
    command.inputs(folder / "inputs")
    for arguments in command.before:
        assert _run(arguments, folder / "before", kernels) in (0, 1)
    seconds, code = SLOWEST, 0
    for _ in range(2):
        _fresh(folder)
        began = time.monotonic()
        code = _run(command.arguments, folder / "work", kernels)
        seconds = time.monotonic() - began
        assert code in (0, 1, 2), f"{command.name} ends with {code}"
    _fresh(folder)
    return Place(folder, seconds, code, kernels)


def _fresh(folder: Path) -> None:
    shutil.rmtree(folder / "work")
    shutil.copytree(folder / "before", folder / "work")


def _killed(command: Command, place: Place, chance: random.Random) -> Counter[str]:
    """One kill, and all that is seen after it."""
    work, figures = place.folder / "work", Counter(runs=1)
    if not command.resumes or (work / "runs" / "report.html").exists():
        _fresh(place.folder)
    if chance.random() < 0.2:
        shutil.rmtree(place.kernels, ignore_errors=True)  # killed while it compiles
    before = _contents(work)
    figures["killed"] += _is_killed(command, place, chance)
    after = _contents(work)
    figures["while writing"] += any(_being_written(work))
    figures["broken"] += sum(after[name] != before.get(name) and _is_broken(work / name) for name in after)
    done = [name for name in before if not LEFT.fullmatch(Path(name).name)]
    figures["lost"] += sum(name not in after for name in done)
    if command.resumes:  # what is finished does not change any more
        figures["lost"] += sum(after.get(name, before[name]) != before[name] for name in done if "verdicts" in name)
    if (command.resumes or after == before) and chance.random() < 0.7:
        return figures
    aged = chance.random() < 0.5
    for path in _being_written(work) if aged else ():
        os.utime(path, (0, 0))
    figures["hindered"] += _is_hindered(command, place)
    figures["strays"] += aged and any(_being_written(work))
    return figures


def _is_killed(command: Command, place: Place, chance: random.Random) -> bool:
    """Run and kill, unless it ends before: at a moment, at a byte of a file, or just when a file is being written."""
    work, how = place.folder / "work", chance.choice(("moment", "byte", "writing"))
    last_byte = round(10.0 ** chance.uniform(1.0, 7.0)) if how == "byte" else 0
    process = _started(command.arguments, work, place.kernels, last_byte)
    end = time.monotonic() + (chance.uniform(0.0, 1.1 * place.seconds) if how == "moment" else SLOWEST)
    while process.poll() is None and time.monotonic() < end:
        if how == "writing" and any(_being_written(work)):
            time.sleep(chance.uniform(0.0, 0.03))
            break
        time.sleep(0.002)
    killed = process.poll() is None
    if killed:
        os.killpg(process.pid, signal.SIGKILL)
    return process.wait() < 0 or killed


def _being_written(work: Path) -> Iterator[Path]:
    return (path for path in work.rglob(".*") if LEFT.fullmatch(path.name))


def _is_hindered(command: Command, place: Place) -> bool:
    """Whether the same command does not run through now, or leaves something that is not whole."""
    work = place.folder / "work"
    code = _run(command.arguments, work, place.kernels)
    if command.once and code == 3:  # the killed run had counted already; without the memory it must do
        code = _run(
            [each for each in command.arguments if each not in ("--memory", "memory.json")], work, place.kernels
        )
    return code != place.code or any(_is_broken(work / name) for name in _contents(work))


def _started(arguments: Sequence[str], work: Path, kernels: Path, last_byte: int = 0) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-c", LAUNCH, str(last_byte), *arguments],
        cwd=work,
        env={**os.environ, "TIEROD_CACHE": str(kernels), "PYTHONWARNINGS": "default"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # its workers are killed with it
    )


def _run(arguments: Sequence[str], work: Path, kernels: Path) -> int:
    return _started(arguments, work, kernels).wait(SLOWEST)


def _contents(work: Path) -> Mapping[str, str]:
    """Every file below, with its digest."""
    files = (path for path in work.rglob("*") if path.is_file() and path.name != ".lock")
    return {path.relative_to(work).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def _is_broken(path: Path) -> bool:
    if LEFT.fullmatch(path.name):
        return False
    check: Any = next((each for pattern, each in WHOLE.items() if path.match(pattern)), None)
    if check is None:
        return True
    try:
        check(path)
    except Exception:
        return True
    return False


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
    """A command that writes."""

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
