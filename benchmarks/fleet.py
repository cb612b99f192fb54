"""Cost of a fleet: processor time per hour, memory, scaling, and overhead of the engine.

python -m benchmarks.fleet                 # all, on generated recordings of ten minutes
python -m benchmarks.fleet --seconds 3600  # longer recordings
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import sys
import tempfile
import time
from pathlib import Path

from tierod.fleet.fleet_file import one_vehicle
from tierod.fleet.judging import Asked, chunk, judge
from tierod.fleet.running import run
from tierod.monitors.pieces import pieces_of
from tierod.monitors.runner import Chosen, usual
from tierod.vehicles import load
from tierod.work.cluster import workers_of
from tierod.work.pool import cores

VEHICLE = "midsize-eps"
FRICTION = Asked((Chosen("friction"),))
EXACT = Asked(FRICTION.monitors, spread=False)


def recordings(folder, count, seconds):
    """Recordings that differ in their noise, because identical ones would be rejected as duplicates."""
    import numpy as np

    from tierod.core.recording import Recording
    from tierod.io.writers import write
    from tierod_lab.ground.scenarios import load as scenario

    made = scenario("mixed-drive-healthy").with_run(seconds=seconds, seed=1).run().recording
    names = [name for name in made.names if not name.startswith("truth_")]
    for number in range(count):
        chance = np.random.default_rng(number)
        channels = {name: made[name] for name in names}
        speed = channels["vehicle_speed"]
        noise = chance.normal(0.0, 1e-4, len(speed.values))
        channels["vehicle_speed"] = type(speed)(speed.name, speed.time, speed.values + noise, speed.unit)
        write(Recording(channels, {"origin": 1.79e9 + 7200.0 * number}), folder / f"{number}.parquet")
    return sorted(folder.glob("*.parquet"))


def alone(path, asked, repeats):
    """Processor time of judging a recording without the engine, best of some repeats [s]."""
    car = load(VEHICLE)
    best = float("inf")
    for _ in range(repeats):
        began = time.process_time()
        runner = asked.runner(car)
        judge(pieces_of(path, runner.needs, car, seconds=chunk(asked)), runner, asked)
        best = min(best, time.process_time() - began)
    return best


def judged(paths, folder, workers, asked, with_levels=True):
    """(elapsed time [s], summary) of a run into a new folder."""
    shutil.rmtree(folder, ignore_errors=True)
    began = time.perf_counter()
    found = run(list(map(str, paths)), one_vehicle(VEHICLE), folder, asked, workers, with_levels=with_levels)
    return time.perf_counter() - began, found


def engine(paths, folder, workers, asked):
    """Overhead of the engine as a share of the processor time of its tasks, from the first result to the last.

    It is the processor time of this process, which distributes tasks, keeps the ledger and runs the scheduler of Dask.
    Processor time is independent of other programs, and excludes waiting for pipes.
    """
    shutil.rmtree(folder, ignore_errors=True)
    seen = []
    found = run(
        list(map(str, paths)), one_vehicle(VEHICLE), folder, asked, workers,
        progress=lambda progress: seen.append((time.process_time(), progress.name)),
    )  # fmt: skip
    first = next(at for at, (_, name) in enumerate(seen) if name)
    busy = sum(found.rows[name]["processor_s"] for _, name in seen[first + 1 :])
    return (seen[-1][0] - seen[first][0]) / busy


def size_of(folder):
    return sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())


class Shown(dict):
    """Figures that are printed as soon as they are measured, so that an interrupted run is not lost."""

    def __setitem__(self, name, value):
        print(f"{name}: {value}", file=sys.stderr, flush=True)
        super().__setitem__(name, value)


def measured(seconds, count):
    with tempfile.TemporaryDirectory(prefix="tierod-bench-") as top:
        top = Path(top)
        (top / "drives").mkdir()
        paths = recordings(top / "drives", count, seconds)
        per_hour = 3600.0 / seconds
        figures = Shown(machine=platform.machine(), cores=cores(), load=os.getloadavg()[0])
        figures |= {"recordings": count, "seconds": seconds, "recording_bytes": paths[0].stat().st_size}
        every = Asked(usual())
        exact = Asked(usual(), spread=False)
        for name, asked in (("friction", FRICTION), ("all", every), ("friction_exact", EXACT), ("all_exact", exact)):
            figures[f"{name}_alone_ms_per_hour"] = 1e3 * per_hour * alone(paths[0], asked, 3)
            _, found = judged(paths, top / name, workers_of(1), asked)
            figures[f"{name}_fleet_ms_per_hour"] = 1e3 * found.processor / found.hours
            figures[f"{name}_memory_MB"] = found.memory / 1e6
            figures[f"{name}_result_bytes_per_hour"] = size_of(top / name) / found.hours
        one, alone_found = judged(paths, top / "one", workers_of(1), FRICTION)
        two, both_found = judged(paths, top / "two", workers_of(2), FRICTION)
        figures["one_to_two_workers"] = one / two
        figures["processor_growth"] = both_found.processor / alone_found.processor - 1.0
        figures["engine_overhead"] = min(engine(paths, top / "e", workers_of(1), FRICTION) for _ in range(2))
        return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--count", type=int, default=12)
    given = parser.parse_args()
    json.dump(measured(given.seconds, given.count), sys.stdout, indent=2)
    print()


if __name__ == "__main__":
    main()
