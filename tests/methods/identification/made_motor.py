"""Recordings of motors made from closed forms: currents and angles are given, voltages follow from the flux."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.models.stator_frame_motor import MotorParameters

STEP = 1e-4
FILE = MotorParameters(0.05, 1e-4, 0.0085, 4.0, 1.2e-4, 4e-4)  # What a vehicle file would say


@dataclass(frozen=True)
class MadeMotor:
    """True parameters: resistance [ohm], inductances [H], flux [V s], zero of the sensor, electrical [rad]."""

    resistance: float = 0.055
    inductance_d: float = 1.1e-4
    inductance_q: float = 1.1e-4
    flux: float = 0.009
    zero: float = 0.0

    def recording(self, along, across, angle, seed=1, noise=(0.15, 0.03, 5e-4), **extra) -> Recording:
        """Currents along and across the flux [A] and the shaft's angle [rad], functions of the time, as recorded.

        The voltage over a step is the resistance times the mean current, by Simpson's rule, and what the flux gained.
        """
        time = np.arange(0.0, 5.0, STEP)

        def vectors(at):
            rotor = np.exp(1j * (4.0 * angle(at) + self.zero))
            current = (along(at) + 1j * across(at)) * rotor
            linkage = (self.flux + self.inductance_d * along(at) + 1j * self.inductance_q * across(at)) * rotor
            return current, linkage

        current, linkage = vectors(time)
        before, _ = vectors(time - STEP)
        middle, _ = vectors(time - 0.5 * STEP)
        _, linkage_before = vectors(time - STEP)
        mean = (before + 4.0 * middle + current) / 6.0
        voltage = self.resistance * mean + (linkage - linkage_before) / STEP
        random = np.random.default_rng(seed)

        def noisy(values, deviation):
            return values + deviation * random.normal(size=len(values))

        values = {
            "motor_current_alpha": (noisy(current.real, noise[0]), "A"),
            "motor_current_beta": (noisy(current.imag, noise[0]), "A"),
            "motor_voltage_alpha": (noisy(voltage.real, noise[1]), "V"),
            "motor_voltage_beta": (noisy(voltage.imag, noise[1]), "V"),
            "motor_angle_mechanical": (noisy(angle(time), noise[2]), "rad"),
        }
        values |= {name: (np.full(len(time), value), "K") for name, value in extra.items()}
        return Recording({name: Channel(name, time, each, unit) for name, (each, unit) in values.items()})


def to_and_fro(time):
    """An angle of the shaft [rad]: up to 50 rad/s in both directions."""
    return 8.0 * np.sin(5.0 * time) + 3.0 * np.sin(3.3 * time)


def waving(size, frequency):
    """A current [A] that goes up and down."""
    return lambda time: size * np.sin(2.0 * np.pi * frequency * time + 0.3)


def none(time):
    return np.zeros_like(time)
