"""Many processes at once on what they share: kernel cache, fault memory, baseline."""

from __future__ import annotations

import json
import os
import random
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError, OutputError
from tierod.core.findings import Diagnosis, Finding, Status
from tierod.core.graph import compiler
from tierod.core.graph.kernel_cache import Bounds, KernelCache
from tierod.core.recording import Aligned
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.monitors.baseline import Baseline, keep_first, load_baseline
from tierod.monitors.memory import MemoryFeed

VEHICLE = "midsize-eps"


def run(count: int, seed: int, folder: Path) -> dict[str, dict[str, int]]:
    """Let a crowd of processes loose on everything that is shared."""
    found = {}
    for name, crowd in CROWDS.items():
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


def _strays(folder: Path) -> list[str]:
    return [path.name for path in folder.rglob(".*") if path.name != ".lock"]


CROWDS: dict[str, Callable[[int, int, Path], dict[str, int]]] = {
    "kernel cache": kernels,
    "fault memory": memory,
    "baseline": baseline,
}
"""By what they share."""
