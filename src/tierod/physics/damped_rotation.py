"""A body that turns against viscous damping under a constant torque, over any time."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import exp, maximum

LEAST_DAMPING = 1e-4
"""Share of its rate that a body loses at least over the time: with less the difference of two near numbers is divided
by next to nothing; it is a ten-thousandth of the rate, which no bearing keeps better in a hundredth of a second."""


class DampedRotation(NamedTuple):
    """What rate and torque make of angle and rate after the time.

    Args:
        kept: rate per rate before [-]
        path: angle per rate before [s]
        rate_per_torque: [rad/(s*N*m)]
        angle_per_torque: [rad/(N*m)]
    """

    kept: Scalar
    path: Scalar
    rate_per_torque: Scalar
    angle_per_torque: Scalar


def damped_rotation(inertia: Scalar, damping: Scalar, time: Scalar) -> DampedRotation:
    """The motion of a damped body under a constant torque, exact.

    Args:
        inertia: [kg*m**2], above zero
        damping: [N*m*s/rad], zero or above
        time: [s], above zero

    Validity: a damping of less than `LEAST_DAMPING` over the time counts as that much.
    Source: solution of inertia * angle'' = torque - damping * angle'.
    """
    damping = maximum(damping, LEAST_DAMPING * inertia / time)
    kept = exp(-damping * time / inertia)
    rate_per_torque = (1.0 - kept) / damping
    path = inertia * rate_per_torque
    return DampedRotation(kept, path, rate_per_torque, (time - path) / damping)
