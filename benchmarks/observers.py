"""Observers of column and sideslip compared with filterpy: the same filters and results, measured in one run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks import combined_sideslip, sideslip
from benchmarks.observer_peers import (
    AugmentedLag,
    BankOfConstantGains,
    ExtendedFilter,
    PlainFilter,
)
from tierod.core.block import Block
from tierod.core.graph.kernel import kernel
from tierod.core.graph.trace import initial_memory
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.design import ColumnTuning, design, process_noises
from tierod.monitors.driver_torque.observer import DelayedHandTorque, smoothing
from tierod.vehicles import load
from tierod_lab.papers.column.column_friction import ColumnFrictionObserver
from tierod_lab.papers.column.printed import PrintedObserver
from tierod_lab.papers.column.swept_bench import swept

STEPS = 40_000
"""Samples of one run: 40 s at 1 kHz."""

PEER_STEPS = 1_500
"""Samples of the peer's run, all of which are compared unless `compared` is smaller."""

PEER_REPEATS = 2
"""Further runs of the peer, the fastest of which counts."""

REPEATS = 7


@dataclass(frozen=True)
class Comparison:
    """One estimator and the equivalent peer.

    Args:
        name: of the table row
        block: our estimator
        samples: input of our estimator, (n, inputs)
        peer: returns estimates (m, states) for given samples, and the duration without its construction [s]
        states: our outputs that correspond to the peer's estimates
        tolerance: relative tolerance of the comparison
        compared: number of compared samples; with stick-slip friction, the two kinds of Jacobians diverge in time
    """

    name: str
    block: Block
    samples: np.ndarray
    peer: Callable[[np.ndarray], tuple[np.ndarray, float]]
    states: tuple[str, ...]
    tolerance: float = 1e-6
    compared: int = PEER_STEPS


def column_comparisons() -> list[Comparison]:
    """Comparisons of the steering column observers."""
    vehicle = load("column-bench")
    parameters, tuning = vehicle.parameters_for(ColumnParameters), ColumnTuning()
    samples = _samples()
    made = design(parameters, 1e-3, tuning)
    system, bank = made.observation.discrete, made.bank
    mean = tuple(f"mean.{name}" for name in system.states)
    printed = PrintedObserver.of_column(parameters, "full").filter
    lagged = DelayedHandTorque.of_parameters(parameters).smoother
    (slow,) = process_noises(system.states, parameters, 1e-3, smoothing(tuning))
    delayed = AugmentedLag(lagged, slow, tuning.variances())
    friction = ColumnFrictionObserver.of_vehicle(vehicle).filter
    return [
        Comparison("observer-printed", printed, samples, PlainFilter.stationary(printed), ("mean.hand_torque",)),
        Comparison("observer-bank", bank, samples, BankOfConstantGains(bank, system), mean),
        Comparison("observer-20-ms-later", lagged, samples, delayed, ("smoothed.hand_torque",)),
        Comparison("observer-friction", friction, samples, ExtendedFilter(friction), _means(friction)),
    ]


def _samples() -> np.ndarray:
    """Samples from a run of the bench, with the motor torque of the preceding sample as the filters require."""
    run = swept("steps", STEPS * 1e-3, 1)
    before = np.r_[0.0, run["motor_torque"][:-1]]
    return np.column_stack([before, run["steering_wheel_angle"], run["motor_angle_mechanical"], run["driver_torque"]])


def sideslip_comparisons() -> list[Comparison]:
    """Comparisons of the sideslip observers."""
    placed = [Comparison(*each) for each in sideslip.observers()]
    return [*placed, *(Comparison(*each, tolerance=1e-5, compared=100) for each in combined_sideslip.observers())]


COMPARISONS: list[Callable[[], Sequence[Comparison]]] = [column_comparisons, sideslip_comparisons]
"""Sources of the comparisons, to which other estimators can be added."""


def run() -> list[dict]:
    """Rows of the benchmark table: name, value, unit, peer, its value, ratio (peer over ours)."""
    return [_row(each) for source in COMPARISONS for each in source()]


def _row(each: Comparison) -> dict:
    runner = kernel(each.block)
    outputs = np.empty((len(each.samples), len(runner.graph.output)))
    columns = [runner.graph.output.index(name) for name in each.states]
    ours = np.inf
    for _ in range(REPEATS):
        memory = initial_memory(each.block)
        start = time.perf_counter()
        runner.scan(memory, each.samples, outputs, 0)
        ours = min(ours, (time.perf_counter() - start) / len(each.samples) * 1e9)
    theirs, seconds = each.peer(each.samples[:PEER_STEPS])
    mine, theirs = outputs[: each.compared, columns], theirs[: each.compared]
    scale = np.abs(theirs).max(axis=0)
    difference = float((np.abs(mine - theirs) / np.where(scale > 0.0, scale, 1.0)).max())
    if not difference < each.tolerance:
        raise AssertionError(
            f"{each.name} and its peer differ by {difference:.2g}; expected {each.tolerance:g} at most"
        )
    again = [each.peer(each.samples[:PEER_STEPS])[1] for _ in range(PEER_REPEATS)]
    peer = min(seconds, *again) / PEER_STEPS * 1e9
    return {
        "name": each.name,
        "value": ours,
        "unit": "ns/step",
        "peer": "filterpy",
        "peer_value": peer,
        "ratio": peer / ours,
        "difference": difference,
    }


def _means(block: KalmanFilter) -> tuple[str, ...]:
    return tuple(f"mean.{name}" for name in block.model.State._fields)
