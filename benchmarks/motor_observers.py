"""Observers of a motor angle as printed in the paper, compared with NumPy: the same equations and results."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from tierod.core.block import Block
from tierod.core.graph.kernel import kernel
from tierod.core.graph.trace import initial_memory
from tierod.methods.estimators.kalman import KalmanFilter
from tierod_lab.papers.motor_angle.bench import SAMPLE_TIME, parameters, to_and_fro
from tierod_lab.papers.motor_angle.observers import RotorFrameObserver, extended_kalman, luenberger

STEPS, PEER_STEPS = 20_000, 2_000
REPEATS, PEER_REPEATS = 9, 3
TOLERANCE = 1e-9
"""Relative tolerance of the comparison."""


def run() -> list[dict]:
    """Rows of the benchmark table: name, value, unit, peer, its value, ratio (peer over ours)."""
    p, _ = parameters()
    seen = to_and_fro(0, STEPS * SAMPLE_TIME)
    whole = extended_kalman(p, SAMPLE_TIME, load=False)
    inner: Any = whole.inner
    core, linear = inner.filter, luenberger(p, SAMPLE_TIME)
    turned = _turned(seen.samples, p.motor_pole_pairs * seen.angle)
    return [
        _row("motor-kalman-3-states", core, turned, _kalman(core), ("mean.current_d", "mean.current_q", "mean.speed")),
        _row("motor-kalman-angle", whole, seen.samples, _angle(whole, _FilterPart), ("motor_angle", "motor_speed")),
        _row(
            "motor-luenberger-angle", linear, seen.samples, _angle(linear, _LinearPart), ("motor_angle", "motor_speed")
        ),
    ]


def _turned(samples: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Voltages, zero load and currents in the true rotor frame: the input of the filter alone."""
    current, voltage = (samples[:, k] + 1j * samples[:, k + 1] for k in (0, 2))
    own = np.exp(-1j * angle)
    i, u = current * own, voltage * own
    return np.column_stack([u.real, u.imag, np.zeros(len(angle)), i.real, i.imag])


class _FilterPart:
    """The filter with three states written with NumPy: (34) to (45)."""

    def __init__(self, block: KalmanFilter):
        p, self.T = block.parameters.continuous, block.parameters.sample_time
        self.R, self.L, self.psi, self.zp = p.motor_resistance, p.motor_inductance, p.motor_flux, p.motor_pole_pairs
        self.J, self.b = p.motor_inertia, p.motor_damping
        self.Q, self.noise = np.diag(block.process_noise), np.diag(block.measurement_noise)
        self.C, self.one = np.eye(2, 3), np.eye(3)
        self.x, self.P = np.array(block.initial_mean), np.diag(block.initial_variance)

    def step(self, u: np.ndarray, y: np.ndarray) -> np.ndarray:
        d, q, w = self.x
        T, R, L, psi, zp = self.T, self.R, self.L, self.psi, self.zp
        F = np.array(
            [
                [1.0 - T * R / L, T * zp * w, T * zp * q],
                [-T * zp * w, 1.0 - T * R / L, -T * zp * (psi + L * d) / L],
                [0.0, T * 1.5 * zp * psi / self.J, 1.0 - T * self.b / self.J],
            ]
        )
        rate = np.array(
            [
                (u[0] - R * d + zp * w * L * q) / L,
                (u[1] - R * q - zp * w * (L * d + psi)) / L,
                (1.5 * zp * psi * q - self.b * w) / self.J,
            ]
        )
        x, P = self.x + T * rate, F @ self.P @ F.T + self.Q
        K = P @ self.C.T @ np.linalg.inv(self.C @ P @ self.C.T + self.noise)
        self.x, self.P = x + K @ (y - self.C @ x), (self.one - K @ self.C) @ P
        return self.x

    def speed(self, u: np.ndarray, y: np.ndarray) -> float:
        return self.step(u, y)[2]


class _LinearPart:
    """A sampled linear observer."""

    def __init__(self, block: Any):
        self.A, self.B, self.C, self.D = (
            np.array([[0.0 if value is None else value for value in row] for row in rows], float)
            for rows in (
                block.parameters.transition,
                block.parameters.input,
                block.parameters.output,
                block.parameters.feedthrough,
            )
        )
        self.x, self.before = np.zeros(len(self.A)), 0.0

    def speed(self, u: np.ndarray, y: np.ndarray) -> float:
        self.x = self.A @ self.x + self.B @ np.array([u[1], 0.5 * (self.before + y[1])])
        self.before = y[1]
        return (self.C @ self.x + self.D @ np.array([u[1], y[1]]))[0]


Peer = Callable[[np.ndarray], tuple[np.ndarray, float]]


def _kalman(block: KalmanFilter) -> Peer:
    def peer(samples: np.ndarray) -> tuple[np.ndarray, float]:
        part, found = _FilterPart(block), np.empty((len(samples), 3))
        start = time.perf_counter()
        for k, row in enumerate(samples):
            found[k] = part.step(row[:2], row[3:])
        return found, time.perf_counter() - start

    return peer


def _angle(block: RotorFrameObserver, kind: type) -> Peer:
    """Peer with Park's transforms, speed estimation and angle integration."""
    inner: Any = block.inner
    estimator = inner.filter if kind is _FilterPart else inner

    def peer(samples: np.ndarray) -> tuple[np.ndarray, float]:
        part, found = kind(estimator), np.empty((len(samples), 2))
        angle, speed, zp, T = samples[0, 4], 0.0, block.pole_pairs, block.sample_time
        start = time.perf_counter()
        for k, row in enumerate(samples):
            travel = T * speed if k else 0.0
            u, y = _park(row[2:4], zp * (angle + 0.5 * travel)), _park(row[:2], zp * (angle + travel))
            speed = part.speed(u, y)
            angle = angle + 0.5 * (travel + T * speed) if k else angle
            found[k] = angle, speed
        return found, time.perf_counter() - start

    return peer


def _park(vector: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([vector[0] * c + vector[1] * s, vector[1] * c - vector[0] * s])


def _row(name: str, block: Block, samples: np.ndarray, peer: Peer, states: tuple[str, ...]) -> dict:
    samples = np.ascontiguousarray(samples)
    runner = kernel(block)
    outputs = np.empty((len(samples), len(runner.graph.output)))
    ours = np.inf
    for _ in range(REPEATS):
        memory = initial_memory(block)
        start = time.perf_counter()
        runner.scan(memory, samples, outputs, 0)
        ours = min(ours, (time.perf_counter() - start) / len(samples) * 1e9)
    theirs, seconds = peer(samples[:PEER_STEPS])
    mine = outputs[:PEER_STEPS, [runner.graph.output.index(state) for state in states]]
    difference = float((np.abs(mine - theirs) / np.abs(theirs).max(axis=0)).max())
    if not difference < TOLERANCE:
        raise AssertionError(f"{name} and its peer differ by {difference:.2g}; expected {TOLERANCE:g} at most")
    again = [peer(samples[:PEER_STEPS])[1] for _ in range(PEER_REPEATS)]
    peer_value = min(seconds, *again) / PEER_STEPS * 1e9
    return {
        "name": name,
        "value": ours,
        "unit": "ns/step",
        "peer": "numpy",
        "peer_value": peer_value,
        "ratio": peer_value / ours,
        "difference": difference,
    }
