"""Errors of the observers on the bench and in the car, what a step costs, and motors with drawn parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import scan
from tierod.core.graph.analysis import operation_count
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.motor import MotorIdentification, identify_motor
from tierod.models.stator_frame_motor import MotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.motor import flux_at
from tierod.vehicles import load
from tierod_lab.ground import courses
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.cars.benches import MotorBench
from tierod_lab.ground.integration import Varied
from tierod_lab.ground.motor import AFS_MOTOR, Machine, Warming
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.papers.motor_angle.bench import (
    FLUX,
    INDUCTANCE,
    RATE,
    RESISTANCE,
    SAMPLE_TIME,
    ObserverDrive,
    bench,
    bench_time,
    course,
    observed_drive,
    parameters,
    rms,
    to_and_fro,
    with_true,
)
from tierod_lab.papers.motor_angle.fault_trials import fast_drive, salient_drive, salient_monitor
from tierod_lab.papers.motor_angle.observers import FeedforwardAngle, extended_kalman, luenberger, reduced_luenberger
from tierod_lab.studies.metrics import Row


@dataclass(frozen=True)
class Drawn:
    """A motor on a bench."""

    machine: Machine  # true parameters of the motor
    temperature: float  # temperature of winding and magnets [K]
    seed: int  # seed of the draw

    @property
    def plant(self) -> MotorBench:
        """The bench with this motor; its control assumes the motor of the vehicle file."""
        usual = bench(self.temperature)
        return replace(usual, motor=replace(usual.motor, machine=self.machine))

    def driven(self, seed: int, seconds: float = 10.0) -> ObserverDrive:
        """Simulate a drive in both directions against a spring."""
        time = bench_time(seconds)
        return observed_drive(self.plant, course(time, seed), np.zeros(len(time)), seed)


def drawn(seed: int) -> Drawn:
    """Draw a motor around that of the vehicle file: electrical parameters by some 10 %, mechanical ones by 20 %."""
    random = np.random.default_rng([seed, 11])
    usual = bench().motor.machine
    inductance = usual.inductance_d * np.exp(0.1 * random.normal())
    machine = replace(
        usual,
        resistance=usual.resistance * float(np.exp(0.1 * random.normal())),
        inductance_d=float(inductance),
        inductance_q=float(inductance),
        flux=usual.flux * float(np.exp(0.04 * random.normal())),
        inertia=usual.inertia * float(np.exp(0.2 * random.normal())),
        damping=usual.damping * float(np.exp(0.2 * random.normal())),
        friction=usual.friction * float(np.exp(0.3 * random.normal())),
        dahl_angle=usual.dahl_angle * float(np.exp(0.2 * random.normal())),
    )
    return Drawn(machine, 293.15 + random.uniform(-30.0, 60.0), seed)


def recording(seen: ObserverDrive, temperature: float | None = None) -> Recording:
    """The drive as a recording of a user, with the temperature of the winding where its motor has that sensor [K]."""
    columns = dict(zip(MotorAngleObserver.Sample._fields, seen.samples.T, strict=True))
    units = {"current": "A", "voltage": "V", "angle": "rad"}
    channels = {
        name: Channel(name, seen.time, values, units[name.split("_")[1]], name) for name, values in columns.items()
    }
    if temperature is not None:
        constant = np.full(len(seen.time), temperature)
        channels["motor_temperature"] = Channel("motor_temperature", seen.time, constant, "K", "motor_temperature")
    return Recording(channels)


def parameter_errors(motor: Drawn, found: MotorIdentification) -> list[Row]:
    """Relative error and standard deviation of every identified parameter, and whether its 95 % interval holds."""
    m, electrical, mechanical = motor.machine, found.electrical, found.mechanical
    pairs = {
        "motor_resistance": (electrical.resistance, m.resistance),
        "motor_inductance": (electrical.inductance, m.inductance_q),
        "motor_flux": (electrical.flux, float(flux_at(motor.temperature, m.flux))),
    }
    if mechanical is not None:
        pairs |= {
            "motor_inertia": (mechanical.inertia, m.inertia),
            "motor_damping": (mechanical.damping, m.damping),
            "motor_friction": (mechanical.friction, m.friction),
            "motor_friction_stiffness": (mechanical.stiffness, m.friction / m.dahl_angle),
        }
    return [
        {
            "parameter": name,
            "error": each.value / true - 1.0,
            "deviation": each.deviation / true,
            "covered": abs(each.value - true) <= 1.96 * each.deviation,
        }
        for name, (each, true) in pairs.items()
    ]


PAPER: dict[str, Callable[..., Block]] = {
    "Luenberger": luenberger,
    "reduced Luenberger": reduced_luenberger,
    "Kalman filter": extended_kalman,
}
CAR = "active-front-steering"  # Name of the car, and of its vehicle file
FAST, HELD = (18.0, 20.5), (22.2, 27.8)
"""Intervals of the parking manoeuvre: steering from lock to lock, and holding near a lock [s]."""


def methods(vehicle: str = "motor-bench") -> dict[str, Block]:
    """All compared observers of a vehicle's motor by name."""
    dq, fixed = parameters(vehicle)
    found: dict[str, Block] = {}
    for name, make in PAPER.items():
        found[f"{name}, as printed"] = make(dq, SAMPLE_TIME, load=False)
        found[f"{name}, with load"] = make(dq, SAMPLE_TIME)
    return found | {"feedforward, as printed": FeedforwardAngle(fixed), "default": MotorAngleObserver(fixed)}


def _errors(away: np.ndarray, **named: str | float) -> Row:
    return {**named, "rms": rms(away), "most": float(np.abs(away).max())}


def fast(task: tuple[int, float]) -> list[Row]:
    """The feedforward (46) at constant speeds, with minus L di/dt; the error is taken modulo an electrical turn."""
    seed, speed = task
    p, fixed = parameters()
    time = np.arange(2000) * 1e-3
    seen = observed_drive(bench(stiffness=0.0), speed * time, np.zeros(len(time)), seed)
    away = p.motor_pole_pairs * seen.error(FeedforwardAngle(fixed))[-10_000:]
    return [{"speed": speed, "error": rms(np.angle(np.exp(1j * away)))}]


PRINTED_PRODUCTS = {"Luenberger": 19, "reduced Luenberger": 24, "Kalman filter": 115, "feedforward": 7}
"""Multiplications of Reinelt et al., Table 1."""


def operations(task: None) -> list[Row]:
    """Multiplications of one step, from the stator's axes to the angle, counted from the traced graph.

    Each observer begins at the sensor's angle and carries on while samples are missing, besides what the paper counts.
    """
    dq, fixed = parameters()
    blocks = {name: make(dq, SAMPLE_TIME, load=False) for name, make in PAPER.items()}
    blocks["feedforward"] = FeedforwardAngle(fixed)
    rows: list[Row] = []
    for name, printed in PRINTED_PRODUCTS.items():
        count = operation_count(blocks[name]).multiplications
        rows.append({"observer": name, "printed": printed, "observed": count, "over_printed": count / printed})
    return rows


class CarDrive(NamedTuple):
    """A drive of the car, with the truth every ten milliseconds."""

    samples: np.ndarray  # signals of `MotorAngleObserver.Sample` at `RATE`, (n, 5)
    places: np.ndarray  # indices of the samples with a true value, (m,)
    angle: np.ndarray  # true angle of the motor shaft [rad], (m,)

    @property
    def time(self) -> np.ndarray:
        """Time of the true values from the first sample [s]."""
        return self.places / RATE

    def error(self, observer: Block) -> np.ndarray:
        """Error of an observer's angle at the samples with a true value [rad]."""
        return np.asarray(scan(observer, self.samples)["motor_angle"][self.places] - self.angle)


@lru_cache(maxsize=4)
def car_drive(course: str, seconds: float, seed: int) -> CarDrive:
    """Simulate a drive with the sensors of a production car, with the motor angle sampled at `RATE`."""
    sensors = SensorSet.production()
    angle = replace(dict(sensors.items())["motor_angle_mechanical"], rate=RATE)
    sensors = sensors.with_sensors({"motor_angle_mechanical": angle})
    channels = run(catalogue.load(CAR).block, courses.load(course), seconds, seed, sensors).recording.channels
    samples = np.column_stack([channels[name].values for name in MotorAngleObserver.Sample._fields])
    truth = channels["truth_motor_angle_mechanical"]
    places = np.round(truth.time * RATE).astype(int)
    # A last true value may lie beyond the last sample of the observer.
    kept = places < len(samples)
    return CarDrive(samples, places[kept], truth.values[kept])


def in_the_car(task: tuple[str, float, int]) -> list[Row]:
    """A virtual car with active front steering drives a slalom and parks, with the noise of a production car's sensors.

    The methods are as printed, their misprints corrected. The gear loads the motor all the time, so that observers
    without load lose the angle at once. Lost: over 5.6 s near the lock, under holding torque.
    """
    seen = car_drive(*task)
    rows: list[Row] = []
    for name, observer in methods(CAR).items():
        away = seen.error(observer)
        ends = [
            away[(seen.time >= edge) & (seen.time < edge + 0.5)].mean() if seen.time[-1] > HELD[1] else np.nan
            for edge in (HELD[0], HELD[1] - 0.5)
        ]
        method, _, kind = name.partition(", ")
        row = _errors(away, course=task[0], observer=name, method=method, kind=kind)
        rows.append({**row, "lost": abs(float(ends[1] - ends[0]))})
    return rows


RAMP, COLD, HOT, ZERO = 60.0, -40.0, 120.0, 273.15
"""Duration of a temperature ramp [s], its ends [degree Celsius], and the zero of that scale [K]."""


class Case(NamedTuple):
    """A drive of the default observer: "drawn", or from a first to a last temperature [degree Celsius]."""

    kind: str
    seed: int
    seconds: float
    first: float = 20.0
    last: float = 20.0


def accuracy(case: Case) -> list[Row]:
    """The default observer under load, on motors that differ from its vehicle file.

    Drawn: resistance, flux and inductance are 0.8 to 1.3, 0.94 to 1.02 and 0.93 to 1.07 times the assumed ones. At a
    temperature, resistance and flux follow it; a ramp goes from -40 to 120 °C within a minute.
    """
    p, seed, seconds = parameters()[1], case.seed, case.seconds
    if case.kind == "drawn":
        random = np.random.default_rng([seed, 13])
        factors = [random.uniform(*span) for span in (RESISTANCE, FLUX, INDUCTANCE)]
        seen, p = to_and_fro(seed, seconds), with_true(p, *factors)
    elif case.first == case.last:
        seen = to_and_fro(seed, seconds, ZERO + case.first)
    else:
        seen = _ramp(seed, case.first, case.last)
    name = case.kind if case.kind == "drawn" else " to ".join(f"{each:g}" for each in {case.first: 0, case.last: 0})
    return [_errors(seen.error(MotorAngleObserver(p)), kind=case.kind, case=name)]


def _ramp(seed: int, first: float, last: float) -> ObserverDrive:
    time = bench_time(RAMP)
    # Small heat capacities let winding and magnets follow the temperature of the air without delay.
    light = Warming(1.0, 1.0, 20.0, 20.0, ambient_temperature=ZERO + first)
    path = "motor.warming.ambient_temperature"
    plant = Varied(MotorBench(motor=replace(AFS_MOTOR, warming=light)), (path,))
    air = ZERO + first + (last - first) * time / RAMP
    return observed_drive(plant, course(time, seed), np.zeros(len(time)), seed, **{f"parameters.{path}": air})


def salient(task: tuple[float, int, bool]) -> list[Row]:
    """Motors with more inductance across the flux than along it, under a load that steps by up to 1.6 N·m.

    Fast drives turn at up to 165 rad/s on 11 V, where the drive weakens the flux.
    """
    ratio, seed, quick = task
    seen = (fast_drive if quick else salient_drive)(ratio, seed, 20.0)
    away = scan(salient_monitor(ratio), seen.samples)["estimate.motor_angle"] - seen.angle
    return [_errors(away[round(2.0 * RATE) :], ratio=ratio, fast=float(quick))]


def identified(seed: int) -> list[Row]:
    """Motors with drawn parameters and temperatures, each identified from a drive of 10 s against an unrecorded spring.

    The noise is 0.15 A, 0.03 V and 0.0005 rad at 10 kHz.
    """
    motor, known = drawn(seed), load("motor-bench").parameters_for(MotorParameters)
    return parameter_errors(motor, identify_motor(known, {"drive": recording(motor.driven(seed), motor.temperature)}))
