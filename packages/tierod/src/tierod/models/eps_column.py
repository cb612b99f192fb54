"""The column of an electric power steering, referred to the steering wheel axis."""

from __future__ import annotations

from typing import Protocol

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, exp
from tierod.physics.lag import share_reached
from tierod.physics.steering_ratio import column_torque_of_motor, torque_at_steering_wheel


class SteeringRatios(Protocol):
    """Parameters with the ratios between column, motor and kingpins."""

    @property
    def motor_ratio(self) -> float:
        """Turns of the motor per turn of the column [-]."""

    @property
    def steering_ratio(self) -> float:
        """Angle of the road wheels per angle of the column [-]."""


class SampledColumn(Protocol):
    """Parameters with inertia and damping of the column, and the sampling interval."""

    @property
    def sample_time(self) -> float:
        """Sampling interval [s]."""

    @property
    def column_damping(self) -> float:
        """Viscous damping at the steering wheel axis [N m s/rad]."""

    @property
    def column_inertia(self) -> float:
        """Moment of inertia at the steering wheel axis [kg m^2]."""


def driving_torque(
    driver_torque: Number, motor_torque: Number, self_aligning_torque: Number, p: SteeringRatios
) -> Number:
    """Torque on the column without friction and damping [N m]: T_d + n T_m - rho M_z of eq (2).

    Args:
        driver_torque: at the steering wheel [N m]
        motor_torque: at the motor shaft [N m]
        self_aligning_torque: about the kingpins, resisting [N m]
    """
    driven = driver_torque + column_torque_of_motor(motor_torque, p.motor_ratio)
    return driven - torque_at_steering_wheel(self_aligning_torque, p.steering_ratio)


def column_after(angle: Scalar, rate: Scalar, net_torque: Scalar, p: SampledColumn) -> tuple[Scalar, Scalar]:
    """Angle [rad] and rate [rad/s] of the steering wheel after one sample.

    Args:
        angle: of the steering wheel [rad]
        rate: of the steering wheel [rad/s]
        net_torque: on the column without damping, constant over the sample: `driving_torque` less dry friction [N m]
        p: anything with sample_time, column_damping and column_inertia

    Source: Mohtat et al., first two rows of eq (7); the angle is integrated by Euler's method as printed.
    """
    decay, gain = rate_hold(p.sample_time, p.column_damping, p.column_inertia)
    return angle + p.sample_time * rate, decay * rate + gain * net_torque


def rate_hold(sample_time: Scalar, damping: Scalar, inertia: Scalar) -> tuple[Scalar, Scalar]:
    """Decay of the rate over one sample, and rate gained per constant torque.

    Args:
        sample_time: dt [s]
        damping: B_eq [N m s/rad], greater than zero
        inertia: J_eq [kg m^2]

    Returns:
        (a, beta): a = exp(-dt B/J) [-], beta = (1 - a)/B [rad/s/(N m)]; beta is exact and contains dt

    Source: Mohtat et al., eqs (7) to (9), re-derived; `share_reached` keeps beta accurate for small dt B/J.
    """
    elapsed = sample_time * damping / inertia
    return exp(-elapsed), share_reached(elapsed) / damping
