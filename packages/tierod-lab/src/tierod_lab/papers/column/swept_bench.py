"""The bench column swept by its motor while hands turn the wheel, and the errors of observers on such runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import scan
from tierod.core.graph.maths import limit
from tierod.models.steering_column import ColumnParameters
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import Acting, BenchPorts, BenchSignals, BenchState, ColumnBench
from tierod_lab.ground.parts import NO_FAULT

AMPLITUDE = math.radians(30.0)  # Amplitude of the sweep, as in figure 10 of the paper [rad]
HIGHEST = 3.0
LOWEST = 0.1  # Highest and lowest frequency of the sweep [Hz]
SETTLE = 1.0  # Time at rest before the sweep [s]
NOISE = {"steering_wheel_angle": math.radians(0.05), "motor_angle_mechanical": math.radians(0.2), "driver_torque": 0.02}
"""Standard deviation of the sensor noise [rad, rad, N·m]."""

HANDS = ("steps", "ramps", "free")
"""Behaviours of the hands: steps of 2 N·m after a sine of 1.5 N·m, the same with ramps of 100 ms, hands off."""


class Demand(NamedTuple):
    """Reference angle of the shaft, its derivatives, and the torque of the hands."""

    angle: Annotated[float, "rad"]
    rate: Annotated[float, "rad/s"]
    acceleration: Annotated[float, "rad/s**2"]
    hand_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class SweptBench:
    """A bench whose motor follows an angle by PD control with feed-forward of inertia and damping."""

    bench: ColumnBench = field(default_factory=ColumnBench)  # the plant
    stiffness: Annotated[float, "N*m/rad"] = 150.0  # proportional gain at the steering wheel axis [N m/rad]
    damping: Annotated[float, "N*m*s/rad"] = 5.0  # derivative gain at the steering wheel axis [N m s/rad]
    highest_torque: Annotated[float, "N*m"] = 3.0  # largest torque of the motor at its shaft [N m]

    Sample = Demand

    def init(self) -> BenchState:
        return self.bench.init()

    def step(self, state: BenchState, sample: Demand) -> tuple[BenchState, BenchSignals]:
        ratio = self.bench.gear_ratio
        motion = state.motion
        lag = sample.angle - motion.motor_angle / ratio
        late = sample.rate - motion.motor_rate / ratio
        inertia = self.bench.wheel_inertia + self.bench.gear_inertia + ratio**2 * self.bench.motor_inertia
        losses = self.bench.wheel_damping + ratio**2 * self.bench.motor_damping
        ahead = inertia * sample.acceleration + losses * sample.rate
        wanted = (self.stiffness * lag + self.damping * late + ahead) / ratio
        motor = limit(wanted, -self.highest_torque, self.highest_torque)
        return self.bench.step(state, Acting(motor, 0.0, 0.0, sample.hand_torque, 0.0, 0.0, 0.0, BenchPorts(NO_FAULT)))


def demands(hands: str, seconds: float, sample_time: float = 1e-3, seed: int = 0, pace: str = "octaves") -> np.ndarray:
    """Rows of `Demand`: a sweep after a rest, with hands.

    Args:
        hands: one of `HANDS`
        seconds: duration [s]
        sample_time: sampling interval [s]
        seed: seed of the times at which the hands pull
        pace: "octaves" for a logarithmic sweep, or "linear", which stays longer at high frequencies
    """
    time = np.arange(round(seconds / sample_time)) * sample_time
    since = np.maximum(time - SETTLE, 0.0)
    phase, rate, growth = _swept(since, seconds - SETTLE, pace)
    rate, growth = (np.where(time < SETTLE, 0.0, each) for each in (rate, growth))
    columns = (
        AMPLITUDE * np.sin(phase),
        AMPLITUDE * rate * np.cos(phase),
        AMPLITUDE * (growth * np.cos(phase) - rate**2 * np.sin(phase)),
        _hands(hands, time, seed),
    )
    return np.column_stack(columns)


def _swept(since: np.ndarray, seconds: float, pace: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Phase of the sweep [rad] and its first and second derivative."""
    low, high = 2.0 * math.pi * LOWEST, 2.0 * math.pi * HIGHEST
    if pace == "linear":
        slope = (high - low) / seconds
        return (low + 0.5 * slope * since) * since, low + slope * since, np.full(len(since), slope)
    growth = math.log(high / low) / seconds
    rate = low * np.exp(growth * since)
    return (rate - low) / growth, rate, growth * rate


def _hands(hands: str, time: np.ndarray, seed: int) -> np.ndarray:
    """A sine of 1.5 N·m at 0.5 Hz in the first half, then two pulls of 2 N·m, to the left and to the right."""
    if hands == "free":
        return np.zeros(len(time))
    end, width = float(time[-1]), 0.1 if hands == "ramps" else 1e-9
    torque = np.where((time > 2.0) & (time < 0.5 * end), 1.5 * np.sin(math.pi * (time - 2.0)), 0.0)
    begins = end * (np.array([0.55, 0.78]) + np.random.default_rng([seed, 17]).uniform(0.0, 0.08, 2))
    for level, begin in zip((2.0, -2.0), begins, strict=True):
        instants = [begin, begin + width, begin + 0.1 * end, begin + 0.1 * end + width]
        torque = torque + np.interp(time, instants, [0.0, level, level, 0.0])
    return torque


def swept(
    hands: str, seconds: float = 40.0, seed: int = 0, bench: SweptBench | None = None, pace: str = "octaves"
) -> dict[str, np.ndarray]:
    """Simulate a run of the bench: inputs of an observer with sensor noise, and true values.

    Args:
        hands: one of `HANDS`
        seconds: duration [s]
        bench: the plant; the default one where None
        pace: pace of the sweep, see `demands`

    Returns:
        columns by name; `hand_torque`, `disturbance_torque` (of friction) and `steering_wheel_rate` are true values
    """
    plant = bench or SweptBench()
    true = scan(plant, demands(hands, seconds, plant.bench.step_time, seed, pace))
    random = np.random.default_rng([seed, 18])
    columns: dict[str, np.ndarray] = {}
    for name, sigma in NOISE.items():
        columns[name] = true[name] + random.normal(0.0, sigma, len(true))
    columns["motor_torque"] = np.asarray(true["motor_target_torque"])
    for truth, name in (
        ("truth_hand_torque", "hand_torque"),
        ("truth_motor_friction_torque", "disturbance_torque"),
        ("steering_wheel_rate", "steering_wheel_rate"),
    ):
        columns[name] = np.asarray(true[truth])
    columns["time"] = np.arange(len(true)) * plant.bench.step_time
    return columns


FROM = 0.5  # Warm-up of the observers, which start at rest without further knowledge; errors count after it [s]

SIGNALS = ("motor_torque", "steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
"""Signals in the order of `ColumnSample`."""

DELAY = 20  # Lag of the delayed estimate in samples: 20 ms


Change = Callable[[np.ndarray], np.ndarray]


def known_column() -> ColumnParameters:
    """True parameters of the bench column, from its vehicle file."""
    return load("column-bench").parameters_for(ColumnParameters)


@dataclass(frozen=True)
class Errors:
    """Root mean square errors of an observer over some runs."""

    hand_torque: float  # error of the hand torque [N m]
    disturbance_torque: float  # error of the disturbance torque [N m]; NaN where it is not estimated
    nis: float  # mean normalised innovation squared; NaN where the observer has none


def samples(run: Mapping[str, np.ndarray]) -> np.ndarray:
    """Samples of an observer, in the order of `ColumnSample`, (n, 4)."""
    return np.column_stack([run[name] for name in SIGNALS])


def rms(parts: Sequence[np.ndarray]) -> float:
    """Root mean square over all parts; NaN where there is no part."""
    return float(np.sqrt(np.mean(np.square(np.concatenate(parts))))) if len(parts) else float("nan")


def errors(
    block: Block, runs: Sequence[Mapping[str, np.ndarray]], delay: int = 0, change: Change | None = None
) -> Errors:
    """Errors of an observer over some runs.

    Args:
        block: observer of `ColumnSample`
        runs: results of `swept`
        change: function that falsifies the samples before the observer; none where None
    """
    hand, disturbance, nis = [], [], []
    for run in runs:
        given = samples(run)
        found = scan(block, given if change is None else change(given))
        # The estimate of sample k + delay refers to the truth of sample k.
        late, known = slice(delay, None), slice(len(given) - delay)
        counted = run["time"][known] > FROM
        hand.append((found["hand_torque"][late] - run["hand_torque"][known])[counted])
        if "disturbance_torque" in found.names:
            disturbance.append((found["disturbance_torque"][late] - run["disturbance_torque"][known])[counted])
        if "nis" in found.names:
            nis.append(found["nis"][late][counted])
    return Errors(rms(hand), rms(disturbance), float(np.mean(np.concatenate(nis))) if nis else float("nan"))
