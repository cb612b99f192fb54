"""Five-state enabled filter of the friction paper: one recording, many vehicles, live, and without a compiler."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.timing import fastest, in_lanes, row, single
from tierod.core.block import Block, Tree
from tierod.core.graph import Stream
from tierod.core.graph.maths import sign
from tierod.core.graph.trace import LANES
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.friction.signals import FrictionGate
from tierod.vehicles import load
from tierod_lab.papers.friction.joint_model import FrictionEstimation
from tierod_lab.papers.friction.presets import printed
from tierod_lab.papers.friction.refined import FrictionSample

STEPS = 500_000  # Samples of one recording: 83 minutes at 100 Hz

LANE_STEPS = 1_000  # Samples per tile: ten seconds at 100 Hz

REPEATS = 9

ALLOCATIONS = 4  # Number of memory allocations of the tiles, whose location changes the time of a lane by a tenth


@dataclass(frozen=True)
class EnabledFilter:
    """Filter of the peer with an enabling condition added: friction is corrected only while it is excited."""

    filter: KalmanFilter
    gate: FrictionGate

    Sample = FrictionSample

    def init(self) -> Tree:
        return self.filter.init()

    def step(self, state: Tree, sample: FrictionSample) -> tuple[Tree, Tree]:
        enabled = self.gate.opened(sample.driver_torque, sample.motor_torque, sample.steering_wheel_rate, None)
        inputs = FrictionEstimation.Input(
            sample.driver_torque, sample.motor_torque, sample.lateral_acceleration, sign(sample.steering_wheel_rate)
        )
        measured = FrictionEstimation.Output(sample.steering_wheel_angle, sample.steering_wheel_rate, sample.yaw_rate)
        state, estimate = self.filter.step(state, self.filter.Sample(inputs, measured, (enabled,)))
        return state, estimate.mean


def run() -> list[dict]:
    """Rows of the benchmark table: name, value, unit, peer, its value, ratio (peer over ours)."""
    monitor = printed(load("midsize-eps").parameters_for(FrictionParameters))
    block = EnabledFilter(monitor.filter, monitor.gate)
    peer = nanoseconds_per_step(_samples(20_000), matrices(block), REPEATS)
    samples, stretches = _samples(STEPS), _samples(LANE_STEPS, LANES)
    values = {
        "filter-single": single(block, samples, REPEATS)[0],
        "filter-lanes": min(in_lanes(block, stretches, 10 * REPEATS) for _ in range(ALLOCATIONS)),
        "filter-vm": single(block, samples[: STEPS // 10], REPEATS, "virtual machine")[0],
        "push-named": _push(block),
        "push-bound": _push_bound(block),
    }
    return [row(name, value, "ns/step", "filterpy", peer) for name, value in values.items()]


def matrices(block: EnabledFilter) -> dict[str, np.ndarray]:
    """Matrices of the filter in textbook form, derived from the same affine model by finite steps."""
    filter_ = block.filter
    zero_state, zero_input = np.zeros(5), np.zeros(4)

    def step(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        model = FrictionEstimation
        return np.array(model.transition(model.State(*x), model.Input(*u), filter_.parameters))

    origin = step(zero_state, zero_input)
    transition = np.column_stack([step(unit, zero_input) - origin for unit in np.eye(5)])
    inputs = np.column_stack([step(zero_state, unit) - origin for unit in np.eye(4)[:3]])
    friction = step(np.eye(5)[4], np.array([0.0, 0.0, 0.0, 1.0]))[1]
    noise = np.diag([0.0 if value is None else value for value in filter_.process_noise])
    shaken = np.diag([0.0 if value is None else value for value in filter_.input_noise][:3])
    return {
        "A": transition,
        "friction": friction,
        "B": inputs,
        "C": np.eye(3, 5),
        "GQG": noise + inputs @ shaken @ inputs.T,
        "R": np.diag(filter_.measurement_noise),
        "P": np.diag(filter_.initial_variance),
        "x": np.array(filter_.initial_mean, dtype=float)[:, None],
    }


def _samples(count: int, *more: int) -> np.ndarray:
    return np.random.default_rng(0).normal(size=(count, 6, *more)) * 0.3


def nanoseconds_per_step(samples: np.ndarray, matrices: dict[str, np.ndarray], repeats: int = 3) -> float:
    """The same filter, as a user of filterpy writes it: fastest predict and update [ns].

    Args:
        samples: driver torque, motor torque, lateral acceleration, angle, rate, yaw rate, shape (n, 6)
        matrices: A at standstill, friction (entry of A per direction of motion), B, GQG, C, R, P, x
    """
    from filterpy.kalman import KalmanFilter as Peer

    filter_ = Peer(dim_x=5, dim_z=3, dim_u=3)
    inputs, measured = samples[:, :3, None], samples[:, 3:, None]
    friction = matrices["friction"]

    def work() -> None:
        filter_.F, filter_.B, filter_.H = matrices["A"].copy(), matrices["B"], matrices["C"]
        filter_.Q, filter_.R = matrices["GQG"], matrices["R"]
        filter_.x, filter_.P = matrices["x"].copy(), matrices["P"].copy()
        for u, y in zip(inputs, measured, strict=True):
            filter_.F[1, 4] = friction * np.sign(y[1, 0])
            filter_.predict(u)
            filter_.update(y)

    return 1e9 * fastest(work, repeats) / len(samples)


def _push(block: Block, pushes: int = 50_000) -> float:
    stream = Stream(block)
    sample = dict(zip(stream.names, _samples(1)[0].tolist(), strict=True))

    def work() -> None:
        push = stream.push
        for _ in range(pushes):
            push(sample)

    return 1e9 * fastest(work, REPEATS) / pushes


def _push_bound(block: Block, pushes: int = 50_000) -> float:
    stream = Stream(block)
    stream.inputs[:] = _samples(1)[0]

    def work() -> None:
        advance = stream.advance
        for _ in range(pushes):
            advance()

    return 1e9 * fastest(work, REPEATS) / pushes
