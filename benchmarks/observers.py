"""Bank of constant gains of the driver torque monitor, compared with filterpy's: the same filters and results."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.timing import row, single
from tierod.core.graph.trace import trace
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.linear import LinearSystem
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.design import ColumnTuning, design
from tierod.vehicles import load
from tierod_lab.papers.column.benches import swept

STEPS, PEER_STEPS = 40_000, 1_500  # Samples of one run, and of the peer's, all of which are compared
PEER_REPEATS, REPEATS = 3, 7
TOLERANCE = 1e-6  # Relative, of the comparison


def run() -> list[dict]:
    """One row: name, value, unit, peer, its value, ratio (peer over ours)."""
    bench = swept("steps", STEPS * 1e-3, 1)
    # The filters require the motor torque of the preceding sample.
    before = np.r_[0.0, bench["motor_torque"][:-1]]
    signals = ("steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
    samples = np.column_stack([before, *(bench[name] for name in signals)])
    made = design(load("column-bench").parameters_for(ColumnParameters), 1e-3, ColumnTuning())
    system = made.observation.discrete
    ours, outputs = single(made.bank, samples, REPEATS)
    runs = [by_filterpy(made.bank, system, samples[:PEER_STEPS]) for _ in range(PEER_REPEATS)]
    columns = [trace(made.bank).output.index(f"mean.{name}") for name in system.states]
    mine, theirs = outputs[:PEER_STEPS, columns], runs[0][0]
    scale = np.abs(theirs).max(axis=0)
    difference = float((np.abs(mine - theirs) / np.where(scale > 0.0, scale, 1.0)).max())
    if not difference < TOLERANCE:
        raise AssertionError(f"the bank and its peer differ by {difference:.2g}; expected {TOLERANCE:g} at most")
    peer = 1e9 * min(seconds for _, seconds in runs) / PEER_STEPS
    return [row("observer-bank", ours, "ns/step", "filterpy", peer, difference=difference)]


def full(packed: tuple[float, ...]) -> np.ndarray:
    """Symmetric matrix from its packed upper triangle."""
    n = round(((8 * len(packed) + 1) ** 0.5 - 1) / 2)
    matrix = np.zeros((n, n))
    matrix[np.triu_indices(n)] = packed
    return matrix + np.triu(matrix, 1).T


def by_filterpy(block: StationaryBank, system: LinearSystem, samples: np.ndarray) -> tuple[np.ndarray, float]:
    """Estimates of `IMMEstimator` over filters with constant gain, with filterpy, and the time [s]."""
    from filterpy.kalman import IMMEstimator
    from filterpy.kalman import KalmanFilter as Peer

    class Steady(Peer):
        def predict(self, u: Any = None, *_: Any) -> None:
            self.predict_steadystate(u)

        def update(self, z: Any, *_: Any) -> None:
            self.update_steadystate(z)

    filters = []
    for noise in block.noises:
        peer = Steady(dim_x=len(system.A), dim_z=len(system.C), dim_u=system.B.shape[1])
        peer.F, peer.B, peer.H = system.A.copy(), system.B.copy(), system.C.copy()
        peer.K, peer.S = np.array(noise.gain), full(noise.innovation_covariance)
        peer.P, peer.Q, peer.R = full(noise.covariance), 0.0 * peer.Q, 0.0 * peer.R
        filters.append(peer)
    bank = IMMEstimator(filters, np.full(len(filters), 1.0 / len(filters)), np.array(block.switching))
    found, start = np.empty((len(samples), len(system.A))), time.perf_counter()
    for k in range(len(samples)):
        bank.predict(samples[k, :1, None])
        bank.update(samples[k, 1:, None])
        found[k] = bank.x[:, 0]
    return found, time.perf_counter() - start
