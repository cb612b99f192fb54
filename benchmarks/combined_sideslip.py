"""Extended Kalman filter of the combined sideslip estimator, compared with filterpy's with numerical Jacobians.

The functions around the filter (holding, gates, limits and their reports) are excluded on both sides.
"""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np

from tierod.core.block import Block, rebuild, skeleton
from tierod.core.graph.trace import trace
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.monitors.sideslip.estimator import CombinedSideslip
from tierod.vehicles import load

STEPS = 20_000
"""Samples of one run: 200 s at 100 Hz."""

RATE = 0.01
STEP = 1e-5
"""Step of the numerical differences, in states with a magnitude of one."""


class ByDifferences:
    """filterpy's `ExtendedKalmanFilter` for a model that is evaluated in plain Python."""

    def __init__(self, block: KalmanFilter):
        self.block, self.model = block, block.model
        self.shape, self.inputs = skeleton(block.model.State), skeleton(block.model.Input)

    def __call__(self, samples: np.ndarray) -> tuple[np.ndarray, float]:
        """Lateral speeds and yaw rates, and duration [s]."""
        from filterpy.kalman import ExtendedKalmanFilter as Peer

        block, count = self.block, len(self.block.model.Input._fields)
        n, m = len(self.model.State._fields), len(self.model.Output._fields)
        peer = Peer(dim_x=n, dim_z=m)
        peer.x, peer.P = np.array(block.initial_mean, float), np.diag(block.initial_variance)
        peer.Q, peer.R = np.diag(block.process_noise), np.diag(block.measurement_noise)
        found = np.empty((len(samples), n))
        start = time.perf_counter()
        for k, row in enumerate(samples):
            given = rebuild(self.inputs, row[:count].tolist())

            def ahead(x: np.ndarray, given: Any = given) -> np.ndarray:
                return np.array(self.model.transition(rebuild(self.shape, x.tolist()), given, block.parameters))

            def shown(x: np.ndarray, given: Any = given) -> np.ndarray:
                return np.array(self.model.output(rebuild(self.shape, x.tolist()), given, block.parameters))

            F = _differences(ahead, peer.x)
            peer.x = ahead(peer.x)
            peer.P = F @ peer.P @ F.T + peer.Q
            peer.update(row[count:], lambda x, shown=shown: _differences(shown, x), shown)
            found[k] = peer.x
        return found[:, :2], time.perf_counter() - start


def _differences(function: Any, at: np.ndarray) -> np.ndarray:
    """Jacobian by central differences."""
    steps = STEP * np.eye(len(at))
    return np.column_stack([(function(at + step) - function(at - step)) / (2.0 * STEP) for step in steps])


def observers() -> list[tuple[str, Block, np.ndarray, Any, tuple[str, ...]]]:
    """Name, our block, samples, peer, and compared outputs, with and without the steering torque."""
    rows = []
    for name, steering in (("sideslip-combined-torque", True), ("sideslip-combined", False)):
        whole = CombinedSideslip.of_vehicle(load("steer-by-wire"), RATE, steering=steering)
        block = dataclasses.replace(whole.filter, gate=None)
        rows.append((name, block, _samples(block), ByDifferences(block), ("mean.lateral_speed", "mean.yaw_rate")))
    return rows


def _samples(block: KalmanFilter) -> np.ndarray:
    """Noisy samples of sinusoidal steering of a linear car at 25 m/s, with the columns of the filter's sample."""
    chance, time_ = np.random.default_rng(0), np.arange(STEPS) * RATE
    sine = np.sin(2.0 * np.pi * 0.3 * time_)
    known = {
        "input.vehicle_speed": np.full(STEPS, 25.0),
        "input.longitudinal_acceleration": np.zeros(STEPS),
        "input.road_wheel_angle": 0.02 * sine,
        "input.road_wheel_torque": 90.0 * sine,
        "input.torque_known": np.ones(STEPS),
        "measured.yaw_rate": 0.13 * sine + 0.003 * chance.normal(size=STEPS),
        "measured.lateral_acceleration": 3.2 * sine + 0.1 * chance.normal(size=STEPS),
        "measured.road_wheel_angle": 0.02 * sine + 2e-4 * chance.normal(size=STEPS),
    }
    return np.column_stack([known[name] for name in trace(block).sample])
