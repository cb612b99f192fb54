"""Part of `tierod simulate`: a virtual fleet, simulated drive by drive or drawn at estimate level."""

from __future__ import annotations

import shlex
import time
from dataclasses import replace
from pathlib import Path


def simulate_fleet(
    path: str,
    folder: Path,
    seed: int | None,
    seconds: float | None,
    estimates: bool,
    workers: int | None,
    as_json: bool,
) -> int:
    """Write a virtual fleet, and return an exit code: all drives written (0), some failed (2).

    Args:
        seed, seconds: seed and duration of a drive [s]; None for those of the file
        workers: number of processes; None for one per core
    """
    from tierod.cli.terminal import print_json, print_remark, progress, say
    from tierod.work.pool import cores
    from tierod_lab.fleet import virtual
    from tierod_lab.fleet import writing as virtual_writing

    file = virtual.load(path)
    file = file if seed is None else replace(file, seed=seed)
    file = file if seconds is None else replace(file, duration=seconds)
    cars, began = virtual.drawn(file), time.perf_counter()
    failures: list[str] = []
    if estimates:
        virtual_writing.write_estimates(cars, folder, virtual_writing.shipped_law())
    else:
        with progress(f"driving {file.cars} cars") as advance:
            failures = virtual_writing.write_drives(
                cars, folder, workers or cores(), lambda done, of: advance(done / of)
            )
    took = time.perf_counter() - began
    for failure in failures[:10]:
        print_remark(f"failed: {failure}")
    drives = [str(folder / "recordings"), "--vehicles", str(folder / "fleet.toml"), "-o", "results"]
    words = ["tierod", "fleet", *(["report", str(folder)] if estimates else drives)]
    if as_json:
        print_json({
            "schema": "tierod.virtual-fleet/1", "folder": str(folder), "cars": file.cars, "drives": int(cars.day.size),
            "failed": len(failures), "estimate_level": estimates, "seed": file.seed, "seconds": took,
        })  # fmt: skip
    else:
        how = "drawn at estimate level, from measured errors" if estimates else f"driven in {took:.3g} s"
        say(f"{file.name}: {file.cars} cars, {cars.day.size} drives {how}: {folder}")
        say(f"go on with: {shlex.join(words)}")
    return 2 if failures else 0
