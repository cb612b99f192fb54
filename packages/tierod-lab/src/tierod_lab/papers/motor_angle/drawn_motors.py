"""Motors with drawn parameters on a bench, their recordings, and the true values that identification should find."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.methods.identification.motor import MotorIdentification
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.motor import flux_at
from tierod_lab.ground.cars.benches import MotorBench
from tierod_lab.ground.motor import Machine
from tierod_lab.papers.motor_angle.bench import ObserverDrive, bench, bench_time, course, observed_drive
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
