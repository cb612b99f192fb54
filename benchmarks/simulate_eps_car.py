"""Virtual EPS car with sensors, compared with the chassis of CommonRoad's multi-body car, and scaling of drives."""

from __future__ import annotations

import os
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from benchmarks.timing import row
from tierod_lab.ground import EpsCar, drive
from tierod_lab.ground.chassis import SingleTrack

SECONDS = 300.0
INTERPRETED_SECONDS = 2.0
REPEATS = 3
COMMONROAD_STEPS = 300


def run() -> list[dict]:
    """One row: speed of the two-track car on one core as a multiple of real time, with its recording."""
    # The first drive compiles the kernels.
    _driven(5.0)
    two_track = _times_real_time()
    peer = _commonroad()
    return [
        row(
            "simulate-eps-car",
            two_track,
            "times real time",
            "CommonRoad multi-body car, RK4 at 1 kHz",
            peer,
            without_compiler=_interpreted(),
            single_track=_times_real_time(EpsCar(chassis=SingleTrack())),
            two_cores_over_one=_scaling(),
        )
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


def _commonroad() -> float:
    """Speed of another open simulator's chassis, integrated in Python as its users do, as a multiple of real time."""
    from vehiclemodels.init_mb import init_mb
    from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
    from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

    parameters = parameters_vehicle2()
    state = np.array(init_mb([0.0, 0.0, 0.0, 20.0, 0.0, 0.0, 0.0], parameters))

    def rate(at: np.ndarray) -> np.ndarray:
        return np.array(vehicle_dynamics_mb(at, [0.02, 0.0], parameters))

    start = time.perf_counter()
    for _ in range(COMMONROAD_STEPS):
        first = rate(state)
        second = rate(state + 0.5e-3 * first)
        third = rate(state + 0.5e-3 * second)
        fourth = rate(state + 1e-3 * third)
        state = state + 1e-3 / 6.0 * (first + 2.0 * (second + third) + fourth)
    return COMMONROAD_STEPS * 1e-3 / (time.perf_counter() - start)


def _scaling() -> float:
    """Speed-up of eight drives by two processes over one."""
    times = {}
    for workers in (1, 2):
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            list(pool.map(_driven, [5.0] * 2 * workers))
            start = time.perf_counter()
            list(pool.map(_driven, [SECONDS] * 8))
            times[workers] = time.perf_counter() - start
    return times[1] / times[2]
