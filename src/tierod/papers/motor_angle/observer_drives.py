"""Drives of the motor bench for its observers: to and fro against a spring, or at one speed with steps of load."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import Result, scan
from tierod.core.graph.trace import trace
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.papers.motor_angle.fault_drives import ANGLE_NOISE, CURRENT_NOISE, RATE, SUBSTEPS, VOLTAGE_NOISE, course
from tierod.physics.pm_motor import REFERENCE_TEMPERATURE
from tierod.proving_ground.cars.motor_bench import MotorBench
from tierod.proving_ground.motor import AFS_MOTOR, Inverter, Warming

SAMPLE_TIME = 1.0 / RATE
NOISE = (CURRENT_NOISE, CURRENT_NOISE, VOLTAGE_NOISE, VOLTAGE_NOISE, ANGLE_NOISE)
"""Standard deviations, in the order of a sample."""


@dataclass(frozen=True)
class ObserverDrive:
    """A drive as an observer sees it, and the truth.

    Args:
        samples: of `MotorAngleObserver.Sample`, (n, 5), at `RATE`
        angle, speed: of the shaft [rad], [rad/s], (n,)
        load: all that opposes the rotor but its viscous friction [N*m], (n,)
        commands: voltages that the inverter was told to make, in the stator's axes [V], (n, 2)
        resistance: of a phase, as warm as it is [ohm], (n,)
    """

    samples: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    load: np.ndarray
    commands: np.ndarray
    resistance: np.ndarray

    @property
    def commanded(self) -> np.ndarray:
        """The samples with the commands in place of the voltages."""
        return np.column_stack([self.samples[:, :2], self.commands, self.samples[:, 4]])

    @property
    def time(self) -> np.ndarray:
        """From the first sample [s]."""
        return np.arange(len(self.angle)) / RATE

    def observed(self, observer: Any) -> Result:
        """Outputs of an observer."""
        return scan(observer, self.samples)


def bench(
    temperature: float = REFERENCE_TEMPERATURE, stiffness: float = 0.05, inverter: Inverter = AFS_MOTOR.inverter
) -> MotorBench:
    """A bench whose motor keeps one temperature.

    Args:
        temperature: of winding and magnets [K]; at 20 degrees the vehicle file is right
        stiffness: of the spring [N*m/rad]
        inverter: between battery and motor
    """
    constant = Warming(winding_capacity=1e9, housing_capacity=1e9, ambient_temperature=temperature)
    return MotorBench(motor=replace(AFS_MOTOR, warming=constant, inverter=inverter), load_stiffness=stiffness)


@lru_cache(maxsize=8)
def to_and_fro(
    seed: int, seconds: float, temperature: float = REFERENCE_TEMPERATURE, inverter: Inverter = AFS_MOTOR.inverter
) -> ObserverDrive:
    """A superposition at work against a spring.

    Args:
        seed: of course and noises
        seconds: how long
        temperature: of the motor [K]
        inverter: between battery and motor
    """
    time = np.arange(round(seconds * RATE / SUBSTEPS)) * SUBSTEPS / RATE
    return drive(bench(temperature, inverter=inverter), course(time, seed), np.zeros(len(time)), seed)


def drive(plant: Block, target: np.ndarray, load: np.ndarray, seed: int, **more: np.ndarray) -> ObserverDrive:
    """A drive of a bench under control of its angle.

    Args:
        plant: the bench, or one that varies
        target: angle, a value per step of the bench [rad]
        load: torque that opposes besides the spring, likewise [N*m]
        seed: of the noises
        more: further inputs of the bench by name, likewise
    """
    return _run(plant, seed, target_motor_angle=target, load_torque=load, control=np.ones(len(target)), **more)


def locked(plant: Block, torque: np.ndarray, seed: int) -> ObserverDrive:
    """A bench whose shaft is held still.

    Args:
        plant: the bench
        torque: asked of the drive, a value per step of the bench [N*m]
        seed: of the noises
    """
    return _run(plant, seed, motor_torque=torque, locked=np.ones(len(torque)))


def _run(plant: Block, seed: int, **given: np.ndarray) -> ObserverDrive:
    steps = len(next(iter(given.values())))
    inputs = {name: np.full(steps, 1.0 if name.endswith(".gain") else 0.0) for name in trace(plant).sample} | given
    found = scan(plant, np.column_stack(list(inputs.values())))

    def fine(name: str) -> np.ndarray:
        return np.column_stack([found[f"motor.fine.{name}.{k}"] for k in range(SUBSTEPS)]).ravel()

    true = np.column_stack([fine(name) for name in MotorAngleObserver.Sample._fields])
    noise = np.random.default_rng([seed, 5]).normal(size=true.shape) * NOISE
    opposing = found["motor.truth_load_torque"] + found["motor.truth_motor_friction_torque"]
    commands = np.column_stack([fine(f"motor_target_voltage_{axis}") for axis in ("alpha", "beta")])
    angle, speed = fine("motor_angle_mechanical"), fine("motor_speed")
    load, resistance = (np.repeat(each, SUBSTEPS) for each in (opposing, found["motor.truth_motor_resistance"]))
    return ObserverDrive(true + noise, angle, speed, load, commands, resistance)
