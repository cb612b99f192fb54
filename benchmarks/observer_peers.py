"""Estimators of the monitors, as a user of filterpy writes them."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tierod.core.block import rebuild, skeleton
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.observers import FixedLag
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.linear import LinearSystem, linearise
from tierod.physics.friction import dahl_update


def full(packed: tuple[float, ...]) -> np.ndarray:
    """Symmetric matrix from its packed upper triangle."""
    n = round(((8 * len(packed) + 1) ** 0.5 - 1) / 2)
    matrix = np.zeros((n, n))
    matrix[np.triu_indices(n)] = packed
    return matrix + np.triu(matrix, 1).T


def system_of(block: Any) -> LinearSystem:
    """Matrices of a linear discrete-time model."""
    model = block.model
    state, inputs = model.State(*(0.0 for _ in model.State._fields)), model.Input(*(0.0 for _ in model.Input._fields))
    return linearise(model, block.parameters, state, inputs)


def filled(kind: type, system: LinearSystem, process: Any, noise: Any, covariance: np.ndarray) -> Any:
    """A filterpy filter with these matrices."""
    peer = kind(dim_x=len(system.A), dim_z=len(system.C), dim_u=system.B.shape[1])
    peer.F, peer.B, peer.H = system.A.copy(), system.B.copy(), system.C.copy()
    peer.Q, peer.R, peer.P = _diagonal(process), _diagonal(noise), covariance.copy()
    return peer


def _diagonal(values: Any) -> np.ndarray:
    return np.diag([0.0 if value is None else float(value) for value in values])


def _run(peer: Any, samples: np.ndarray, *functions: Any) -> tuple[np.ndarray, float]:
    """Means of a filter over samples, whose first column is its input, and the duration [s]."""
    found = np.empty((len(samples), len(peer.x)))
    inputs, measured = samples[:, :1, None], samples[:, 1:, None]
    start = time.perf_counter()
    for k in range(len(samples)):
        peer.predict(inputs[k])
        peer.update(measured[k], *functions)
        found[k] = peer.x[:, 0]
    return found, time.perf_counter() - start


SETTLE = 20_000  # Steps until the gain of the augmented filter has converged to seven digits


class BankOfConstantGains:
    """filterpy's `IMMEstimator` over filters with constant gain, by filterpy's steady-state functions."""

    def __init__(self, block: StationaryBank, system: LinearSystem):
        from filterpy.kalman import IMMEstimator
        from filterpy.kalman import KalmanFilter as Peer

        class Steady(Peer):
            """Predicts and updates the mean only."""

            def predict(self, u: Any = None, *_: Any) -> None:
                self.predict_steadystate(u)

            def update(self, z: Any, *_: Any) -> None:
                self.update_steadystate(z)

        filters = []
        for noise in block.noises:
            peer = filled(Steady, system, np.zeros(len(system.A)), np.zeros(len(system.C)), full(noise.covariance))
            peer.K, peer.S = np.array(noise.gain), full(noise.innovation_covariance)
            filters.append(peer)
        count = len(filters)
        self.peer = IMMEstimator(filters, np.full(count, 1.0 / count), np.array(block.switching))

    def __call__(self, samples: np.ndarray) -> tuple[np.ndarray, float]:
        """Estimates, and duration [s]."""
        return _run(self.peer, samples)


class AugmentedLag:
    """Kalman filter with the smoothed state at every lag as further states; filterpy's own smoother is approximate."""

    def __init__(self, block: FixedLag, process: np.ndarray, noise: tuple[float, ...]):
        from filterpy.kalman import KalmanFilter as Peer

        small = system_of(block)
        n, lag, at = len(small.A), block.lag, small.states.index(block.states[0])
        A = np.zeros((n + lag, n + lag))
        A[:n, :n], A[n, at] = small.A, 1.0
        A[n + 1 :, n:-1] = np.eye(lag - 1)
        B, C = np.vstack([small.B, np.zeros((lag, 1))]), np.hstack([small.C, np.zeros((len(small.C), lag))])
        large = LinearSystem.of(A, C, B)
        self.peer = filled(Peer, large, [*process, *np.zeros(lag)], noise, np.eye(n + lag))
        for _ in range(SETTLE):
            self.peer.predict(np.zeros((1, 1)))
            self.peer.update(np.zeros((len(C), 1)))

    def __call__(self, samples: np.ndarray) -> tuple[np.ndarray, float]:
        """Estimates, and duration [s]."""
        found, seconds = _run(self.peer, samples)
        return found[:, -1:], seconds


class ExtendedFilter:
    """filterpy's `ExtendedKalmanFilter` of the column with Dahl friction and analytical Jacobian."""

    def __init__(self, block: KalmanFilter):
        n, linear = len(block.model.State._fields), block.parameters.linear
        A, B, self.C = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((3, n))
        for matrix, rows in ((A, linear.transition), (B, linear.input), (self.C, linear.output)):
            part = np.array([[0.0 if value is None else value for value in row] for row in rows])
            matrix[: part.shape[0], : part.shape[1]] = part
        self.peer = _friction_peer(block, A, B)(dim_x=n, dim_z=3, dim_u=1)
        self.peer.P, self.peer.x = np.diag(block.initial_variance), np.array(block.initial_mean)[:, None]
        self.peer.Q, self.peer.R = _diagonal(block.process_noise), _diagonal(block.measurement_noise)

    def __call__(self, samples: np.ndarray) -> tuple[np.ndarray, float]:
        """Estimates, and duration [s]."""
        peer, C = self.peer, self.C

        def jacobian(_: np.ndarray) -> np.ndarray:
            return C

        def output(x: np.ndarray) -> np.ndarray:
            return C @ x

        return _run(peer, samples, jacobian, output)


def _friction_peer(block: KalmanFilter, A: np.ndarray, B: np.ndarray) -> Any:
    """Filter class that propagates mean and Jacobian by the column's equations."""
    from filterpy.kalman import ExtendedKalmanFilter

    states, n = block.model.State._fields, len(A)
    force, motor, speed = (states.index(name) for name in ("disturbance_torque", "motor_angle", "motor_speed"))
    driven = A[:, force].copy()
    driven[force] = 0.0
    angle, half = block.parameters.dahl_angle, 0.5 * block.parameters.sample_time

    class Peer(ExtendedKalmanFilter):
        def predict_x(self, u: Any = 0) -> None:
            x = self.x
            rate, normalised, level = x[speed, 0], x[n - 2, 0], x[n - 1, 0]
            halfway = dahl_update(normalised, half * rate, angle)
            fade = np.exp(-abs(half * rate) / angle)
            F = A.copy()
            F[:, n - 2] += driven * level * fade
            F[:, n - 1] += driven * halfway
            F[:, speed] += driven * level * half * np.sign(rate) * (np.sign(rate) - normalised) * fade / angle
            moved = A @ x + B @ u
            moved[:, 0] += driven * (level * halfway)
            travel = moved[motor, 0] - x[motor, 0]
            row = F[motor].copy()
            row[motor] -= 1.0
            after = np.exp(-abs(travel) / angle)
            F[n - 2] = row * np.sign(travel) * (np.sign(travel) - normalised) * after / angle
            F[n - 2, n - 2] += after
            F[n - 1, n - 1] = 1.0
            moved[n - 2 :, 0] = dahl_update(normalised, travel, angle), level
            self.x, self.F = moved, F

    return Peer


STEP = 1e-5  # Step of the numerical differences, in states with a magnitude of one


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
