"""Five-state enabled filter of the friction paper: one recording, many vehicles, live, and without a compiler."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.dependency_floor import floor
from benchmarks.filterpy_peer import nanoseconds_per_step
from tierod.core.block import Block, Tree
from tierod.core.graph import Stream, trace
from tierod.core.graph.kernel import LaneKernel, kernel, lane_array
from tierod.core.graph.maths import sign
from tierod.core.graph.printer import LANES
from tierod.core.graph.trace import initial_memory
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.friction_estimation import FrictionEstimation, FrictionParameters
from tierod.monitors.friction.signals import FrictionGate
from tierod.vehicles import load
from tierod_lab.papers.friction.presets import printed
from tierod_lab.papers.friction.refined import FrictionSample

STEPS = 500_000
"""Samples of one recording: 83 minutes at 100 Hz."""

LANE_STEPS = 1_000
"""Samples per tile: ten seconds at 100 Hz."""

REPEATS = 9

ALLOCATIONS = 4
"""Number of memory allocations of the tiles, whose location changes the time of a lane by a tenth."""


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
    lower = floor(trace(block))
    values = {
        "filter-single": _single(block),
        "filter-lanes": min(_lanes(block) for _ in range(ALLOCATIONS)),
        "filter-vm": _single(block, "virtual machine", STEPS // 10),
        "push-named": _push(block),
        "push-bound": _push_bound(block),
    }
    rows = [
        {"name": name, "value": value, "unit": "ns/step", "peer": "filterpy", "peer_value": peer, "ratio": peer / value}
        for name, value in values.items()
    ]
    rows[0] |= {"dependency_floor_ns": lower, "times_floor": values["filter-single"] / lower}
    return rows


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


def _fastest(work: Callable[[], None], repeats: int = REPEATS) -> float:
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best * 1e9


def _single(block: Block, engine: str = "auto", steps: int = STEPS) -> float:
    runner = kernel(block, engine)  # type: ignore[arg-type]
    samples, outputs = _samples(steps), np.empty((steps, len(runner.graph.output)))
    return _fastest(lambda: runner.scan(initial_memory(block), samples, outputs, 0)) / steps


def _lanes(block: Block) -> float:
    runner = LaneKernel([block] * LANES)
    samples, outputs = lane_array(LANE_STEPS, 6), lane_array(LANE_STEPS, len(runner.graph.output))
    start = initial_memory(block)[:, None]
    states = lane_array(len(start))
    samples[:] = _samples(LANE_STEPS, LANES)

    def work() -> None:
        states[:] = start
        runner.scan(states, samples, outputs, 0)

    return _fastest(work, 10 * REPEATS) / (LANE_STEPS * LANES)


def _push(block: Block, pushes: int = 50_000) -> float:
    stream = Stream(block)
    sample = dict(zip(stream.names, _samples(1)[0].tolist(), strict=True))

    def work() -> None:
        push = stream.push
        for _ in range(pushes):
            push(sample)

    return _fastest(work) / pushes


def _push_bound(block: Block, pushes: int = 50_000) -> float:
    stream = Stream(block)
    stream.inputs[:] = _samples(1)[0]

    def work() -> None:
        advance = stream.advance
        for _ in range(pushes):
            advance()

    return _fastest(work) / pushes
