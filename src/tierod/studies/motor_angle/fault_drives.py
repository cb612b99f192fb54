"""Drives of the motor bench with faults inside the loop: what the current control reads is what is recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tierod.graph import Result, scan
from tierod.graph.trace import trace
from tierod.monitors.motor_angle.detector import MotorAngleSample
from tierod.proving_ground.cars.motor_bench import MotorBench

RATE, SUBSTEPS = 1e4, 10
CURRENT_NOISE, VOLTAGE_NOISE, ANGLE_NOISE = 0.15, 0.03, 5e-4
POLE_PAIRS = 4.0
FIVE_DEGREES = math.radians(5.0) / POLE_PAIRS
"""Of the electrical angle, at the shaft [rad]."""


@dataclass(frozen=True)
class Fault:
    """What becomes of a signal, over the time since the fault began.

    Args:
        name: in words
        gain, offset: of the signal, over the time [s]
        held: whether it stands still
        signal: which one
        size: time until it is as large as an offset of five degrees electrical [s]
    """

    name: str
    gain: Callable[[np.ndarray], np.ndarray] = np.ones_like
    offset: Callable[[np.ndarray], np.ndarray] = np.zeros_like
    held: bool = False
    signal: str = "motor_angle_mechanical"
    size: float = 0.0


def constant(value: float) -> Callable[[np.ndarray], np.ndarray]:
    """The same at all times."""
    return lambda time: np.full_like(time, value)


def _noise(samples: int) -> np.ndarray:
    """White, of standard deviation one."""
    return np.random.default_rng(5).normal(size=samples)


FAULTS = (
    Fault("offset of 5° electrical", offset=constant(FIVE_DEGREES)),
    Fault("offset of -5° electrical", offset=constant(-FIVE_DEGREES)),
    Fault("offset of 20° electrical", offset=constant(4.0 * FIVE_DEGREES)),
    Fault("drift of 20°/s electrical", offset=lambda time: 4.0 * FIVE_DEGREES * time, size=0.25),
    Fault("gain 2 % too large", gain=constant(1.02)),
    Fault("noise of 10° electrical", offset=lambda time: 2.0 * FIVE_DEGREES * _noise(len(time))),
    Fault("20° electrical for 5 ms, ten times a second", offset=lambda time: 4.0 * FIVE_DEGREES * (time % 0.1 < 5e-3)),
    Fault("stuck", held=True),
    Fault("sine and cosine swapped", gain=constant(-1.0), offset=constant(0.5 * math.pi / POLE_PAIRS)),
    Fault("current phases b and c swapped", gain=constant(-1.0), signal="motor_current_beta"),
)
"""Of the sensor, and of one current."""


def course(time: np.ndarray, seed: int) -> np.ndarray:
    """A superposition at work: four sines of the motor's angle, up to some 100 rad/s."""
    random = np.random.default_rng(seed)
    parts = [
        random.uniform(0.4, 1.0) / (0.4 + f) * np.sin(2.0 * np.pi * f * time + random.uniform(0.0, 2.0 * np.pi))
        for f in (0.15, 0.4, 0.9, 1.7)
    ]
    return 12.0 * np.sum(parts, axis=0) * np.clip(2.0 * time, 0.0, 1.0)


@dataclass(frozen=True)
class BenchDrive:
    """A drive as the monitor sees it.

    Args:
        samples: columns of `MotorAngleSample`, (n, columns), at `RATE`
        speed: true speed of the shaft [rad/s], (n,)
    """

    samples: np.ndarray
    speed: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """From the first sample [s]."""
        return np.arange(len(self.speed)) / RATE


def drive(seed: int, seconds: float, fault: Fault | None = None, start: float = 0.0) -> BenchDrive:
    """A drive of the bench.

    Args:
        seed: of course and noises
        seconds: how long
        fault: None for a sound one
        start: of the fault [s]
    """
    time = np.arange(round(seconds * RATE / SUBSTEPS)) * SUBSTEPS / RATE
    inputs = {name: np.zeros(len(time)) for name in trace(MotorBench()).sample}
    inputs["control"][:] = 1.0
    inputs["target_motor_angle"] = course(time, seed)
    for name in inputs:
        if name.endswith(".gain"):
            inputs[name][:] = 1.0
    if fault is not None:
        on = time >= start - 1e-9
        since = np.maximum(time - start, 0.0)
        port = f"ports.{fault.signal}"
        inputs[f"{port}.gain"] = np.where(on, fault.gain(since), 1.0)
        inputs[f"{port}.offset"] = np.where(on, fault.offset(since), 0.0)
        inputs[f"{port}.held"] = np.where(on & fault.held, 1.0, 0.0)
    found = scan(MotorBench(), np.column_stack(list(inputs.values())))
    return _measured(found, inputs, seed)


def _measured(found: Result, inputs: Mapping[str, np.ndarray], seed: int) -> BenchDrive:
    """What is recorded: the truth through the ports, with noise; slow signals with their instants."""

    def fine(name: str) -> np.ndarray:
        return np.column_stack([found[f"motor.fine.{name}.{k}"] for k in range(SUBSTEPS)]).ravel()

    def through(name: str) -> np.ndarray:
        port, values = f"ports.{name}", fine(name)
        held = np.repeat(inputs[f"{port}.held"], SUBSTEPS) > 0.5
        if held.any():
            values = np.where(held, values[np.argmax(held) - 1], values)
        return np.repeat(inputs[f"{port}.gain"], SUBSTEPS) * values + np.repeat(inputs[f"{port}.offset"], SUBSTEPS)

    random = np.random.default_rng([seed, 77])
    speed = fine("motor_speed")
    samples = np.full((len(speed), len(MotorAngleSample._fields)), np.nan)
    noises = {
        "motor_current_alpha": CURRENT_NOISE,
        "motor_current_beta": CURRENT_NOISE,
        "motor_voltage_alpha": VOLTAGE_NOISE,
        "motor_voltage_beta": VOLTAGE_NOISE,
        "motor_angle_mechanical": ANGLE_NOISE,
    }
    for name, noise in noises.items():
        truth = fine(name) if "voltage" in name else through(name)
        samples[:, MotorAngleSample._fields.index(name)] = truth + noise * random.normal(size=len(speed))
    target = MotorAngleSample._fields.index("target_motor_angle_mechanical")
    samples[::SUBSTEPS, target] = inputs["target_motor_angle"]
    return BenchDrive(samples, speed)
