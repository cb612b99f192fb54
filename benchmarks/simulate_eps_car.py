"""The virtual EPS car with its sensors, against the same car stepped by the virtual machine; and a campaign's scaling."""

from __future__ import annotations

import os
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from tierod.proving_ground import EpsCar, drive
from tierod.proving_ground.chassis import SingleTrack

SECONDS = 300.0
INTERPRETED_SECONDS = 2.0
REPEATS = 3


def run() -> list[dict]:
    """One row: times real time of the two-track car on one core, one drive with its recording after another."""
    _driven(5.0)
    two_track = _times_real_time()
    peer = _interpreted()
    return [
        {
            "name": "simulate-eps-car",
            "value": two_track,
            "unit": "times real time",
            "peer": "the same car on CasADi's virtual machine",
            "peer_value": peer,
            "ratio": two_track / peer,
            "single_track": _times_real_time(EpsCar(chassis=SingleTrack())),
            "two_cores_over_one": _scaling(),
        }
    ]


def _driven(seconds: float, car: EpsCar | None = None, seed: int = 1) -> float:
    start = time.perf_counter()
    drive(car, minutes=seconds / 60.0, seed=seed)
    return time.perf_counter() - start


def _times_real_time(car: EpsCar | None = None) -> float:
    _driven(5.0, car)
    return SECONDS / float(np.median([_driven(SECONDS, car, seed) for seed in range(REPEATS)]))


def _interpreted() -> float:
    os.environ["TIEROD_ENGINE"] = "virtual machine"
    try:
        return INTERPRETED_SECONDS / _driven(INTERPRETED_SECONDS)
    finally:
        del os.environ["TIEROD_ENGINE"]


def _scaling() -> float:
    """How much sooner two processes are done with eight drives than one."""
    times = {}
    for workers in (1, 2):
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            list(pool.map(_driven, [5.0] * 2 * workers))
            start = time.perf_counter()
            list(pool.map(_driven, [SECONDS] * 8))
            times[workers] = time.perf_counter() - start
    return times[1] / times[2]
