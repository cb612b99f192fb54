"""Duration of the sensor and actuator tests of one vehicle, and of an hour of fault-free driving with its judgement.

Run it by `python -m benchmarks.condition_tests`. The preceding calibration of the vehicle is not included.
"""

from __future__ import annotations

import resource
import sys
import time
from typing import NamedTuple

from tierod_lab.papers.condition.drives import Drive, actuator_tests, healthy_drives, sensor_tests
from tierod_lab.papers.condition.runs import BEST, calibrations, scores
from tierod_lab.studies.effort import Effort

VEHICLE = 1
HOURS = 100.0  # Hours of fault-free driving in the thorough study [h]


class Took(NamedTuple):
    """Elapsed time, and processor time of all processes [s]."""

    clock: float
    processors: float


def main() -> int:
    """Measure and print; returns the exit code."""
    effort = Effort(processes=2)
    calibrations((BEST,), (VEHICLE,), effort)
    tests = [*sensor_tests(VEHICLE), *actuator_tests(VEHICLE)]
    took, driven = _timed(tests, effort), sum(each.seconds for each in tests)
    print(f"{len(tests)} tests, {driven:.0f} s of driving: {took.clock:.1f} s, {took.processors:.1f} s of processor")
    legs = healthy_drives(1.0, (VEHICLE,))
    took, driven = _timed(legs, effort), sum(each.seconds for each in legs)
    print(f"{driven / 3600.0:.1f} h healthy: {took.clock:.1f} s, {took.processors:.1f} s of processor")
    minutes = took.processors / 2.0 / driven * HOURS * 60.0
    print(f"{HOURS:.0f} h would keep two free processors busy for {minutes:.0f} minutes")
    return 0


def _timed(drives: list[Drive], effort: Effort) -> Took:
    """Times from the first drive to the last score, with two processes."""
    begin, before = time.perf_counter(), _processors()
    scores(drives, effort, (BEST,))
    return Took(time.perf_counter() - begin, _processors() - before)


def _processors() -> float:
    """Processor time of this process and of its finished children [s]."""
    own, others = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return own.ru_utime + own.ru_stime + others.ru_utime + others.ru_stime


if __name__ == "__main__":
    sys.exit(main())
