"""Position references with exact derivatives, and the motion of the column with which its shaft follows them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar
from tierod.models.steering_column import TwoInertiaParameters


class Reference(NamedTuple):
    """Reference angle and its first four derivatives."""

    angle: Annotated[float, "rad"]
    rate: Annotated[float, "rad/s"]
    acceleration: Annotated[float, "rad/s**2"]
    jerk: Annotated[float, "rad/s**3"]
    snap: Annotated[float, "rad/s**4"]


@dataclass(frozen=True)
class Sweep:
    """Linear sine sweep that fades in from rest."""

    amplitude: Annotated[float, "rad"] = math.radians(30.0)  # amplitude; 30 degrees in the paper
    # start, stop: first and last frequency; equal ones give a plain sine
    start: Annotated[float, "Hz"] = 0.1
    stop: Annotated[float, "Hz"] = 3.0
    duration: Annotated[float, "s"] = 30.0  # duration of the sweep; the frequency stays at `stop` after it
    # time in which the amplitude grows from zero, with four continuous derivatives
    fade: Annotated[float, "s"] = 1.0

    def at(self, time: np.ndarray) -> Reference:
        """The reference at given times [s]; zero at negative times."""
        time = np.asarray(time, float)
        growth = math.tau * (self.stop - self.start) / self.duration
        under = np.minimum(time, self.duration)
        rate = math.tau * self.start + growth * under
        phase = (math.tau * self.start + 0.5 * growth * under) * under + rate * (time - under)
        change = np.where(time < self.duration, growth, 0.0)
        rise, sine = _smooth(time / self.fade, self.fade), _sine(phase, rate, change)
        product = (sum(math.comb(n, k) * rise[k] * sine[n - k] for k in range(n + 1)) for n in range(5))
        return Reference(*(self.amplitude * each for each in product))


def _sine(phase: np.ndarray, rate: np.ndarray, change: np.ndarray) -> list[np.ndarray]:
    s, c = np.sin(phase), np.cos(phase)
    return [
        s,
        rate * c,
        change * c - rate**2 * s,
        -3.0 * change * rate * s - rate**3 * c,
        (rate**4 - 3.0 * change**2) * s - 6.0 * change * rate**2 * c,
    ]


@cache
def _polynomials() -> tuple[np.polynomial.Polynomial, ...]:
    """Polynomial that rises from 0 to 1 with four derivatives that vanish at both ends, and those derivatives."""
    rise = (np.polynomial.Polynomial([0.0, 1.0]) ** 4 * np.polynomial.Polynomial([1.0, -1.0]) ** 4).integ()
    rise = rise / rise(1.0)
    return (rise, *(rise.deriv(order) for order in range(1, 5)))


def _smooth(share: np.ndarray, duration: float) -> list[np.ndarray]:
    inside = (share > 0.0) & (share < 1.0)
    bounded = np.clip(share, 0.0, 1.0)
    values = [polynomial(bounded) / duration**order for order, polynomial in enumerate(_polynomials())]
    return [values[0], *(np.where(inside, value, 0.0) for value in values[1:])]


class ColumnMotion(NamedTuple):
    """Planned motion of a two-inertia column that follows a reference, and the torque for it."""

    # steering_wheel_rate, motor_speed, steering_wheel_angle, motor_angle: the state
    steering_wheel_rate: Annotated[float, "rad/s"]
    motor_speed: Annotated[float, "rad/s"]
    steering_wheel_angle: Annotated[float, "rad"]
    motor_angle: Annotated[float, "rad"]
    motor_torque: Annotated[float, "N*m"]  # torque at the motor shaft, without dry friction and hands


def advanced(reference: Reference, time: Scalar) -> Reference:
    """The reference at a later time [s], short against its periods, by its Taylor series."""
    angle, rate, acceleration, jerk, snap = reference
    half, third = 0.5 * time, time / 3.0
    return Reference(
        angle + time * (rate + half * (acceleration + third * (jerk + 0.5 * half * snap))),
        rate + time * (acceleration + half * (jerk + third * snap)),
        acceleration + time * (jerk + half * snap),
        jerk + time * snap,
        snap,
    )


def motion_for(reference: Reference, column: TwoInertiaParameters, output_stiffness: Scalar) -> ColumnMotion:
    """Motion with which the output shaft follows a reference, hands off.

    The angle y of the steering wheel is the flat output: state and torque follow from it and its derivatives. The angle
    of the shaft is y + (J y'' + beta y')/k, which is inverted as a series up to the fourth derivative of the reference.

    Args:
        output_stiffness: k, stiffness between the steering wheel and the controlled shaft: that of the torsion bar for
            the output of the gear, `column.stiffness` for the angle of the motor [N m/rad]

    Validity: references below a fifth of the wheel's natural frequency on the bar, sqrt(k/J), which is 10 Hz in the
    paper's column; the series neglects (J w^2/k)^2 of the wheel's torque, 1 % at 3 Hz there, 8 % at 5 Hz.
    Source: M. Fliess, J. Levine, P. Martin, P. Rouchon, 1995, doi 10.1080/00207179508921959; Raffone, eqs (12), (13).
    """
    damping, inertia = column.steering_wheel_damping, column.steering_wheel_inertia
    first, second = damping / output_stiffness, inertia / output_stiffness
    r, r1, r2, r3, r4 = reference
    of_two = first * first - second
    of_three = first * (second - of_two)
    of_four = second * second - first * (of_three + first * second)
    angle = r - first * r1 + of_two * r2 + of_three * r3 + of_four * r4
    rate = r1 - first * r2 + of_two * r3 + of_three * r4
    acceleration = r2 - first * r3 + of_two * r4
    jerk = r3 - first * r4
    bar = inertia * acceleration + damping * rate
    bar_rate = inertia * jerk + damping * acceleration
    more = 1.0 / column.stiffness - 1.0 / output_stiffness
    ratio = column.motor_ratio
    speed = ratio * (r1 + more * bar_rate)
    motor_acceleration = ratio * (r2 + more * (inertia * r4 + damping * jerk))
    torque = column.motor_inertia * motor_acceleration + column.motor_damping * speed + bar / ratio
    return ColumnMotion(rate, speed, angle, ratio * (r + more * bar), torque)
