"""Motors with a data sheet alone: their angle observed from currents and voltages, before and after identification."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tierod.core.content import Heading, Item
from tierod.core.findings import Status
from tierod.methods.identification.motor import identify_motor
from tierod.models.stator_frame_motor import MotorParameters
from tierod.physics.motor import flux_at
from tierod.vehicles import load
from tierod.vehicles.classes import USUAL, rules
from tierod.vehicles.vehicle import Vehicle
from tierod.vehicles.writer import UNKNOWN
from tierod_lab.papers.motor_angle.bench import ObserverDrive, bench
from tierod_lab.papers.motor_angle.drawn_motors import Drawn, recording
from tierod_lab.papers.own_car import brochure
from tierod_lab.papers.own_car.judging import BROCHURE, IDENTIFIED, TRUE, Judged, over
from tierod_lab.papers.own_car.reported import MOTORS as REPORTED
from tierod_lab.papers.own_car.reported import SEEDS
from tierod_lab.papers.own_car.virtual import claims, false_and_cost, pooled, table
from tierod_lab.studies.effort import Effort

MONITOR = "motor-angle"
MOTORS, QUICK_MOTORS = 20, 4  # Number of motors in full and in the quick study
LEARNING, SECONDS = 10.0, 20.0  # Duration of the drive that identifies a motor, and of the judged drive [s]
SETTLED = 1.0  # Warm-up at the start of a drive, in which the estimate is not compared [s]
APART = 100  # Samples from one compared sample to the next: 10 ms
RESIDUAL = "angle_residual_electrical"
ANGLE = "estimated_motor_angle"
"""Traces of the monitor: electrical residual of the sensor, and estimated angle of the shaft [rad]."""
DRAWN = ("resistance", "flux", "inertia", "damping", "friction")
"""Parameters of a machine that are drawn with the spread of its data sheet, besides the inductance."""

TEXT = (
    "Motors of 12 V on a bench, turned to and fro against a spring. A data sheet gives each parameter as far as "
    "`tierod new` takes it to be known: resistance to 15 %, inductance to 8 %, flux to 5 %, inertia to 30 %; winding "
    "and magnets are 10 to 80 degrees warm. A drive of 10 s identifies the motor, another one is judged with the file "
    "before, the file after, and with the true parameters. Angles are electrical.",
)


class UnknownMotor(NamedTuple):
    """A motor and the vehicle files for it."""

    name: str  # name in tables
    truth: Drawn  # the simulated motor on its bench
    brochure: Vehicle  # vehicle file from the data sheet
    true: Vehicle  # the same with the true parameters


def spread(name: str) -> float:
    """Relative standard deviation of a value in a data sheet."""
    rule = rules().get(name)
    if rule is None:
        return UNKNOWN
    return rule.given if rule.given is not None else rule.relative[USUAL]


def drawn(number: int, seed: int) -> UnknownMotor:
    """Draw a motor around the data sheet.

    Args:
        number: number of the motor, from 0
    """
    chance = np.random.default_rng([seed, number, 17])
    usual = bench().motor.machine

    def factor(name: str) -> float:
        return float(np.exp(spread(f"motor_{name}") * chance.standard_normal()))

    found = {name: factor(name) * getattr(usual, name) for name in DRAWN}
    inductance = factor("inductance") * usual.inductance_q
    machine = dataclasses.replace(usual, **found, inductance_d=inductance, inductance_q=inductance)
    truth = Drawn(machine, 293.15 + float(chance.uniform(-10.0, 60.0)), 1000 * (seed % 100_000) + number)
    sheet = _data_sheet(load("motor-bench"))
    values = {f"motor_{name}": getattr(machine, name) for name in ("resistance", "flux", "inertia", "damping")}
    values |= {"motor_inductance": inductance, "motor_flux": float(flux_at(truth.temperature, machine.flux))}
    return UnknownMotor(f"motor {number + 1}", truth, sheet, brochure.with_values(sheet, values))


def _data_sheet(car: Vehicle) -> Vehicle:
    names = (*(f"motor_{name}" for name in DRAWN), "motor_inductance")
    wide = {
        name: dataclasses.replace(car.parameters[name], standard_deviation=spread(name) * car[name])
        for name in names
        if name in car
    }
    return dataclasses.replace(car, parameters={**car.parameters, **wide})


def identified(motor: UnknownMotor) -> Vehicle:
    """Vehicle after `tierod identify motor` on one drive; unchanged where the identification reports a doubt."""
    seen = motor.truth.driven(motor.truth.seed, LEARNING)
    found = identify_motor(motor.brochure.parameters_for(MotorParameters), {"learning": recording(seen)})
    return brochure.identified(motor.brochure, found)


def studied(task: tuple[int, int]) -> list[Judged]:
    """Draw a motor, identify it, and judge another drive with the three vehicle files.

    Args:
        task: number of the motor, and seed of all random numbers
    """
    motor = drawn(*task)
    seen = motor.truth.driven(motor.truth.seed + 500, SECONDS)
    files = {BROCHURE: motor.brochure, IDENTIFIED: identified(motor), TRUE: motor.true}
    return [judged(motor.name, file, vehicle, seen) for file, vehicle in files.items()]


def judged(name: str, file: str, vehicle: Vehicle, seen: ObserverDrive) -> Judged:
    """Judge a fault-free drive by the monitor of the motor angle.

    Args:
        vehicle: its content, with which the drive is judged
    """
    found = over(MONITOR, vehicle, recording(seen), uncertain=True)
    finding, traces = found.diagnosis.findings[0], found.traces
    if finding.status is Status.NOT_TESTABLE or ANGLE not in traces or f"{RESIDUAL}_standard_deviation" not in traces:
        return Judged(name, MONITOR, file, finding.status, finding.headline, 0, 0, 0.0, np.nan)
    pole_pairs = vehicle["motor_pole_pairs"]
    time, angle = traces[ANGLE].time, traces[ANGLE].values
    error = pole_pairs * (angle - np.interp(time, seen.time, seen.angle))
    deviation = traces[f"{RESIDUAL}_standard_deviation"].values
    known = (np.isfinite(error) & np.isfinite(deviation) & (time > time[0] + SETTLED)).nonzero()[0][::APART]
    held = np.abs(error[known]) <= 1.96 * deviation[known]
    squares = float(np.sum(error[known] ** 2))
    return Judged(name, MONITOR, file, finding.status, finding.headline, len(known), int(held.sum()), squares, np.nan)


def items(effort: Effort, seed: int | None = None) -> Iterator[Item]:
    yield Heading("Motors that are not known", TEXT)
    chosen = SEEDS.of(REPORTED, 1)[0] if seed is None else seed
    count = QUICK_MOTORS if effort.quick else MOTORS
    found = effort.made(studied, [(number, chosen) for number in range(count)])
    every = [each for motor in found for each in motor]
    of = {(MONITOR, file): pooled(every, MONITOR, file) for file in (BROCHURE, IDENTIFIED, TRUE)}
    yield table("Motors that are not known", of)
    yield from claims(MONITOR, of)
    yield from false_and_cost(MONITOR, every, of)
