"""The bench column swept by its motor while hands turn the wheel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.core.graph.maths import limit
from tierod.models.steering_column import ColumnParameters
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import Acting, BenchPorts, BenchSignals, BenchState, ColumnBench
from tierod_lab.ground.parts import NO_FAULT

STEP = 1e-3  # Sampling interval [s]
AMPLITUDE = math.radians(30.0)  # Amplitude of the sweep, as in figure 10 of the paper [rad]
LOWEST, HIGHEST = 0.1, 3.0  # Lowest and highest frequency of the sweep [Hz]
SETTLE = 1.0  # Time at rest before the sweep [s]
NOISE = {"steering_wheel_angle": math.radians(0.05), "motor_angle_mechanical": math.radians(0.2), "driver_torque": 0.02}
"""Standard deviation of the sensor noise [rad, rad, N·m]."""
SIGNALS = ("motor_torque", "steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
"""Signals in the order of `ColumnSample`."""
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


def demands(hands: str, seconds: float, seed: int = 0) -> np.ndarray:
    """Rows of `Demand`: a logarithmic sweep after a rest, with hands, one of `HANDS`."""
    time = np.arange(round(seconds / STEP)) * STEP
    since = np.maximum(time - SETTLE, 0.0)
    low = math.tau * LOWEST
    growth = math.log(HIGHEST / LOWEST) / (seconds - SETTLE)
    rate = low * np.exp(growth * since)
    phase = (rate - low) / growth
    rate, rise = (np.where(time < SETTLE, 0.0, each) for each in (rate, growth * rate))
    columns = (
        AMPLITUDE * np.sin(phase),
        AMPLITUDE * rate * np.cos(phase),
        AMPLITUDE * (rise * np.cos(phase) - rate**2 * np.sin(phase)),
        _hands(hands, time, seed),
    )
    return np.column_stack(columns)


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


def swept(hands: str, seconds: float = 40.0, seed: int = 0, bench: SweptBench | None = None) -> dict[str, np.ndarray]:
    """Simulate a run of the bench: inputs of an observer with sensor noise, and true values.

    Returns:
        columns by name; `hand_torque`, `disturbance_torque` (of friction) and `steering_wheel_rate` are true values
    """
    true = scan(bench or SweptBench(), demands(hands, seconds, seed))
    random = np.random.default_rng([seed, 18])
    columns: dict[str, np.ndarray] = {}
    for name, sigma in NOISE.items():
        columns[name] = true[name] + random.normal(0.0, sigma, len(true))
    columns["motor_torque"] = np.asarray(true["motor_target_torque"])
    columns["hand_torque"] = np.asarray(true["truth_hand_torque"])
    columns["disturbance_torque"] = np.asarray(true["truth_motor_friction_torque"])
    columns["steering_wheel_rate"] = np.asarray(true["steering_wheel_rate"])
    columns["time"] = np.arange(len(true)) * STEP
    return columns


def known_column() -> ColumnParameters:
    """True parameters of the bench column, from its vehicle file."""
    return load("column-bench").parameters_for(ColumnParameters)


def samples(run: Mapping[str, np.ndarray]) -> np.ndarray:
    """Samples of an observer, in the order of `ColumnSample`, (n, 4)."""
    return np.column_stack([run[name] for name in SIGNALS])
