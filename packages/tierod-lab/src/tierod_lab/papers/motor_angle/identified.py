"""Motors with drawn parameters, identified from a drive: bias, coverage of intervals, and error of the observer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.experiment import INTERVAL, Found
from tierod.methods.identification.motor import MotorIdentification, identify_motor
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.pm_motor import flux_at
from tierod.vehicles import load
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.motor import Machine
from tierod_lab.papers.motor_angle.fault_drives import bench_time, course
from tierod_lab.papers.motor_angle.observer_drives import SAMPLE_TIME, ObserverDrive, bench, drive, rms
from tierod_lab.papers.motor_angle.reported import IDENTIFIED, SEEDS
from tierod_lab.studies.effort import Effort

_SECONDS = 10.0
"""Duration of the drive that identifies a motor [s]."""
_GOAL = "goal of tierod"


@dataclass(frozen=True)
class Drawn:
    """A motor on a bench.

    Args:
        machine: true parameters of the motor
        temperature: temperature of winding and magnets [K]
        seed: seed of the draw
    """

    machine: Machine
    temperature: float
    seed: int

    @property
    def plant(self) -> MotorBench:
        """The bench with this motor; its control assumes the motor of the vehicle file."""
        usual = bench(self.temperature)
        return replace(usual, motor=replace(usual.motor, machine=self.machine))

    def driven(self, seed: int, seconds: float = _SECONDS) -> ObserverDrive:
        """Simulate a drive in both directions against a spring."""
        time = bench_time(seconds)
        return drive(self.plant, course(time, seed), np.zeros(len(time)), seed)


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
    """The drive as a recording of a user.

    Args:
        seen: the drive
        temperature: temperature of the winding [K]; None for a motor without that sensor
    """
    columns = dict(zip(MotorAngleObserver.Sample._fields, seen.samples.T, strict=True))
    units = {"current": "A", "voltage": "V", "angle": "rad"}
    channels = {
        name: Channel(name, seen.time, values, units[name.split("_")[1]], name) for name, values in columns.items()
    }
    if temperature is not None:
        constant = np.full(len(seen.time), temperature)
        channels["motor_temperature"] = Channel("motor_temperature", seen.time, constant, "K", "motor_temperature")
    return Recording(channels)


def identified(motor: Drawn) -> MotorIdentification:
    """Identify a motor from a recorded drive."""
    parameters = load("motor-bench").parameters_for(MotorParameters)
    return identify_motor(parameters, {"drive": recording(motor.driven(motor.seed), motor.temperature)})


class Errors(NamedTuple):
    """Identification results of one parameter over many motors, relative to the true values.

    Args:
        errors: identified less true values, (motors,)
        deviations: stated standard deviations, (motors,)
    """

    errors: np.ndarray
    deviations: np.ndarray

    @property
    def covered(self) -> int:
        """Number of motors whose true value lies in the 95 % interval."""
        return int(np.count_nonzero(np.abs(self.errors) <= INTERVAL * self.deviations))


def errors(motors: list[Drawn], found: list[MotorIdentification]) -> dict[str, Errors]:
    """Identification results of all motors by parameter, electrical ones without the uncertainty by temperature."""
    rows: dict[str, list[tuple[float, float]]] = {}
    for motor, result in zip(motors, found, strict=True):
        m, electrical, mechanical = motor.machine, result.electrical, result.mechanical
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
        for name, (each, true) in pairs.items():
            rows.setdefault(name, []).append((each.value / true - 1.0, each.deviation / true))
    return {name: Errors(*np.array(each).T) for name, each in rows.items()}


def _angle_errors(task: tuple[Drawn, tuple[Found, ...], float]) -> tuple[float, float, float]:
    """Rms angle errors of the default observer on another drive [rad]: identified, true and vehicle file parameters."""
    motor, parameters, seconds = task
    seen = motor.driven(motor.seed + 5000, seconds)
    usual, m = load("motor-bench").parameters_for(SampledMotorParameters), motor.machine
    usual = replace(usual, sample_time=SAMPLE_TIME)
    known = {each.name: each.value for each in parameters if hasattr(usual, each.name)}
    true = replace(
        usual,
        motor_resistance=m.resistance,
        motor_inductance=m.inductance_q,
        motor_flux=m.flux,
        motor_inertia=m.inertia,
        motor_damping=m.damping,
    )
    sets = (replace(usual, **known), true, usual)
    found, best, without = (rms(seen.error(MotorAngleObserver(each))) for each in sets)
    return found, best, without


def items(effort: Effort) -> Iterator[Item]:
    count = 4 if effort.quick else 50
    motors = [drawn(seed) for seed in SEEDS.of(IDENTIFIED, count)]
    found = effort.made(identified, motors)
    table = errors(motors, found)
    yield Heading(
        "Parameters from a drive",
        (
            f"{count} motors with drawn parameters and temperatures, each identified from one drive of {_SECONDS:g} s "
            "to and fro against an unrecorded spring, with noise of 0.15 A, 0.03 V and 0.0005 rad at 10 kHz. "
            "Resistance at 20 degrees, flux as warm as the magnets were.",
        ),
    )
    rows = tuple(
        (
            name,
            f"{100.0 * each.errors.mean():+.3f} %".replace("-", "−"),
            f"{100.0 * np.std(each.errors):.3f} %",
            f"{100.0 * np.mean(each.deviations):.3f} %",
            f"{each.covered} of {count}",
        )
        for name, each in table.items()
    )
    header = ("parameter", "mean error", "standard deviation", "claimed", "true value in the 95 % interval")
    yield Table("Found less true, in parts of the true value", header, rows)
    yield from _claims(table, count, effort.quick)
    yield from _observer(motors, found, effort)


def _claims(table: dict[str, Errors], count: int, quick: bool) -> Iterator[Item]:
    least = min(table.values(), key=lambda each: each.covered)
    yield Claim(
        "identified.intervals",
        "Share of the motors whose true value lies in the 95 % interval, for the parameter for which it is least.",
        _GOAL,
        None,
        None if quick else least.covered / count,
        at_least(0.9),
        "",
        f"{count} motors: too few to judge" if quick else f"{count} motors",
    )
    worst = max(table.values(), key=lambda each: abs(each.errors.mean()))
    yield Claim(
        "identified.bias",
        "Mean error of the parameter for which it is largest, in parts of the true value.",
        _GOAL,
        None,
        abs(float(worst.errors.mean())),
        at_most(0.01),
    )


def _observer(motors: list[Drawn], found: list[MotorIdentification], effort: Effort) -> Iterator[Item]:
    few = 2 if effort.quick else 12
    pairs = list(zip(motors, found, strict=True))[:few]
    seconds = 5.0 if effort.quick else 20.0
    away = np.array(effort.made(_angle_errors, [(motor, result.found, seconds) for motor, result in pairs]))
    median = np.median(away, axis=0)
    rows = tuple(
        (name, f"{median[k]:.3g}", f"{away[:, k].max():.3g}")
        for k, name in enumerate(("identified", "true", "of the vehicle file"))
    )
    yield Table(
        f"Angle of the default observer on another drive of {few} of these motors, rms (rad)",
        ("parameters", "median", "worst"),
        rows,
    )
    yield Claim(
        "identified.observer",
        "Angle error of the default observer with identified parameters over that with true ones, in the median.",
        _GOAL,
        None,
        float(np.median(away[:, 0] / away[:, 1])),
        at_most(1.1),
    )
