"""What every state and the motor's torque have to be, for the shaft of a column to follow a reference."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.models.two_inertia_column import TwoInertiaParameters
from tierod.papers.column.control.reference import Reference


class ColumnMotion(NamedTuple):
    """The motion of a column of two inertias that follows a reference, and the torque that it takes.

    Args:
        steering_wheel_rate, motor_speed, steering_wheel_angle, motor_angle: the state
        steering_wheel_acceleration: of the steering wheel
        motor_torque: at its shaft, without what dry friction and hands take
    """

    steering_wheel_rate: Annotated[float, "rad/s"]
    motor_speed: Annotated[float, "rad/s"]
    steering_wheel_angle: Annotated[float, "rad"]
    motor_angle: Annotated[float, "rad"]
    steering_wheel_acceleration: Annotated[float, "rad/s**2"]
    motor_torque: Annotated[float, "N*m"]


def advanced(reference: Reference, time: Any) -> Reference:
    """The reference a little later, by Taylor's series.

    Args:
        reference: now
        time: [s], short against the reference's periods
    """
    angle, rate, acceleration, jerk, snap = reference
    half, third = 0.5 * time, time / 3.0
    return Reference(
        angle + time * (rate + half * (acceleration + third * (jerk + 0.5 * half * snap))),
        rate + time * (acceleration + half * (jerk + third * snap)),
        acceleration + time * (jerk + half * snap),
        jerk + time * snap,
        snap,
    )


def motion_for(reference: Reference, column: TwoInertiaParameters, output_stiffness: Any) -> ColumnMotion:
    """The motion with which the output shaft follows a reference, hands off.

    The angle y of the steering wheel is the flat output: all else follows from it and its derivatives. That of the
    shaft is y + (J y'' + beta y')/k, which is turned round as a series up to the reference's fourth derivative.

    Args:
        reference: of the output shaft
        column: its parameters
        output_stiffness: k, between the steering wheel and the shaft that follows: the torsion bar's for the gear's
            output, `column.stiffness` for the motor's own angle [N m/rad]

    Validity: references below a fifth of the wheel's frequency on the bar, sqrt(k/J), which is 10 Hz in the paper's
    column; the series leaves out (J w^2/k)^2 of the wheel's torque, 1 % at 3 Hz there, 8 % at 5 Hz.
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
    return ColumnMotion(rate, speed, angle, ratio * (r + more * bar), acceleration, torque)
