"""Drives of the motor bench with faults inside the loop: the current control reads the recorded, faulty signals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import Result, scan
from tierod.core.graph.trace import trace
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.papers.motor_angle.fault_kinds import Fault

RATE, SUBSTEPS = 1e4, 10
"""Sampling rate of the recording [Hz], and samples per step of the bench."""
NOISES = {
    "motor_current_alpha": 0.15,
    "motor_current_beta": 0.15,
    "motor_voltage_alpha": 0.03,
    "motor_voltage_beta": 0.03,
    "motor_angle_mechanical": 5e-4,
}
"""Standard deviations of the sensor noise by signal, in its unit."""
ANGLE = MotorAngleSample._fields.index("motor_angle_mechanical")
"""Column of the angle sensor in the samples."""


def bench_time(seconds: float) -> np.ndarray:
    """Times of the steps of the bench, every millisecond [s]."""
    return np.arange(round(seconds * RATE / SUBSTEPS)) * SUBSTEPS / RATE


def course(time: np.ndarray, seed: int) -> np.ndarray:
    """Target angle of the motor of an active front steering at work: four sines, up to some 100 rad/s [rad]."""
    random = np.random.default_rng(seed)
    parts = [
        random.uniform(0.4, 1.0) / (0.4 + f) * np.sin(2.0 * np.pi * f * time + random.uniform(0.0, 2.0 * np.pi))
        for f in (0.15, 0.4, 0.9, 1.7)
    ]
    return np.asarray(12.0 * np.sum(parts, axis=0) * np.clip(2.0 * time, 0.0, 1.0))


@dataclass(frozen=True)
class BenchDrive:
    """A drive as the monitor receives it, with the truth.

    Args:
        samples: signals of `MotorAngleSample` at `RATE`, (n, signals)
        speed: true speed of the shaft [rad/s], (n,)
        angle: true angle of the shaft [rad], (n,)
    """

    samples: np.ndarray
    speed: np.ndarray
    angle: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Time from the first sample [s]."""
        return np.arange(len(self.speed)) / RATE


def drive(seed: int, seconds: float, fault: Fault | None = None, start: float = 0.0) -> BenchDrive:
    """Simulate and record a drive of the bench.

    Args:
        seed: seed of course and noise
        seconds: duration [s]
        fault: fault of the drive; None for a fault-free one
        start: start of the fault [s]
    """
    return noisy(clean_drive(seed, seconds, fault, start), np.random.default_rng([seed, 77]))


def clean_drive(
    seed: int,
    seconds: float,
    fault: Fault | None = None,
    start: float = 0.0,
    plant: MotorBench | None = None,
    load: np.ndarray | None = None,
    target: np.ndarray | None = None,
) -> BenchDrive:
    """Simulate a drive of the bench without sensor noise.

    Args:
        seed, seconds, fault, start: as in `drive`
        plant: the bench; the default one where None
        load: load torque besides the spring, a value per step of the bench; none where None [N*m]
        target: target angle of the motor, a value per step of the bench; that of `course` where None [rad]
    """
    plant, time = plant or MotorBench(), bench_time(seconds)
    inputs = bench_inputs(course(time, seed) if target is None else target)
    if load is not None:
        inputs["load_torque"] = load
    if fault is not None:
        inputs |= faulty_ports(fault, time - start, inputs["target_motor_angle"])
    found = scan(plant, np.column_stack(list(inputs.values())))
    return recorded(found, inputs, 0.0 if fault is None else fault.quantum, start)


def bench_inputs(target: np.ndarray) -> dict[str, np.ndarray]:
    """Fault-free inputs of a bench under angle control.

    Args:
        target: target angle, a value per step of the bench [rad]
    """
    return inputs_of(MotorBench(), target_motor_angle=target, control=np.ones(len(target)))


def inputs_of(plant: Block, **given: np.ndarray) -> dict[str, np.ndarray]:
    """All inputs of a bench in its order: the given ones, a value per step, and fault-free ports."""
    steps = len(next(iter(given.values())))
    return {name: np.full(steps, 1.0 if name.endswith(".gain") else 0.0) for name in trace(plant).sample} | given


def fine(found: Result, name: str) -> np.ndarray:
    """Signal of the motor at `RATE`, from the outputs of its bench."""
    return np.column_stack([found[f"motor.fine.{name}.{k}"] for k in range(SUBSTEPS)]).ravel()


def faulty_ports(fault: Fault, since: np.ndarray, target: np.ndarray) -> dict[str, np.ndarray]:
    """Gain, offset and hold of a fault at the port of its signal, a value per step of the bench.

    Args:
        fault: the fault
        since: time since the start of the fault, a value per step of the bench; negative before it [s]
        target: target angle of the motor, a value per step of the bench [rad]
    """
    # The tolerance keeps rounding of the time from delaying the fault by a step.
    on, since, port = since >= -1e-9, np.maximum(since, 0.0), f"ports.{fault.signal}"
    gain, offset = fault.gain(since), fault.offset(since)
    # The offset makes up for the gain at the angle of the start, so that the faulty reading does not jump there.
    if fault.from_here:
        offset = offset + (1.0 - gain) * target[np.argmax(on)]
    return {
        f"{port}.gain": np.where(on, gain, 1.0),
        f"{port}.offset": np.where(on, offset, 0.0),
        f"{port}.held": np.where(on & fault.held, 1.0, 0.0),
    }


def recorded(found: Result, inputs: Mapping[str, np.ndarray], quantum: float = 0.0, start: float = 0.0) -> BenchDrive:
    """Record the signals of the bench behind their ports; the target angle only at its own instants.

    Args:
        found: outputs of the bench
        inputs: inputs of the bench
        quantum: resolution of the angle from `start` on, 0 for exact readings [rad]
        start: start of the coarse resolution [s]
    """

    def through(name: str) -> np.ndarray:
        port, values = f"ports.{name}", fine(found, name)
        held = np.repeat(inputs[f"{port}.held"], SUBSTEPS) > 0.5
        if held.any():
            values = np.where(held, values[np.argmax(held) - 1], values)
        return np.asarray(
            np.repeat(inputs[f"{port}.gain"], SUBSTEPS) * values + np.repeat(inputs[f"{port}.offset"], SUBSTEPS)
        )

    speed = fine(found, "motor_speed")
    samples = np.full((len(speed), len(MotorAngleSample._fields)), np.nan)
    for name in NOISES:
        samples[:, MotorAngleSample._fields.index(name)] = fine(found, name) if "voltage" in name else through(name)
    if quantum:
        angle = samples[round(start * RATE) :, ANGLE]
        angle[:] = quantum * np.round(angle / quantum)
    target = MotorAngleSample._fields.index("target_motor_angle_mechanical")
    samples[::SUBSTEPS, target] = inputs["target_motor_angle"]
    return BenchDrive(samples, speed, fine(found, "motor_angle_mechanical"))


def noisy(clean: BenchDrive, random: np.random.Generator) -> BenchDrive:
    """The drive with sensor noise."""
    samples = clean.samples.copy()
    for name, noise in NOISES.items():
        samples[:, MotorAngleSample._fields.index(name)] += noise * random.normal(size=len(samples))
    return replace(clean, samples=samples)
