"""Sideslip observers compared with filterpy: the same filters at varying speed, with the same results, in one run.

The peer computes its matrices at every sample from eqs (9), (13) and (18) in NumPy, and reads the placed gains from a
table over speed, as ours do. Ours additionally hold the estimate where it is not observable, and give standard
deviations. Steering friction is omitted, because filterpy's linear filter cannot represent it.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.observer_peers import filled
from tierod.core.block import Block
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.linear import LinearSystem
from tierod.vehicles import load
from tierod_lab.papers.sideslip.conventional import conventional_kalman, conventional_poles
from tierod_lab.papers.sideslip.schedule import HALF, SPEEDS
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.two_stage import two_stage_kalman, two_stage_poles

SPEED, SWING = 20.0, 5.0
"""Mean speed, and amplitude of its variation [m/s]."""

STEPS = 40_000
"""Samples of one run: 40 s at 1 kHz."""

RATE = 1e-3
ANGLE = 2
"""Column of the road wheel angle in the samples."""


def observers() -> list[tuple[str, Block, np.ndarray, Any, tuple[str, ...]]]:
    """Name, our block, samples, peer, and compared outputs, for each of the four observers."""
    p = load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)
    free = dataclasses.replace(p, road_wheel_friction=0.0)
    one, fixed = conventional_kalman(free, RATE), conventional_poles(free, RATE)
    two, placed = two_stage_kalman(free, RATE), two_stage_poles(free, RATE)
    steering, vehicle, whole = Steering(free), Vehicle(free), Whole(free)
    peers = {
        "sideslip-conventional-kalman": (one, [_Learning(whole, one.filter)]),
        "sideslip-conventional-poles": (fixed, [_Placed(whole, _table(fixed.observer))]),
        "sideslip-two-stage-kalman": (two, [_Learning(steering, two.steering), _Learning(vehicle, two.vehicle)]),
        "sideslip-two-stage-poles": (
            placed,
            [_Placed(steering, np.array(placed.steering.gain)[None]), _Placed(vehicle, _table(placed.vehicle))],
        ),
    }
    samples = _samples()
    return [(name, block, samples, Stages(stages), ("sideslip_angle",)) for name, (block, stages) in peers.items()]


class Stages:
    """One filterpy filter, or two, the second of which uses the aligning torque of the first as measurement."""

    def __init__(self, stages: Sequence[Any]):
        self.stages = stages

    def __call__(self, samples: np.ndarray) -> tuple[np.ndarray, float]:
        """Sideslip angles, and duration [s]."""
        for each in self.stages:
            each.start()
        found = np.empty((len(samples), 1))
        speed = samples[:, 0].tolist()
        torque, measured, steer = samples[:, 3:4, None], samples[:, 1:3, None], samples[:, ANGLE : ANGLE + 1, None]
        start = time.perf_counter()
        if len(self.stages) == 1:
            (whole,) = self.stages
            for k in range(len(samples)):
                found[k] = whole.step(speed[k], torque[k], measured[k])[0]
        else:
            steering, vehicle = self.stages
            for k in range(len(samples)):
                aligning = steering.step(speed[k], torque[k], steer[k])[2:3]
                found[k] = vehicle.step(speed[k], steer[k], np.vstack([measured[k][:1], aligning]))[0]
        return found, time.perf_counter() - start


class Steering:
    """Eq (18), independent of speed; discretised once."""

    def __init__(self, p: Any):
        J, b = p.road_wheel_inertia, p.road_wheel_damping
        A = np.array([[0.0, 1.0, 0.0], [0.0, -b / J, -1.0 / J], [0.0, 0.0, 0.0]])
        self.C, self.D = np.array([[1.0, 0.0, 0.0]]), np.zeros((1, 1))
        self.A, self.B = sampled(A, np.array([[0.0], [1.0 / J], [0.0]]))

    def at(self, speed: float) -> tuple[np.ndarray, ...]:
        """Matrices F, B, H and D."""
        return self.A, self.B, self.C, self.D


class Vehicle:
    """Eqs (9) and (23) at a given speed."""

    def __init__(self, p: Any):
        front, rear = p.front_cornering_stiffness, p.rear_cornering_stiffness
        a, b, m, inertia = p.front_distance, p.rear_distance, p.mass, p.yaw_inertia
        trail = p.mechanical_trail + p.pneumatic_trail
        one = rear * b - front * a
        self.constant = np.array([[0.0, -1.0], [one / inertia, 0.0]])
        self.over_speed = np.array([[-(front + rear) / m, 0.0], [0.0, -(front * a * a + rear * b * b) / inertia]])
        self.over_square = np.array([[0.0, one / m], [0.0, 0.0]])
        self.steer, self.steer_over_speed = np.array([[0.0], [front * a / inertia]]), np.array([[front / m], [0.0]])
        self.shown = np.array([[0.0, 1.0], [-trail * front, 0.0]])
        self.shown_over_speed = np.array([[0.0, 0.0], [0.0, -trail * front * a]])
        self.through = np.array([[0.0], [trail * front]])

    def at(self, speed: float) -> tuple[np.ndarray, ...]:
        """Matrices F, B, H and D."""
        A = self.constant + self.over_speed / speed + self.over_square / (speed * speed)
        F, B = sampled(A, self.steer + self.steer_over_speed / speed)
        return F, B, self.shown + self.shown_over_speed / speed, self.through


class Whole:
    """Eq (13) at a given speed."""

    def __init__(self, p: Any):
        self.vehicle, self.inertia, self.damping = Vehicle(p), p.road_wheel_inertia, p.road_wheel_damping
        self.B = np.array([[0.0], [0.0], [0.0], [1.0 / p.road_wheel_inertia]])
        self.C, self.D = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]), np.zeros((2, 1))

    def at(self, speed: float) -> tuple[np.ndarray, ...]:
        """Matrices F, B, H and D."""
        v, A = self.vehicle, np.zeros((4, 4))
        A[:2, :2] = v.constant + v.over_speed / speed + v.over_square / (speed * speed)
        A[:2, 2:3] = v.steer + v.steer_over_speed / speed
        A[2, 3] = 1.0
        shown = v.shown[1] + v.shown_over_speed[1] / speed
        A[3] = [-shown[0] / self.inertia, -shown[1] / self.inertia, -v.through[1, 0] / self.inertia, 0.0]
        A[3, 3] = -self.damping / self.inertia
        F, B = sampled(A, self.B)
        return F, B, self.C, self.D


def sampled(A: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Discrete-time matrices by the midpoint rule."""
    half = np.eye(len(A)) + 0.5 * RATE * A
    return np.eye(len(A)) + RATE * A @ half, RATE * half @ B


class _Learning:
    """Kalman filter with predict and update."""

    def __init__(self, model: Any, block: KalmanFilter):
        from filterpy.kalman import KalmanFilter as Peer

        self.model, self.covariance = model, np.diag(block.initial_variance)
        F, B, H, _ = model.at(SPEED)
        system = LinearSystem.of(F, H, B)
        self.peer = filled(Peer, system, block.process_noise, block.measurement_noise, self.covariance)

    def start(self) -> None:
        """Reset the filter."""
        self.peer.x = np.zeros_like(self.peer.x)
        self.peer.P = self.covariance.copy()

    def step(self, speed: float, inputs: np.ndarray, measured: np.ndarray) -> np.ndarray:
        """Process one sample."""
        peer = self.peer
        peer.F, peer.B, peer.H, feedthrough = self.model.at(speed)
        peer.predict(inputs)
        peer.update(measured - feedthrough @ inputs)
        return peer.x


class _Placed:
    """Observer with a gain interpolated from a table over speed."""

    def __init__(self, model: Any, table: np.ndarray):
        from filterpy.kalman import KalmanFilter as Peer

        self.model, self.table = model, table
        F, B, H, _ = model.at(SPEED)
        self.peer = filled(Peer, LinearSystem.of(F, H, B), [0.0] * len(F), [1.0] * len(H), np.eye(len(F)))

    def start(self) -> None:
        """Reset the observer."""
        self.peer.x = np.zeros_like(self.peer.x)

    def step(self, speed: float, inputs: np.ndarray, measured: np.ndarray) -> np.ndarray:
        """Process one sample."""
        peer, table = self.peer, self.table
        peer.F, peer.B, peer.H, feedthrough = self.model.at(speed)
        if len(table) == 1:
            peer.K = table[0]
        else:
            row = int(np.searchsorted(SPEEDS, speed)) - 1
            low, high = (each / (each + HALF) for each in SPEEDS[row : row + 2])
            share = (speed / (speed + HALF) - low) / (high - low)
            peer.K = table[row] + share * (table[row + 1] - table[row])
        peer.predict_steadystate(inputs)
        peer.update_steadystate(measured - feedthrough @ inputs)
        return peer.x


def _table(observer: Any) -> np.ndarray:
    """Gains at each of `SPEEDS`, (rows, n, m)."""
    n, m = len(observer.model.State._fields), len(observer.model.Output._fields)
    return np.array([observer.schedule.at(speed)[: n * m] for speed in SPEEDS], float).reshape(-1, n, m)


def _samples() -> np.ndarray:
    """Speed, yaw rate, angle and torque, (n, 4): sinusoidal steering with noise at a varying speed."""
    chance, time_ = np.random.default_rng(0), np.arange(STEPS) * RATE
    sine = np.sin(2.0 * np.pi * 0.3 * time_)
    noise = chance.normal(size=(3, STEPS))
    columns = (0.12 * sine + 0.003 * noise[0], 0.02 * sine + 2e-4 * noise[1], 90.0 * sine + noise[2])
    return np.column_stack([SPEED + SWING * np.sin(2.0 * np.pi * 0.05 * time_), *columns])
