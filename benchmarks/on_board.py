"""The whole condition monitor, bank, rules, substitutes and counters of the fault memory, in times real time."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from tierod.graph import Bank, scan
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.on_board import on_board
from tierod.monitors.condition.vehicle_bank import bank_of
from tierod.studies.condition.drives import Drive, actuator_tests, healthy_drives, sensor_tests
from tierod.studies.condition.recorded import recorded
from tierod.vehicles import load

LANES, STATES, READINGS = 50, len(AutomatedVehicle.State._fields), len(AutomatedVehicle.Output._fields)
"""Filters of the bank without that of sliding tyres, what each estimates, what corrects it."""
RATE = 100.0
STEPS = 6_000
PEER_STEPS = 100
REPEATS = 5
VARIANTS = ("rules", "rules-discriminating", "rules-printed")


def run() -> list[dict]:
    """One row: hours of driving judged in an hour of one core, against the same filters' algebra alone in NumPy."""
    healthy, faulty = _samples(healthy_drives(1.0)[0]), _samples(sensor_tests(1)[0])
    lost = _samples(actuator_tests(1)[0])
    vehicle = load("smartload")
    whole = on_board(vehicle)
    value = _times_real_time(whole, healthy)
    peer = PEER_STEPS / RATE / _least(_numpy_bank)
    return [
        {
            "name": "condition-on-board",
            "value": value,
            "unit": "x real time",
            "peer": "NumPy, 50 filters' covariances alone",
            "peer_value": peer,
            "ratio": value / peer,
            "sensor_lost": _times_real_time(whole, faulty),
            "motor_lost": _times_real_time(whole, lost),
            "bank_alone": _times_real_time(bank_of(vehicle), healthy),
            "three_rule_tables": _times_real_time(on_board(vehicle, rules=VARIANTS), healthy),
        }
    ]


def _samples(drive: Drive) -> np.ndarray:
    recording = recorded(drive)
    columns = [recording[name].values for name in on_board(load("smartload")).Sample._fields]
    return np.ascontiguousarray(np.column_stack(columns)[:STEPS])


def _times_real_time(block: Bank, samples: np.ndarray) -> float:
    scan(block, samples[:10])
    return len(samples) / RATE / _least(partial(scan, block, samples))


def _least(work: Callable[[], object]) -> float:
    """Seconds of processor time of the fastest of several runs: others may load the machine."""
    seconds = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        seconds.append(time.process_time() - begin)
    return min(seconds)


def _numpy_bank() -> np.ndarray:
    """Prediction and correction of all lanes at once as arrays; model, derivatives and judge left out."""
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
