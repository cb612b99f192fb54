"""The observers of a motor angle by name, drives of the motor bench for them, and their accuracy."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import Result, scan
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.pm_motor import REFERENCE_TEMPERATURE
from tierod.vehicles import load
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.motor import AFS_MOTOR, Inverter, Warming
from tierod_lab.papers.motor_angle.dq_motor import DqMotorParameters
from tierod_lab.papers.motor_angle.fault_drives import NOISES, RATE, SUBSTEPS, bench_time, course, fine, inputs_of
from tierod_lab.papers.motor_angle.feedforward import FeedforwardAngle, FeedforwardWithLoad
from tierod_lab.papers.motor_angle.flux_observer import FluxObserver
from tierod_lab.papers.motor_angle.printed_observers import extended_kalman, luenberger, reduced_luenberger

SAMPLE_TIME = 1.0 / RATE
"""Sampling interval [s]."""
NOISE = tuple(NOISES[name] for name in MotorAngleObserver.Sample._fields)
"""Standard deviations of the sensor noise, in the order of a sample [A, A, V, V, rad]."""


@dataclass(frozen=True)
class ObserverDrive:
    """Inputs of an observer over a drive, and the truth.

    Args:
        samples: signals of `MotorAngleObserver.Sample` at `RATE`, (n, 5)
        angle, speed: true angle and speed of the shaft [rad], [rad/s], (n,)
        load: torque that opposes the rotor, except its viscous friction [N*m], (n,)
        commands: voltages commanded to the inverter, in the stator frame [V], (n, 2)
        resistance: true phase resistance at the temperature of the winding [ohm], (n,)
    """

    samples: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    load: np.ndarray
    commands: np.ndarray
    resistance: np.ndarray

    @property
    def commanded(self) -> np.ndarray:
        """The samples with the commanded instead of the measured voltages."""
        return np.column_stack([self.samples[:, :2], self.commands, self.samples[:, 4]])

    @property
    def time(self) -> np.ndarray:
        """Time from the first sample [s]."""
        return np.arange(len(self.angle)) / RATE

    def observed(self, observer: Block) -> Result:
        """Outputs of an observer."""
        return scan(observer, self.samples)

    def error(self, observer: Block) -> np.ndarray:
        """Error of an observer's angle [rad]."""
        return np.asarray(self.observed(observer)["motor_angle"] - self.angle)


def bench(
    temperature: float = REFERENCE_TEMPERATURE, stiffness: float = 0.05, inverter: Inverter = AFS_MOTOR.inverter
) -> MotorBench:
    """A bench whose motor keeps a constant temperature.

    Args:
        temperature: temperature of winding and magnets [K]; the vehicle file holds at 20 degrees
        stiffness: stiffness of the spring that loads the shaft [N*m/rad]
        inverter: inverter of the motor
    """
    # Huge heat capacities keep the temperature.
    constant = Warming(winding_capacity=1e9, housing_capacity=1e9, ambient_temperature=temperature)
    return MotorBench(motor=replace(AFS_MOTOR, warming=constant, inverter=inverter), load_stiffness=stiffness)


@lru_cache(maxsize=8)
def to_and_fro(
    seed: int, seconds: float, temperature: float = REFERENCE_TEMPERATURE, inverter: Inverter = AFS_MOTOR.inverter
) -> ObserverDrive:
    """Simulate a drive in both directions against a spring, along `course`.

    Args:
        seed: seed of course and noise
        seconds: duration [s]
        temperature: temperature of the motor [K]
        inverter: inverter of the motor
    """
    time = bench_time(seconds)
    return drive(bench(temperature, inverter=inverter), course(time, seed), np.zeros(len(time)), seed)


def drive(plant: Block, target: np.ndarray, load: np.ndarray, seed: int, **more: np.ndarray) -> ObserverDrive:
    """Simulate a bench under angle control.

    Args:
        plant: the bench, or a `Varied` one with parameters as inputs
        target: target angle, a value per step of the bench [rad]
        load: load torque besides the spring, a value per step of the bench [N*m]
        seed: seed of the noise
        more: further inputs of the bench by name, a value per step
    """
    return _run(plant, seed, target_motor_angle=target, load_torque=load, control=np.ones(len(target)), **more)


def locked(plant: Block, torque: np.ndarray, seed: int) -> ObserverDrive:
    """Simulate a bench with locked shaft.

    Args:
        plant: the bench
        torque: torque command, a value per step of the bench [N*m]
        seed: seed of the noise
    """
    return _run(plant, seed, motor_torque=torque, locked=np.ones(len(torque)))


def _run(plant: Block, seed: int, **given: np.ndarray) -> ObserverDrive:
    found = scan(plant, np.column_stack(list(inputs_of(plant, **given).values())))
    true = np.column_stack([fine(found, name) for name in MotorAngleObserver.Sample._fields])
    opposing = found["motor.truth_load_torque"] + found["motor.truth_motor_friction_torque"]
    commands = np.column_stack([fine(found, f"motor_target_voltage_{axis}") for axis in ("alpha", "beta")])
    angle, speed = fine(found, "motor_angle_mechanical"), fine(found, "motor_speed")
    load, resistance = (np.repeat(each, SUBSTEPS) for each in (opposing, found["motor.truth_motor_resistance"]))
    return ObserverDrive(true + noises(seed, true.shape), angle, speed, load, commands, resistance)


def noises(seed: int, shape: tuple[int, ...]) -> np.ndarray:
    """Normally distributed sensor noise of a drive.

    Args:
        seed: seed of the drive
        shape: shape of its samples
    """
    return np.asarray(np.random.default_rng([seed, 5]).normal(size=shape) * NOISE)


SPEEDS = (0.0, 20.0, 40.0, 80.0, math.inf)
"""Edges of the speed ranges [rad/s]."""


def with_true(p: SampledMotorParameters, resistance: float, flux: float, inductance: float) -> SampledMotorParameters:
    """Parameters for an observer, such that the true ones are larger by the given factors."""
    return replace(
        p,
        motor_resistance=p.motor_resistance / resistance,
        motor_flux=p.motor_flux / flux,
        motor_inductance=p.motor_inductance / inductance,
    )


RESISTANCE, FLUX, INDUCTANCE = (0.8, 1.3), (0.94, 1.02), (0.93, 1.07)
"""Ranges of the true values over those that an observer assumes, by temperature and tolerance."""


def of_another_motor(random: np.random.Generator) -> MotorAngleObserver:
    """The observer with parameters from which the true ones differ at random, within the ranges."""
    factors = (random.uniform(*span) for span in (RESISTANCE, FLUX, INDUCTANCE))
    return MotorAngleObserver(with_true(parameters()[1], *factors))


class Accuracy(NamedTuple):
    """Accuracy of an observer: rms errors of speed [rad/s] and angle [rad], and largest error of the angle [rad]."""

    speed: float
    angle: float
    largest: float


def parameters(name: str = "motor-bench") -> tuple[DqMotorParameters, SampledMotorParameters]:
    """Parameters of a vehicle's motor, for observers in the rotor frame and in the stator frame."""
    vehicle = load(name)
    return vehicle.parameters_for(DqMotorParameters), vehicle.parameters_for(SampledMotorParameters)


def methods(vehicle: str = "motor-bench") -> dict[str, Block]:
    """All compared observers of a vehicle's motor by name."""
    dq, fixed = parameters(vehicle)
    found: dict[str, Block] = {}
    for name, make in (
        ("Luenberger", luenberger),
        ("reduced Luenberger", reduced_luenberger),
        ("Kalman filter", extended_kalman),
    ):
        found[f"{name}, as printed"] = make(dq, SAMPLE_TIME, load=False, axes="measured")
        found[f"{name}, with load"] = make(dq, SAMPLE_TIME, axes="measured")
        found[f"{name}, with load, own axes"] = make(dq, SAMPLE_TIME)
    found["feedforward, held when slow"] = FeedforwardAngle(fixed)
    found["feedforward, increments when slow"] = FeedforwardAngle(fixed, slow="increments")
    found["feedforward, increments, with load"] = FeedforwardWithLoad.of(fixed, slow="increments")
    found["flux observer"] = FluxObserver(fixed)
    found["default"] = MotorAngleObserver(fixed)
    return found


def accuracy(observer: Block, drives: list[ObserverDrive]) -> Accuracy:
    """Accuracy of an observer over some drives."""
    squares, largest = np.zeros(2), 0.0
    for seen in drives:
        found = seen.observed(observer)
        away = found["motor_angle"] - seen.angle
        squares += np.mean((found["motor_speed"] - seen.speed) ** 2), np.mean(away**2)
        largest = max(largest, float(np.abs(away).max()))
    speed, angle = np.sqrt(squares / len(drives))
    return Accuracy(float(speed), float(angle), largest)


def by_speed(observer: Block, drives: list[ObserverDrive]) -> list[float]:
    """Root mean square of the electrical error modulo whole turns, per range of `SPEEDS` [rad]."""
    within = electrical(np.concatenate([seen.error(observer) for seen in drives]))
    speed = np.abs(np.concatenate([seen.speed for seen in drives]))
    return [rms(within[(speed >= low) & (speed < high)]) for low, high in pairwise(SPEEDS)]


def electrical(angle: np.ndarray) -> np.ndarray:
    """Electrical angle of an angle of the bench's shaft, wrapped to -pi to pi [rad]."""
    return np.angle(np.exp(1j * parameters()[0].motor_pole_pairs * angle))


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))
