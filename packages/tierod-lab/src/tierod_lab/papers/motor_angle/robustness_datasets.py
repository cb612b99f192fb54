"""The default observer on motors unlike its vehicle file, from commanded voltages, standing, after a wrong start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.methods.identification.inverter import identify_inverter
from tierod.methods.identification.motor_recording import MotorRecording
from tierod.models.stator_frame_motor import CommandedMotorParameters
from tierod.monitors.motor_angle.evidence import InverterLoss
from tierod.monitors.motor_angle.facts import inverter_remarks
from tierod.monitors.motor_angle.observer import COMMANDED, MotorAngleObserver, MotorAngleTuning
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import MotorBench
from tierod_lab.ground.integration import Varied
from tierod_lab.ground.motor import AFS_MOTOR, Inverter, Warming
from tierod_lab.papers.motor_angle.bench import (
    RATE,
    SAMPLE_TIME,
    SUBSTEPS,
    ObserverDrive,
    bench,
    bench_time,
    course,
    electrical,
    observed_drive,
    of_another_motor,
    parameters,
    rms,
    to_and_fro,
    with_true,
)
from tierod_lab.papers.motor_angle.fault_trials import AlarmWatch, bench_monitor
from tierod_lab.studies.metrics import Row

WARMER = 1.2  # True resistance over the assumed one: a winding that is some 50 K warmer
RAMP, COLD, HOT, ZERO = 60.0, -40.0, 120.0, 273.15
"""Duration of a temperature ramp [s], its ends [degree Celsius], and the zero of that scale [K]."""
CAPACITY = 1.95  # Heat capacity of a winding whose resistance rises by about 40 % in 20 s of the bench's work [J/K]


class Case(NamedTuple):
    """A drive of the default observer: "drawn", "warm", "warm, not learnt", "warming", or a temperature or ramp."""

    kind: str
    seed: int
    seconds: float
    first: float = 20.0
    last: float = 20.0


def accuracy(case: Case) -> list[Row]:
    """The default observer under load, on motors that differ from its vehicle file.

    Drawn: resistance, flux and inductance are 0.8 to 1.3, 0.94 to 1.02 and 0.93 to 1.07 times the assumed ones. Warm:
    the resistance is 20 % above. Warming: it rises by 40 % in the drive, with magnets 4 % weaker and an inductance 10 %
    smaller. At a temperature, resistance and flux follow it; a ramp goes from -40 to 120 °C within a minute.
    """
    observer, seen = _case(case)
    away = seen.error(observer)
    watch = AlarmWatch(bench_monitor())
    samples = np.full((len(seen.angle), len(watch.Sample._fields)), np.nan)
    samples[:, : seen.samples.shape[1]] = seen.samples
    at_temperature = case.kind in ("temperature", "ramp")
    alarmed = at_temperature and bool(scan(watch, samples)["alarmed"][-1])
    name = f"{case.first:g} to {case.last:g} °C" if case.kind == "ramp" else f"{case.first:g} °C"
    return [
        {
            "kind": case.kind,
            "case": name if at_temperature else case.kind,
            "rms": rms(away),
            "most": float(np.abs(away).max()),
            "alarmed": float(alarmed),
        }
    ]


def _case(case: Case) -> tuple[MotorAngleObserver, ObserverDrive]:
    p, seed, seconds = parameters()[1], case.seed, case.seconds
    if case.kind == "drawn":
        return of_another_motor(np.random.default_rng([seed, 13])), to_and_fro(seed, seconds)
    if case.kind == "warm":
        return MotorAngleObserver(with_true(p, WARMER, 1.0, 1.0)), to_and_fro(seed, seconds)
    if case.kind == "warm, not learnt":
        fixed = MotorAngleTuning(first_resistance=1e-6, first_flux=1e-6, resistance_wander=0.0, flux_wander=0.0)
        return MotorAngleObserver(with_true(p, WARMER, 1.0, 1.0), fixed), to_and_fro(seed, seconds)
    if case.kind == "warming":
        return MotorAngleObserver(with_true(p, 1.0, 0.96, 0.9)), warming(seed, seconds)
    if case.kind == "ramp":
        return MotorAngleObserver(p), ramp(seed, case.first, case.last)
    return MotorAngleObserver(p), to_and_fro(seed, seconds, ZERO + case.first)


def warming(seed: int, seconds: float) -> ObserverDrive:
    """Simulate a drive in which the winding warms by some hundred degrees."""
    # The heat capacity scales with the duration, so that the rise is the same in short drives.
    plant = bench()
    heated = Warming(CAPACITY * seconds / 20.0, 1e9, winding_conductance=0.0, ambient_temperature=293.15)
    plant = replace(plant, motor=replace(plant.motor, warming=heated))
    time = bench_time(seconds)
    return observed_drive(plant, course(time, seed), np.zeros(len(time)), seed)


def ramp(seed: int, first: float, last: float) -> ObserverDrive:
    """Simulate a drive in which winding and magnets warm up or cool down, between two temperatures [degree Celsius]."""
    time = bench_time(RAMP)
    # Small heat capacities let winding and magnets follow the temperature of the air without delay.
    light = Warming(1.0, 1.0, 20.0, 20.0, ambient_temperature=ZERO + first)
    path = "motor.warming.ambient_temperature"
    plant = Varied(MotorBench(motor=replace(AFS_MOTOR, warming=light)), (path,))
    air = ZERO + first + (last - first) * time / RAMP
    return observed_drive(plant, course(time, seed), np.zeros(len(time)), seed, **{f"parameters.{path}": air})


LOSSY = Inverter(dead_time=1e-6, forward_drop=0.7, knee_current=1.0)
"""Inverter that takes 0.83 V from every phase, as much as the bench's motor induces at 24 rad/s."""


def commanded(task: tuple[int, int, float]) -> list[Row]:
    """A recording often holds the voltage that was commanded, not the one that the inverter made.

    Dead time and semiconductors take 0.83 V of each phase against its current, less below a knee of 1 A. The observer
    knows the command alone; its states are then the loss and the logarithm of the knee besides.
    """
    other, seed, seconds = task
    seen, learns = (to_and_fro(each, seconds, inverter=LOSSY) for each in (seed, other))
    current, command = (learns.commanded[:, k] + 1j * learns.commanded[:, k + 1] for k in (0, 2))
    recording = MotorRecording("drive", SAMPLE_TIME, learns.time, current, command, learns.samples[:, 4])
    fit = identify_inverter([recording], parameters()[0].motor_pole_pairs)
    held = MotorAngleTuning(first_knee=0.0)
    observers = {
        "measured voltage": (MotorAngleObserver(parameters()[1]), math.nan),
        "command taken for the voltage": (MotorAngleObserver(parameters()[1]), math.nan),
        "loss and knee identified": (_commanded(fit.knee, fit.loss), fit.knee),
        **{f"knee {knee:g} A, learnt": (_commanded(knee), knee) for knee in (0.5, 1.0, 2.0)},
        **{f"knee {knee:g} A, held": (_commanded(knee, tuning=held), knee) for knee in (0.5, 2.0)},
    }
    rows: list[Row] = []
    for name, (observer, knee) in observers.items():
        outputs = scan(observer, seen.samples if name == "measured voltage" else seen.commanded)
        away = outputs["motor_angle"] - seen.angle
        row: dict[str, float | str | bool] = {
            "knows": name,
            "how": name.rpartition(", ")[2],
            "rms": rms(away),
            "most": float(np.abs(away).max()),
        }
        if name.endswith("learnt"):
            last = {each: float(outputs[f"inverter_{each}"][-1]) for each in InverterLoss._fields[:3]}
            lost = InverterLoss(**last, nominal_knee=knee, widest=observer.tuning.widest_knee)
            # The first remark, on commanded voltages, always appears; a second one reports a wrong knee current.
            row["said"] = float(len(inverter_remarks(lost, COMMANDED)) > 1)
        rows.append(row)
    return rows


def _commanded(knee: float, loss: float | None = None, tuning: MotorAngleTuning | None = None) -> MotorAngleObserver:
    known = load("motor-bench").parameters_for(CommandedMotorParameters)
    assumed = known.inverter_voltage_loss if loss is None else loss
    changed = replace(known, sample_time=SAMPLE_TIME, inverter_knee_current=knee, inverter_voltage_loss=assumed)
    return MotorAngleObserver(changed, tuning or MotorAngleTuning())


MOVING, STILL, AFTER = 5.6, 10.0, 5.0
"""Time in which the motor turns, is then held against the load, and turns again [s]."""
WITHIN, KEPT = 0.03, 0.1
"""Settling criterion: error of the angle modulo whole electrical turns [rad], and time it must stay below that [s]."""
BEGUN_SPEED, WATCHED = 1.0, 2.0
"""Speed above which a starting motor counts as turning [rad/s], and time for which it is watched [s]."""


def standstill(seed: int) -> list[Row]:
    """The motor turns, is held against 0.8 N·m for 10 s, and turns on, with the winding as assumed or 20 % warmer.

    Held, its currents show nothing: the observer goes on by the increments of the sensor, and its variance grows. It
    knows its angle again when it claims less than 0.03 rad and is right within.
    """
    seen, p = held_drive(seed), parameters()[1]
    rows: list[Row] = []
    for name, factor in (("as assumed", 1.0), ("20 % warmer", WARMER)):
        found = seen.observed(MotorAngleObserver(with_true(p, factor, 1.0, 1.0)))
        away, deviation = found["motor_angle"] - seen.angle, found["motor_angle_standard_deviation"]
        first, second, last, end = (
            round(each * RATE) for each in (MOVING + 0.5, MOVING + 1.5, MOVING + STILL - 1.0, MOVING + STILL)
        )
        turning = end + int(np.argmax(np.abs(seen.speed[end:]) > BEGUN_SPEED))
        known = (deviation[turning:] < WITHIN) & (np.abs(_within_a_turn(away[turning:])) < WITHIN)
        rows.append(
            {
                "winding": name,
                "drift": abs(float(away[last:end].mean() - away[first:second].mean())),
                "growth": float(deviation[end - 1] / deviation[first]),
                "known_again": 1e3 * time_until_right(~known),
            }
        )
    return rows


def held_drive(seed: int) -> ObserverDrive:
    """Simulate a drive in both directions, a standstill, and the continued drive."""
    time = bench_time(MOVING + STILL + AFTER)
    moving = np.where(time < MOVING + STILL, np.minimum(time, MOVING), time - STILL)
    # A quarter of a period ends where the motor is held, so that it stops at its largest angle.
    rate = 2.0 * np.pi * (0.25 + np.random.default_rng(seed).integers(1, 4)) / MOVING
    target = 10.0 * np.sin(rate * moving) * np.clip(2.0 * time, 0.0, 1.0)
    return observed_drive(bench(), target, np.zeros(len(time)), seed)


def beginnings(task: tuple[str, int, int, Sequence[float]]) -> list[Row]:
    """The sensor is off by a constant when the observer begins, on a motor that differs from the file.

    From rest, the motor then starts one way, and the time counts from 1 rad/s; reversing, it turns the other way within
    a tenth of a second. The time ends where the error stays below 0.03 rad.
    """
    begins, seed, driven, sizes = task
    rows: list[Row] = []
    for size in sizes:
        random = np.random.default_rng([seed, 9])
        seen, start = (_from_rest if begins == "from rest" else _reversing)(seed, driven, random)
        samples = seen.samples.copy()
        samples[:, 4] += size * random.choice((-1.0, 1.0))
        away = _within_a_turn(replace(seen, samples=samples).error(of_another_motor(random)))
        rows.append({"begins": begins, "size": size, "time": time_until_right(np.abs(away[start:]) > WITHIN)})
    return rows


def _from_rest(seed: int, driven: int, random: np.random.Generator) -> tuple[ObserverDrive, int]:
    time = bench_time(WATCHED)
    speed = random.uniform(20.0, 100.0) * random.choice((-1.0, 1.0)) * np.clip((time - 0.3) / 0.05, 0.0, 1.0)
    seen = observed_drive(bench(), np.cumsum(speed) * SUBSTEPS / RATE, np.zeros(len(time)), seed)
    return seen, int(np.argmax(np.abs(seen.speed) > BEGUN_SPEED))


def _reversing(seed: int, driven: int, random: np.random.Generator) -> tuple[ObserverDrive, int]:
    seen, length = to_and_fro(driven, 20.0), round(WATCHED * RATE)
    # A trial begins shortly before a reversal, after a second of the drive and early enough to be watched in full.
    turns = np.flatnonzero(np.diff(np.sign(seen.speed)) != 0.0)
    turns = turns[(turns > RATE) & (turns < len(seen.speed) - length)]
    begin = int(random.choice(turns) - random.integers(0, round(0.1 * RATE)))
    return ObserverDrive(**{name: values[begin : begin + length] for name, values in vars(seen).items()}), 0


def _within_a_turn(angle: np.ndarray) -> np.ndarray:
    """Angle of the shaft modulo whole electrical turns [rad]."""
    return electrical(angle) / parameters()[1].motor_pole_pairs


def time_until_right(wrong: np.ndarray) -> float:
    """Time after which nothing is wrong for `KEPT`; infinite where that never occurs [s]."""
    kept = round(KEPT * RATE)
    summed = np.concatenate([[0], np.cumsum(wrong)])
    good = np.flatnonzero(summed[kept:] == summed[:-kept])
    return float(good[0]) / RATE if len(good) else math.inf
