"""Resistances of a moving car: the air, rolling, and dry friction that holds it at rest."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import limit, sqrt

AIR_DENSITY = 1.2
"""At 20 degC and 1013 hPa [kg/m**3]."""


class AirForces(NamedTuple):
    """Forces of the air on a car, in the directions of the body."""

    longitudinal: Scalar
    lateral: Scalar
    yaw_moment: Scalar


def air_forces(
    forward: Scalar, sideways: Scalar, drag_area: Scalar, side_area: Scalar, lead: Scalar, density: Scalar = AIR_DENSITY
) -> AirForces:
    """Forces [N] and yaw moment [N*m] of the air at the centre of gravity.

    Args:
        forward: speed of the car through the air, along the body [m/s]
        sideways: the same across the body, to the left [m/s]
        drag_area: drag coefficient times frontal area [m**2], about 0.65
        side_area: slope of the side force coefficient with the angle of the flow times frontal area [m**2], about 5
        lead: how far ahead of the centre of gravity the side force acts [m]
        density: of the air [kg/m**3]

    Validity: angles of the flow up to about 25 degrees, to which the slope is measured; without lift and roll moment.
    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 3.1: F = c A rho/2 V^2, with the
    sine of the flow angle in the place of the angle, and drag along the body.
    """
    pressure = 0.5 * density * sqrt(forward * forward + sideways * sideways)
    side = -side_area * pressure * sideways
    return AirForces(-drag_area * pressure * forward, side, lead * side)


def rolling_resistance(load: Scalar, coefficient: Scalar) -> Scalar:
    """Greatest force [N] against rolling: dry, so that a wheel on a slight grade stays where it is.

    Args:
        load: vertical load [N]
        coefficient: 0.008 to 0.015 on asphalt [-]

    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 2.1: F = f Fz.
    """
    return coefficient * load


def holding_friction(
    speed: Scalar, driving: Scalar, greatest: Scalar, inertia: Scalar, stopping_time: Scalar
) -> Scalar:
    """Dry friction [N or N*m] that stops motion, then holds against what drives, and never turns motion round.

    Args:
        speed: of what is stopped [m/s or rad/s]
        driving: sum of all other forces or torques on it [N or N*m]
        greatest: friction that the brake or the bearing can give, not negative [N or N*m]
        inertia: of what is stopped [kg or kg*m**2]
        stopping_time: time constant with which the last bit of speed fades [s]; above half the step of an integration

    Coulomb's law for motion (the greatest friction against it), equilibrium for rest: while the friction suffices the
    speed obeys v' = -v/T, so that it fades without change of sign and nothing creeps. The result is subtracted in a
    balance.
    """
    return limit(driving + inertia / stopping_time * speed, -greatest, greatest)
