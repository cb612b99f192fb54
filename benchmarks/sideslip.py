"""The sideslip observers against filterpy: the same filters at one speed, the same numbers, measured in one run.

Ours follow the speed at every sample, hold where nothing can be estimated and give standard deviations; the peer does
none of that. Friction of the steering is left out, since filterpy's linear filter has no place for it.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.observer_peers import filled
from tierod.block import Block
from tierod.estimators.kalman import KalmanFilter
from tierod.models.linear import LinearSystem, linearise
from tierod.models.steered_vehicle import SteeredVehicle
from tierod.monitors.sideslip.conventional import conventional_kalman, conventional_poles
from tierod.monitors.sideslip.two_stage import two_stage_kalman, two_stage_poles
from tierod.vehicles import load

SPEED = 20.0
"""[m/s]."""

STEPS = 40_000
"""Samples of one run: 40 s at 1 kHz."""

RATE = 1e-3
ANGLE = 2
"""Column of the road wheels' angle in the samples."""


def observers() -> list[tuple[str, Block, np.ndarray, Any, tuple[str, ...]]]:
    """Name, our block, samples, the peer, and what is compared, for each of the four observers."""
    p = load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)
    free = dataclasses.replace(p, road_wheel_friction=0.0)
    one, fixed = conventional_kalman(free, RATE), conventional_poles(free, RATE)
    two, placed = two_stage_kalman(free, RATE), two_stage_poles(free, RATE)
    gains = (_gain(fixed.observer), np.array(placed.steering.gain), _gain(placed.vehicle))
    peers = {
        "sideslip-conventional-kalman": (one, [_learning(one.filter, (0.0, SPEED))]),
        "sideslip-conventional-poles": (fixed, [_constant(fixed.observer, (0.0, SPEED), gains[0])]),
        "sideslip-two-stage-kalman": (two, [_learning(two.steering, (0.0,)), _learning(two.vehicle, (0.0, SPEED))]),
        "sideslip-two-stage-poles": (
            placed,
            [_constant(placed.steering, (0.0,), gains[1]), _constant(placed.vehicle, (0.0, SPEED), gains[2])],
        ),
    }
    samples = _samples()
    return [(name, block, samples, Stages(stages), ("sideslip_angle",)) for name, (block, stages) in peers.items()]


class Stages:
    """One filter of filterpy, or two: the second one takes the aligning torque of the first as measured."""

    def __init__(self, stages: Sequence[Any]):
        self.stages = stages

    def __call__(self, samples: np.ndarray) -> tuple[np.ndarray, float]:
        """Sideslip angles and seconds."""
        for each in self.stages:
            each.start()
        found = np.empty((len(samples), 1))
        torque, measured, steer = samples[:, 3:4, None], samples[:, 1:3, None], samples[:, ANGLE : ANGLE + 1, None]
        start = time.perf_counter()
        if len(self.stages) == 1:
            (whole,) = self.stages
            for k in range(len(samples)):
                found[k] = whole.step(torque[k], measured[k])[0]
        else:
            steering, vehicle = self.stages
            for k in range(len(samples)):
                aligning = steering.step(torque[k], steer[k])[2:3]
                found[k] = vehicle.step(steer[k], np.vstack([measured[k][:1], aligning]))[0]
        return found, time.perf_counter() - start


class _Learning:
    """Predict, update."""

    def __init__(self, peer: Any, covariance: np.ndarray, feedthrough: np.ndarray):
        self.peer, self.covariance, self.feedthrough = peer, covariance, feedthrough

    def start(self) -> None:
        """From the beginning."""
        self.peer.x = np.zeros_like(self.peer.x)
        self.peer.P = self.covariance.copy()

    def step(self, inputs: np.ndarray, measured: np.ndarray) -> np.ndarray:
        """One sample on."""
        self.peer.predict(inputs)
        self.peer.update(measured - self.feedthrough @ inputs)
        return self.peer.x


class _Constant(_Learning):
    """Predict, correct by a gain that stays."""

    def step(self, inputs: np.ndarray, measured: np.ndarray) -> np.ndarray:
        """One sample on."""
        self.peer.predict_steadystate(inputs)
        self.peer.update_steadystate(measured - self.feedthrough @ inputs)
        return self.peer.x


def _learning(block: KalmanFilter, at: tuple[float, ...]) -> _Learning:
    from filterpy.kalman import KalmanFilter as Peer

    start = np.diag(block.initial_variance)
    system = _system(block, at)
    return _Learning(filled(Peer, system, block.process_noise, block.measurement_noise, start), start, system.D)


def _constant(block: Any, at: tuple[float, ...], gain: np.ndarray) -> _Constant:
    from filterpy.kalman import KalmanFilter as Peer

    system = _system(block, at)
    n, m = system.B.shape[0], len(system.C)
    peer = filled(Peer, system, [0.0] * n, [1.0] * m, np.eye(n))
    peer.K_steady_state = peer.K = gain
    return _Constant(peer, np.eye(n), system.D)


def _system(block: Any, at: tuple[float, ...]) -> LinearSystem:
    """Matrices of the sampled model with its first input alone; the measurement of the torque has a feed-through."""
    model = block.model
    found = linearise(model, block.parameters, (0.0,) * len(model.State._fields), at)
    return dataclasses.replace(found, B=found.B[:, :1], D=found.D[:, :1], inputs=found.inputs[:1])


def _gain(observer: Any) -> np.ndarray:
    values = observer.schedule.at(SPEED)
    n, m = len(observer.model.State._fields), len(observer.model.Output._fields)
    return np.array(values[: n * m], float).reshape(n, m)


def _samples() -> np.ndarray:
    """Speed, yaw rate, angle and torque: a sine of the steering with noise, (n, 4)."""
    chance, time_ = np.random.default_rng(0), np.arange(STEPS) * RATE
    sine = np.sin(2.0 * np.pi * 0.3 * time_)
    noise = chance.normal(size=(3, STEPS))
    columns = (0.12 * sine + 0.003 * noise[0], 0.02 * sine + 2e-4 * noise[1], 90.0 * sine + noise[2])
    return np.column_stack([np.full(STEPS, SPEED), *columns])
