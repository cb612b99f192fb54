"""Estimators of the monitors compared with filterpy: the same filters and results, measured in one run."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from benchmarks.observer_peers import AugmentedLag, BankOfConstantGains, ByDifferences
from benchmarks.timing import row, single
from tierod.core.block import Block
from tierod.core.graph.trace import trace
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.design import ColumnTuning, design, process_noises
from tierod.monitors.driver_torque.observer import DelayedHandTorque, smoothing
from tierod.monitors.sideslip.estimator import CombinedSideslip
from tierod.vehicles import load
from tierod_lab.papers.column.swept_bench import swept

STEPS = 40_000  # Samples of one run

PEER_STEPS = 1_500  # Samples of the peer's run, all of which are compared unless `compared` is smaller

PEER_REPEATS, REPEATS = 3, 7


@dataclasses.dataclass(frozen=True)
class Comparison:
    """One estimator and the equivalent peer."""

    name: str  # of the table row
    block: Block
    samples: np.ndarray  # input of our estimator, (n, inputs)
    # returns estimates (m, states) for given samples, and the duration without its construction [s]
    peer: Callable[[np.ndarray], tuple[np.ndarray, float]]
    states: tuple[str, ...]  # our outputs that correspond to the peer's estimates
    tolerance: float = 1e-6  # relative tolerance of the comparison
    # number of compared samples; with stick-slip friction, the two kinds of Jacobians diverge in time
    compared: int = PEER_STEPS


def run() -> list[dict]:
    """Rows of the benchmark table: name, value, unit, peer, its value, ratio (peer over ours)."""
    return [_row(each) for each in (*column_comparisons(), *sideslip_comparisons())]


def _row(each: Comparison) -> dict:
    ours, outputs = single(each.block, each.samples, REPEATS)
    runs = [each.peer(each.samples[:PEER_STEPS]) for _ in range(PEER_REPEATS)]
    columns = [trace(each.block).output.index(name) for name in each.states]
    mine, theirs = outputs[: each.compared, columns], runs[0][0][: each.compared]
    scale = np.abs(theirs).max(axis=0)
    difference = float((np.abs(mine - theirs) / np.where(scale > 0.0, scale, 1.0)).max())
    if not difference < each.tolerance:
        raise AssertionError(
            f"{each.name} and its peer differ by {difference:.2g}; expected {each.tolerance:g} at most"
        )
    peer = 1e9 * min(seconds for _, seconds in runs) / PEER_STEPS
    return row(each.name, ours, "ns/step", "filterpy", peer, difference=difference)


def column_comparisons() -> list[Comparison]:
    """Observers of the steering column at 1 kHz, on the bench."""
    vehicle = load("column-bench")
    parameters, tuning = vehicle.parameters_for(ColumnParameters), ColumnTuning()
    run = swept("steps", STEPS * 1e-3, 1)
    # The filters require the motor torque of the preceding sample.
    before = np.r_[0.0, run["motor_torque"][:-1]]
    samples = np.column_stack(
        [before, run["steering_wheel_angle"], run["motor_angle_mechanical"], run["driver_torque"]]
    )
    made = design(parameters, 1e-3, tuning)
    system, bank = made.observation.discrete, made.bank
    lagged = DelayedHandTorque.of_parameters(parameters).smoother
    (slow,) = process_noises(system.states, parameters, 1e-3, smoothing(tuning))
    delayed = AugmentedLag(lagged, slow, tuning.variances())
    return [
        Comparison("observer-bank", bank, samples, BankOfConstantGains(bank, system), _means(system.states)),
        Comparison("observer-20-ms-later", lagged, samples, delayed, ("smoothed.hand_torque",)),
    ]


def _means(states: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"mean.{name}" for name in states)


RATE = 0.01  # Sample time of the sideslip estimator [s]


def sideslip_comparisons() -> list[Comparison]:
    """Filter of the combined sideslip estimator, with and without the steering torque.

    The functions around the filter (holding, gates, limits and their reports) are excluded on both sides.
    """
    found = []
    for name, steering in (("sideslip-combined-torque", True), ("sideslip-combined", False)):
        whole = CombinedSideslip.of_vehicle(load("steer-by-wire"), RATE, steering=steering)
        block = dataclasses.replace(whole.filter, gate=None)
        states = ("mean.lateral_speed", "mean.yaw_rate")
        found.append(Comparison(name, block, _drive(block), ByDifferences(block), states, 1e-5, 100))
    return found


def _drive(block: KalmanFilter) -> np.ndarray:
    """Noisy samples of sinusoidal steering of a linear car at 25 m/s, with the columns of the filter's sample."""
    chance, time_ = np.random.default_rng(0), np.arange(STEPS // 2) * RATE
    sine = np.sin(2.0 * np.pi * 0.3 * time_)
    count = len(sine)
    known = {
        "input.vehicle_speed": np.full(count, 25.0),
        "input.longitudinal_acceleration": np.zeros(count),
        "input.road_wheel_angle": 0.02 * sine,
        "input.road_wheel_torque": 90.0 * sine,
        "input.torque_known": np.ones(count),
        "measured.yaw_rate": 0.13 * sine + 0.003 * chance.normal(size=count),
        "measured.lateral_acceleration": 3.2 * sine + 0.1 * chance.normal(size=count),
        "measured.road_wheel_angle": 0.02 * sine + 2e-4 * chance.normal(size=count),
    }
    return np.column_stack([known[name] for name in trace(block).sample])
