"""Many processes at once on what they share: kernel cache, fault memory, baseline, vehicle file, campaign folder."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import time
import traceback
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError, OutputError
from tierod.core.findings import Diagnosis, Finding, Status
from tierod.core.graph import compiler
from tierod.core.graph.kernel_cache import Bounds, KernelCache
from tierod.core.recording import Aligned, Recording
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.monitors.baseline import Baseline, keep_first, load_baseline
from tierod.monitors.memory import MemoryFeed
from tierod_lab.campaign.store import Store

VEHICLE = "midsize-eps"


def run(count: int, seed: int, folder: Path) -> dict[str, dict[str, int]]:
    """Let a crowd of processes loose on everything that is shared."""
    found = {}
    for name, crowd in ALL.items():
        place = folder / name
        place.mkdir()
        found[name] = crowd(count, seed, place)
    return found


def at_once(count: int, work: Callable[[int], Any]) -> list[Any]:
    """What each of many processes gives for its number: they begin together, and a death or an error is a text."""
    reading, writing = os.pipe()  # closed by the parent when all are there
    children = []
    for number in range(count):
        answers, answer = os.pipe()
        pid = os.fork()
        if pid == 0:
            os.close(writing)
            os.read(reading, 1)
            with os.fdopen(answer, "w") as pipe:
                json.dump(_answered(work, number), pipe)
            os._exit(0)
        os.close(answer)
        children.append((pid, answers))
    os.close(reading)
    os.close(writing)
    return [_result(*child) for child in children]


def _answered(work: Callable[[int], Any], number: int) -> Any:
    try:
        return work(number)
    except BaseException:
        return {"error": traceback.format_exc()}


def _result(pid: int, answers: int) -> Any:
    with os.fdopen(answers) as pipe:
        text = pipe.read()
    _, status = os.waitpid(pid, 0)
    return json.loads(text) if text else {"error": f"ended with {os.waitstatus_to_exitcode(status)}"}


def _wrong(answers: list[Any]) -> int:
    return sum(isinstance(answer, dict) and "error" in answer for answer in answers)


def kernels(count: int, seed: int, folder: Path) -> dict[str, int]:
    """All load the same kernels in orders of their own, while one of them cuts, flips and removes what is kept."""
    # Named after the folder: no other cache may hold them from an earlier run.
    sources = [f"/* {folder} */ int one(void); int one(void) {{ return {number}; }}" for number in range(4)]

    def load(number: int) -> int:
        chance, wrong = random.Random(f"{seed} {number}"), 0
        if number == count - 1 and count > 2:
            _spoil(folder / "cache", chance)
            return 0
        for _ in range(3):
            for which in chance.sample(range(len(sources)), len(sources)):
                wrong += compiler.load(sources[which], "kernel").one() != which
        return wrong

    before = os.environ.get("TIEROD_CACHE")
    os.environ["TIEROD_CACHE"] = str(folder / "cache")
    try:
        answers = at_once(count, load)
        left = [path.name for path in (folder / "cache").iterdir() if not path.name.endswith(".kernel")]
        again = [compiler.load(source, "kernel").one() for source in sources] != list(range(len(sources)))
    finally:
        os.environ.pop("TIEROD_CACHE") if before is None else os.environ.update(TIEROD_CACHE=before)
    misread = sum(answer for answer in answers if isinstance(answer, int))
    return {"processes": count, "wrong": _wrong(answers) + misread + len(left) + again}


def _spoil(cache: Path, chance: random.Random) -> None:
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        for path in list(cache.glob("kernel-*.kernel")):
            try:
                how = chance.randrange(4)
                if how == 0:
                    os.truncate(path, chance.randrange(1, 16_000))
                elif how == 1:
                    with path.open("r+b") as file:
                        file.seek(chance.randrange(16_000))
                        file.write(b"\xff")
                elif how == 2:
                    path.unlink()
                else:
                    KernelCache(cache, Bounds(count=1, recent=0.0)).prune()
            except OSError:
                pass
        time.sleep(chance.uniform(0.0, 0.02))


def memory(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Each adds a recording to one fault memory; every fourth recording is one that another process adds too."""
    path = folder / "memory.json"
    recordings = [str(number - 1 if number % 4 == 3 else number) for number in range(count)]
    time_ = np.arange(50) / 10.0
    MemoryFeed(path, VEHICLE, "friction")  # traces here, once, what every process would trace for itself

    def add(number: int) -> str:
        feed = MemoryFeed(path, VEHICLE, "friction")
        feed.add(Aligned(time_, time_[:, None], ("vehicle_speed",)), 10.0)
        status = Status.FAULT if random.Random(f"{seed} {number}").random() < 0.5 else Status.HEALTHY
        diagnosis = Diagnosis((Finding("friction", status, ""),), created=f"{number}")
        try:
            feed.finish(diagnosis, (), recording=recordings[number])
        except (InputError, OutputError) as error:
            return str(error)
        return "counted"

    answers = at_once(count, add)
    found = FaultMemory.opened(path, VEHICLE)
    counted, different = answers.count("counted"), len(set(recordings))
    twice = sum("already contains this recording" in str(answer) for answer in answers)
    lost = different - found.cycles
    wrong = abs(counted - different) + abs(twice - (count - different)) + abs(lost) + len(_strays(folder))
    return {"processes": count, "counted": counted, "refused": twice, "wrong": wrong}


def baseline(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Each has learnt a baseline for the same file: one writes it, the others leave it as it is."""
    path = folder / "car.json"

    def learn(number: int) -> str:
        return keep_first(Baseline(VEHICLE, "friction", 1.0 + number, 0.1, "N*m", 100.0), path)

    answers = at_once(count, learn)
    writers = [number for number, answer in enumerate(answers) if str(answer).startswith("written to")]
    left = sum("by another program in the meantime" in str(answer) for answer in answers)
    whose = round(load_baseline(path).value - 1.0)
    wrong = abs(len(writers) - 1) + (count - 1 - left) + (writers != [whose]) + len(_strays(folder))
    return {"processes": count, "written": len(writers), "left": left, "wrong": wrong}


def campaign(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Each tries to hold one campaign folder; a refusal is wrong while no other process holds it."""
    store = Store(folder / "runs")
    store.prepare()

    def work(number: int) -> dict[str, Any]:
        chance = random.Random(f"{seed} {number}")
        key, refused = _key(number), []
        while True:
            began = time.monotonic()
            try:
                with store.alone():
                    entered = time.monotonic()
                    store.keep_drive("a", key, {"number": number})
                    store.keep_verdict("a", key, {"number": number})
                    time.sleep(chance.uniform(0.0, 0.01))
                    left = time.monotonic()
                # The lock may outlast `left` by as long as this process waits for a core.
                return {"held": (began, time.monotonic()), "inside": (entered, left), "refused": refused}
            except OutputError:
                refused.append((began, time.monotonic()))
                time.sleep(chance.uniform(0.0, 0.02))

    answers = at_once(count, work)
    well = [answer for answer in answers if "held" in answer]
    held = [answer["held"] for answer in well]
    refused = [each for answer in well for each in answer["refused"]]
    groundless = sum(not any(a <= end and start <= b for start, end in held) for a, b in refused)
    kept = sum(
        store.drive("a", _key(number)) is not None and store.verdict("a", _key(number)) is not None
        for number in range(count)
    )
    inside = sorted(answer["inside"] for answer in well)
    together = sum(second[0] < first[1] for first, second in pairwise(inside))
    wrong = _wrong(answers) + groundless + together + (count - kept)
    return {"processes": count, "refusals": len(refused), "wrong": wrong}


def commands(count: int, seed: int, folder: Path) -> dict[str, int]:
    """`tierod diagnose` as users call it, all at once on one memory and one baseline; every fourth recording twice."""
    from tierod.io.writers import write
    from tierod_lab.ground import drive

    whole = Recording(drive(minutes=8.0, seed=seed).channels)
    for number in range(count):
        write(whole.slice(0.0, 400.0 + (number - 1 if number % 4 == 3 else number)), folder / f"{number}.parquet")
    kept = ("--memory", "memory.json", "--baseline", "car.json", "--no-report")
    running = [
        subprocess.Popen(
            [sys.executable, "-m", "tierod", "diagnose", f"{number}.parquet", "--vehicle", VEHICLE, *kept],
            cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for number in range(count)
    ]  # fmt: skip
    outputs = [process.communicate() for process in running]
    judged = sum(process.returncode in (0, 1, 2) for process in running)
    twice = sum("already contains this recording" in error for _, error in outputs)
    writers = sum("baseline: written to car.json" in output for output, _ in outputs)
    expected = count - count // 4
    cycles = FaultMemory.opened(folder / "memory.json", VEHICLE).cycles
    wrong = abs(judged - expected) + abs(twice - count // 4) + abs(cycles - expected) + abs(writers - 1)
    return {"processes": count, "counted": cycles, "refused": twice, "wrong": wrong + len(_strays(folder))}


def _key(number: int) -> str:
    return f"{number:012x}".ljust(64, "0")


def _strays(folder: Path) -> list[str]:
    return [path.name for path in folder.rglob(".*") if path.name != ".lock"]


CROWDS: dict[str, Callable[[int, int, Path], dict[str, int]]] = {
    "kernel cache": kernels,
    "fault memory": memory,
    "baseline": baseline,
    "campaign": campaign,
}
"""By what they share."""

ALL = {**CROWDS, "command": commands}
"""With the one that takes a minute."""
