"""Column benches with hands that come and go, and scores of a monitor of the hands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.graph import Memory, scan
from tierod.core.graph.kernel import kernel
from tierod.monitors.driver_torque.hands import UNCERTAIN, HandsMonitor
from tierod_lab.ground.cars.benches import ColumnBench
from tierod_lab.ground.courses.bench import BenchHands

PIECE = 60.0  # Duration of a simulated piece, so short that its arrays fit into the processor's cache [s]
STEP = 1e-3  # Sampling interval [s]
ANGLE_NOISE, ANGLE_STEP, TORQUE_NOISE = math.radians(0.005), math.radians(0.01), 0.01
"""Noise and resolution of the angle sensor, noise of the torque sensor, as on the proving ground [rad, rad, N m]."""
SCATTERED = (
    "wheel_inertia",
    "wheel_damping",
    "bar_stiffness",
    "gear_stiffness",
    "gear_inertia",
    "motor_inertia",
    "motor_damping",
)
"""Parameters of the bench that are made wrong for the observer of the hands, with the gain of its torque sensor."""


class Bench(NamedTuple):
    """A randomly drawn bench."""

    plant: ColumnBench  # bench with its own parameters
    gain: float  # gain of the torque sensor
    offset: float  # offset of the torque sensor [N m]
    course: BenchHands  # course of hands and motor
    seed: int  # seed of the noise


class Score(NamedTuple):
    """Detection delays and false changes of a monitor."""

    grabs: np.ndarray  # grabs, releases: detection delays of hands on and hands off [s]; infinite where undetected
    releases: np.ndarray
    # false_on, false_off: changes to "on" without hands and to "off" with hands, after the correct first detection
    false_on: int
    false_off: int
    seconds: Annotated[float, "s"]  # total time [s]


def drawn(seed: int, share: float, seconds: float) -> Bench:
    """Draw a bench whose parameters and torque sensor gain are wrong by a share, either way, with a torque offset."""
    draw = np.random.default_rng([seed, 7])
    plant = ColumnBench()
    ways = draw.choice([-1.0, 1.0], len(SCATTERED) + 1)
    off = {name: getattr(plant, name) * (1.0 + share * way) for name, way in zip(SCATTERED, ways[:-1], strict=True)}
    gain, offset = 1.0 + share * float(ways[-1]), float(draw.normal(0.0, 0.03))
    return Bench(replace(plant, **off), gain, offset, BenchHands(time=seconds, seed=seed, tremor=0.03), seed)


def _pieces(bench: Bench) -> Iterator[np.ndarray]:
    """Samples of angle [rad] and torque [N m] of a bench, piece by piece."""
    names = kernel(bench.plant).graph.sample
    draw, state = np.random.default_rng([bench.seed, 8]), None
    count, size = round(bench.course.duration / STEP), round(PIECE / STEP)
    for begin in range(0, count, size):
        time = np.arange(begin, min(begin + size, count)) * STEP
        given = bench.course.columns(time, time, 0.0, 0.0)
        inputs = np.zeros((len(time), len(names)))
        for column, name in enumerate(names):
            inputs[:, column] = given.get(name, 1.0 if name.endswith("gain") else 0.0)
        result = scan(bench.plant, inputs, state)
        state = result.state
        noise = draw.standard_normal((2, len(time)))
        angle = result["steering_wheel_angle"] + ANGLE_NOISE * noise[0]
        torque = bench.gain * result["driver_torque"] + bench.offset + TORQUE_NOISE * noise[1]
        yield np.column_stack([np.round(angle / ANGLE_STEP) * ANGLE_STEP, torque])


def scored(monitor: HandsMonitor, bench: Bench) -> Score:
    """Score of a monitor on a bench."""
    state: Memory | None = None
    hands = []
    for samples in _pieces(bench):
        result = scan(monitor, samples, state)
        state = result.state
        hands.append(result["hands"].astype(np.float32))
    return score(np.concatenate(hands), bench.course)


def score(hands: np.ndarray, course: BenchHands) -> Score:
    """Score the decisions of a monitor, its state of the hands by sample, against the true course of the hands."""
    decided = decisions(hands)
    switches, ends = course.switches[:-1], course.switches[1:]
    # An episode that the end of the run cuts off has no complete delay.
    whole = ends < len(hands) * STEP
    delays: tuple[list[float], list[float]] = ([], [])
    false = [0, 0]
    for number, (start, end) in enumerate(zip(switches[whole], ends[whole], strict=True)):
        on = number % 2 == 0
        part = decided[round(start / STEP) : round(end / STEP)]
        right = np.flatnonzero(part == float(on))
        delays[on].append(right[0] * STEP if len(right) else math.inf)
        if len(right):
            false[not on] += int(np.count_nonzero(np.diff(part[right[0] :]) == (-1.0 if on else 1.0)))
    return Score(np.array(delays[1]), np.array(delays[0]), false[1], false[0], len(hands) * STEP)


def decisions(hands: np.ndarray) -> np.ndarray:
    """States of the hands, in which an uncertain sample keeps the last decision."""
    decided: np.ndarray = hands[np.maximum.accumulate(np.where(hands == UNCERTAIN, 0, np.arange(len(hands))))]
    return decided
