"""The whole command on an hour of driving, from process start to JSON, and its memory for ten hours."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks.filters import EnabledFilter, matrices, nanoseconds_per_step
from benchmarks.timing import row
from tierod.io.writers import write
from tierod.models.steering_column import FrictionParameters
from tierod.vehicles import load
from tierod_lab.ground import drive
from tierod_lab.papers.friction.presets import printed

RATE = 100.0
REPEATS = 5

WATCH = """
import os, subprocess, sys, time
start = time.perf_counter()
process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, usage = os.wait4(process.pid, 0)
print(time.perf_counter() - start, usage.ru_maxrss, os.waitstatus_to_exitcode(status))
"""


def run() -> list[dict]:
    """One row: seconds for an hour, compared with filterpy's filter alone over as many samples already in memory."""
    with tempfile.TemporaryDirectory() as folder:
        hour, ten = Path(folder, "hour.parquet"), Path(folder, "ten-hours.parquet")
        for minutes, path in ((60.0, hour), (600.0, ten)):
            # In a separate process, because the peak memory of a child process starts from that of its parent.
            maker = get_context("spawn").Process(target=_make, args=(minutes, path))
            maker.start()
            maker.join()
        # The first run fills the caches of kernels and byte code.
        _timed(hour, folder)
        hours = [_timed(hour, folder) for _ in range(REPEATS)]
        without_report = [_timed(hour, folder, "--no-report") for _ in range(REPEATS)]
        long = _timed(ten, folder)
    seconds, megabytes = (float(np.median(column)) for column in zip(*hours, strict=True))
    monitor = printed(load("midsize-eps").parameters_for(FrictionParameters))
    samples = np.random.default_rng(0).normal(size=(20_000, 6)) * 0.3
    step = nanoseconds_per_step(samples, matrices(EnabledFilter(monitor.filter, monitor.gate)))
    peer = step * 1e-9 * 3600.0 * RATE
    return [
        row(
            "diagnose-1h",
            seconds,
            "s",
            "filterpy, filter alone",
            peer,
            without_html_report_s=float(np.median([time_ for time_, _ in without_report])),
            memory_mb=megabytes,
            ten_hours_s=long[0],
            ten_hours_memory_mb=long[1],
        )
    ]


def _make(minutes: float, path: Path) -> None:
    write(drive(minutes=minutes, seed=1), path)


def _timed(recording: Path, folder: str, report: str = "--report") -> tuple[float, float]:
    """Seconds from start to end of the process, and its peak resident memory [MB]."""
    command = [
        sys.executable, "-m", "tierod", "diagnose", str(recording), "--vehicle", "midsize-eps", "--json", report,
    ]  # fmt: skip
    # With cached byte code, as in an installed package; compiling the sources takes 0.1 to 0.3 s.
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(Path(folder, "byte-code"))}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    # From a small process, because the peak memory of a child process starts from that of its parent.
    ran = subprocess.run([sys.executable, "-c", WATCH, *command], cwd=folder, env=environment, capture_output=True)
    seconds, kilobytes, code = map(float, ran.stdout.split())
    if code not in (0, 1):
        raise RuntimeError(f"'{' '.join(command)}' ended with {code:.0f}")
    return seconds, kilobytes / 1024.0
