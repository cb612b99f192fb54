"""Block of the condition monitor that `diagnose` runs, as a multiple of real time.

Because other processes load the machine, the smallest processor time of several whole runs counts, for ours and for the
peer's alike.
"""

from __future__ import annotations

import time

import numpy as np

from benchmarks.timing import fastest, row, single
from tierod.core.graph import Bank
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.definition import condition_monitor
from tierod.monitors.condition.signals import ConditionSample, hypotheses
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import Drive, actuator_tests, healthy_drives, sensor_tests
from tierod_lab.papers.condition.recorded import recorded

LANES, STATES, READINGS = len(hypotheses()), len(AutomatedVehicle.State._fields), len(AutomatedVehicle.Output._fields)
"""Number of filters in the bank without that for sliding tyres, of their states, and of their measurements."""
RATE = 100.0
STEPS = 6_000
PEER_STEPS = 100
REPEATS = 10


def run() -> list[dict]:
    """One row: hours of driving judged per hour of one core, compared with the filters' algebra alone in NumPy."""
    healthy, faulty = _samples(healthy_drives(1.0)[0]), _samples(sensor_tests(1)[0])
    lost = _samples(actuator_tests(1)[0])
    whole = condition_monitor(load("smartload"))
    value = _times_real_time(whole, healthy)
    peer = PEER_STEPS / RATE / fastest(_numpy_bank, REPEATS, time.process_time)
    return [
        row(
            "condition-on-board",
            value,
            "x real time",
            f"NumPy, {LANES} filters' covariances alone",
            peer,
            sensor_lost=_times_real_time(whole, faulty),
            motor_lost=_times_real_time(whole, lost),
            decision_alone=_times_real_time(Bank(whole.lanes, whole.judge.decision), healthy),
        )
    ]


def _samples(drive: Drive) -> np.ndarray:
    recording = recorded(drive)
    length = max(len(recording[name].values) for name in ConditionSample._fields if name in recording)
    absent = np.full(length, np.nan)  # signals that these cars lack
    columns = [recording[name].values if name in recording else absent for name in ConditionSample._fields]
    return np.ascontiguousarray(np.column_stack(columns)[:STEPS])


def _times_real_time(block: Bank, samples: np.ndarray) -> float:
    """Seconds of driving per second of processor time, in the fastest run."""
    return 1e9 / RATE / single(block, samples, REPEATS, clock=time.process_time)[0]


def _numpy_bank() -> np.ndarray:
    """Prediction and correction of all filters at once as arrays, without model, derivatives and judge."""
    transition = np.tile(np.eye(STATES) + 0.01 * np.eye(STATES, k=1), (LANES, 1, 1))
    noise, rows = 1e-4 * np.eye(STATES), np.tile(np.eye(READINGS, STATES), (LANES, 1, 1))
    mean, covariance = np.zeros((LANES, STATES)), np.tile(np.eye(STATES), (LANES, 1, 1))
    variance, readings = 0.1 * np.eye(READINGS), np.random.default_rng(0).normal(size=(PEER_STEPS, READINGS))
    turned, back = rows.transpose(0, 2, 1), transition.transpose(0, 2, 1)
    for reading in readings:
        mean = (transition @ mean[:, :, None])[:, :, 0]
        covariance = transition @ covariance @ back + noise
        cross = covariance @ turned
        gain = np.linalg.solve(rows @ cross + variance, cross.transpose(0, 2, 1)).transpose(0, 2, 1)
        innovation = reading - (rows @ mean[:, :, None])[:, :, 0]
        mean = mean + (gain @ innovation[:, :, None])[:, :, 0]
        covariance = covariance - gain @ cross.transpose(0, 2, 1)
    return covariance
