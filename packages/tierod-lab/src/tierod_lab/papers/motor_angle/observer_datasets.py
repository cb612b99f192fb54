"""Errors of the observers on the bench and in the car, and what a step of them costs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import scan
from tierod.core.graph.analysis import operation_count
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.pm_motor import back_emf_constant, torque_constant
from tierod_lab.ground import courses
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.papers.motor_angle.back_emf import FeedforwardAngle, FeedforwardWithLoad, FluxObserver
from tierod_lab.papers.motor_angle.bare_observers import BareFeedforward, BareLuenberger, BareReduced
from tierod_lab.papers.motor_angle.bench import (
    RATE,
    SAMPLE_TIME,
    SUBSTEPS,
    ObserverDrive,
    bench,
    locked,
    observed_drive,
    parameters,
    rms,
    to_and_fro,
)
from tierod_lab.papers.motor_angle.dq_motor import q_axis_motor, with_load
from tierod_lab.papers.motor_angle.observers import (
    FULL_POLES,
    LOAD_POLE,
    REDUCED_POLES,
    extended_kalman,
    full_observer,
    luenberger,
    reduced_luenberger,
    reduced_observer,
    speed_per_load,
)
from tierod_lab.studies.metrics import Row

PAPER: dict[str, Callable[..., Block]] = {
    "Luenberger": luenberger,
    "reduced Luenberger": reduced_luenberger,
    "Kalman filter": extended_kalman,
}
CAR = "active-front-steering"  # Name of the car, and of its vehicle file
FAST, HELD = (18.0, 20.5), (22.2, 27.8)
"""Intervals of the parking manoeuvre: steering from lock to lock, and holding near a lock [s]."""
LEVELS = (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6)  # Levels of the load, besides the dry friction [N*m]
LEVEL_STEPS = 500  # Steps of the bench at every level, of which the second half is in steady state
WARMER = 1.2  # True resistance over the assumed one: a winding that is some 50 K warmer


def methods(vehicle: str = "motor-bench") -> dict[str, Block]:
    """All compared observers of a vehicle's motor by name."""
    dq, fixed = parameters(vehicle)
    found: dict[str, Block] = {}
    for name, make in PAPER.items():
        found[f"{name}, as printed"] = make(dq, SAMPLE_TIME, load=False, axes="measured")
        found[f"{name}, with load"] = make(dq, SAMPLE_TIME, axes="measured")
    found["feedforward, held when slow"] = FeedforwardAngle(fixed)
    found["feedforward, increments, with load"] = FeedforwardWithLoad.of(fixed, slow="increments")
    found["flux observer"] = FluxObserver(fixed)
    found["default"] = MotorAngleObserver(fixed)
    return found


def beside(task: tuple[int, float]) -> list[Row]:
    """Four methods of the paper, a flux observer of today's drives and the default of tierod, sampled at 10 kHz.

    The bench turns to and fro against a spring, at up to 115 rad/s and 0.9 N·m. The paper's observers estimate a speed
    and integrate it from the sensor's first angle; Park's transform turns by the measured angle, as printed.
    """
    seen = to_and_fro(*task)
    return [
        {"observer": name, "rms": rms(away), "most": float(np.abs(away).max())}
        for name, away in ((name, seen.error(each)) for name, each in methods().items())
    ]


def loaded(seed: int) -> list[Row]:
    """The paper's observers leave out the load, so that the balance of torques gives them the speed.

    In steady state the error follows from the gains. Seven levels of load act at 40 rad/s; and a motor of a winding
    that is 20 % warmer than known is held still by a torque (Figure 7).
    """
    p = parameters()[0]
    true, printed = q_axis_motor(p), q_axis_motor(p, "printed")
    both = with_load(true, p.motor_inertia)
    cases: dict[str, tuple[Block, float]] = {
        "full": (_loaded(luenberger, load=False), speed_per_load(full_observer(true, FULL_POLES), true, p)),
        "full, torque constant as printed": (
            _loaded(luenberger, load=False, torque_constant="printed"),
            speed_per_load(full_observer(printed, FULL_POLES), true, p),
        ),
        "reduced": (
            _loaded(reduced_luenberger, load=False),
            speed_per_load(reduced_observer(true, REDUCED_POLES), true, p),
        ),
        "Kalman filter": (_loaded(extended_kalman, load=False), math.nan),
        "full, with load": (
            _loaded(luenberger),
            speed_per_load(full_observer(both, (*FULL_POLES, LOAD_POLE)), true, p),
        ),
        "reduced, with load": (
            _loaded(reduced_luenberger),
            speed_per_load(reduced_observer(both, (*REDUCED_POLES, LOAD_POLE)), true, p),
        ),
        "Kalman filter, with load": (_loaded(extended_kalman), math.nan),
    }
    seen = stepped(seed)
    rows = [
        _against(name, float(np.polyfit(*settled(observer, seen), 1)[0]), predicted)
        for name, (observer, predicted) in cases.items()
    ]
    torque = 0.6
    still = locked(bench(), np.full(1000, torque), seed)
    colder = luenberger(replace(p, motor_resistance=p.motor_resistance / WARMER), SAMPLE_TIME, axes="measured")
    estimated = float(still.observed(colder)["motor_speed"][5000:].mean())
    current = torque / torque_constant(p.motor_pole_pairs, p.motor_flux)
    missing = p.motor_resistance * (1.0 - 1.0 / WARMER)
    emf = back_emf_constant(p.motor_pole_pairs, p.motor_flux)
    return [*rows, _against("held still", estimated, missing * current / emf)]


def _loaded(make: Callable[..., Block], **more: object) -> Block:
    return make(parameters()[0], SAMPLE_TIME, axes="measured", **more)


def _against(name: str, measured: float, predicted: float) -> Row:
    miss = abs(measured / predicted - 1.0) if abs(predicted) > 0.1 else math.nan
    return {"observer": name, "measured": measured, "predicted": predicted, "size": abs(measured), "miss": miss}


def stepped(seed: int) -> ObserverDrive:
    """A drive of the bench at one speed, with a step of the load every half second."""
    time = np.arange(LEVEL_STEPS * len(LEVELS)) * SUBSTEPS * SAMPLE_TIME
    return observed_drive(bench(stiffness=0.0), 40.0 * time, np.repeat(LEVELS, LEVEL_STEPS), seed)


def settled(observer: Block, seen: ObserverDrive) -> tuple[np.ndarray, np.ndarray]:
    """Mean load [N*m] and mean speed error, true less estimated [rad/s], in steady state at every level."""
    wrong = seen.speed - seen.observed(observer)["motor_speed"]
    halves = [each.reshape(len(LEVELS), -1) for each in (seen.load, wrong)]
    load, away = (each[:, each.shape[1] // 2 :].mean(axis=1) for each in halves)
    return load, away


def fast(task: tuple[int, float]) -> list[Row]:
    """The feedforward (46) at constant speeds, with minus L di/dt and with plus as printed.

    Its quotient gives the angle within half an electrical turn, so that the error is taken modulo that. With the sign
    as printed the angle turns by atan(2 L i/psi); at 12 A both are compared.
    """
    seed, speed = task
    p, fixed = parameters()
    time = np.arange(2000) * 1e-3
    seen = observed_drive(bench(stiffness=0.0), speed * time, np.zeros(len(time)), seed)
    away = p.motor_pole_pairs * seen.error(FeedforwardAngle(fixed))[-10_000:]
    current = 12.0
    torque = torque_constant(p.motor_pole_pairs, p.motor_flux) * current - p.motor_damping * speed
    plant = bench(stiffness=0.0)
    held = observed_drive(plant, speed * time, np.full(len(time), torque - plant.motor.machine.friction), seed)
    ends = [
        held.observed(FeedforwardAngle(fixed, reading=reading))["motor_angle"][-5000:]
        for reading in ("printed", "corrected")
    ]
    turned = float(abs(np.angle(np.exp(2j * p.motor_pole_pairs * np.mean(ends[0] - ends[1]))) / 2.0))
    predicted = math.atan(2.0 * p.motor_inductance * current / p.motor_flux)
    error = rms(np.angle(np.exp(2j * away)) / 2.0)
    return [{"speed": speed, "error": error, "turned": turned, "miss": abs(turned / predicted - 1.0)}]


PRINTED_PRODUCTS = {"Luenberger": 19, "reduced Luenberger": 24, "Kalman filter": 115, "feedforward": 7}
"""Multiplications of Reinelt et al., Table 1."""


def operations(task: None) -> list[Row]:
    """Multiplications and divisions of one step, from the stator's axes to the angle, counted from the traced graph.

    The bare equations, by Euler's method with both Park transforms, neither begin nor miss samples.
    """
    dq, fixed = parameters()
    observers: dict[str, Block] = {
        name: make(dq, SAMPLE_TIME, load=False, axes="measured") for name, make in PAPER.items()
    }
    observers["feedforward"] = FeedforwardAngle(fixed)
    bare: dict[str, Block] = {"Luenberger": BareLuenberger(), "reduced Luenberger": BareReduced()}
    bare["feedforward"] = BareFeedforward()
    most = max(operation_count(observers[name]).multiplications for name in bare)
    rows: list[Row] = []
    for name, observer in observers.items():
        count = operation_count(observer)
        row: dict[str, float | str | bool] = {
            "observer": name,
            "printed": PRINTED_PRODUCTS[name],
            "observed": count.multiplications,
            "over_others": count.multiplications / most,
        }
        if name in bare:
            alone = operation_count(bare[name])
            products = alone.multiplications + alone.divisions
            row |= {"bare": products, "away": abs(products - PRINTED_PRODUCTS[name])}
        rows.append(row)
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
            away[(seen.time >= edge) & (seen.time < edge + 0.5)].mean() if seen.time[-1] > HELD[1] else math.nan
            for edge in (HELD[0], HELD[1] - 0.5)
        ]
        method, _, kind = name.partition(", ")
        rows.append(
            {
                "course": task[0],
                "observer": name,
                "method": method,
                "kind": kind,
                "rms": rms(away),
                "most": float(np.abs(away).max()),
                "lost": abs(ends[1] - ends[0]),
            }
        )
    return rows
