"""Resistances of a moving car: aerodynamic drag, rolling resistance, and dry friction that holds it at rest."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import limit, sqrt

AIR_DENSITY = 1.2  # Density of dry air at 20 degC and 1013 hPa [kg/m**3]


class AirForces(NamedTuple):
    """Aerodynamic forces on a car along and across its body [N], and yaw moment [N*m]."""

    longitudinal: Scalar
    lateral: Scalar
    yaw_moment: Scalar


def air_forces(
    forward: Scalar, sideways: Scalar, drag_area: Scalar, side_area: Scalar, lead: Scalar, density: Scalar = AIR_DENSITY
) -> AirForces:
    """Aerodynamic forces [N] and yaw moment [N*m] at the centre of gravity.

    Args:
        forward: speed of the car through the air, along the body [m/s]
        sideways: the same across the body, to the left [m/s]
        drag_area: drag coefficient times frontal area [m**2], about 0.65
        side_area: slope of the side force coefficient over the flow angle, times frontal area [m**2], about 5
        lead: distance of the side force ahead of the centre of gravity [m]
        density: of the air [kg/m**3]

    Validity: flow angles up to about 25 degrees, the range of measured slopes; without lift and roll moment.
    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 3.1: F = c A rho/2 V^2, with the
    sine of the flow angle in the place of the angle, and drag along the body.
    """
    pressure = 0.5 * density * sqrt(forward * forward + sideways * sideways)
    side = -side_area * pressure * sideways
    return AirForces(-drag_area * pressure * forward, side, lead * side)


def rolling_resistance(load: Scalar, coefficient: Scalar) -> Scalar:
    """Largest force [N] of the rolling resistance; like dry friction, it holds a wheel at rest on a slight grade.

    Args:
        load: vertical load [N]
        coefficient: 0.008 to 0.015 on asphalt [-]

    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 2.1: F = f Fz.
    """
    return coefficient * load


def holding_friction(
    speed: Scalar, driving: Scalar, greatest: Scalar, inertia: Scalar, stopping_time: Scalar
) -> Scalar:
    """Dry friction [N or N*m] that stops a body, then holds it against the driving force, without reversing its motion.

    Args:
        speed: of the body [m/s or rad/s]
        driving: sum of all other forces or torques on it [N or N*m]
        greatest: largest friction of the brake or the bearing, not negative [N or N*m]
        inertia: of the body [kg or kg*m**2]
        stopping_time: time constant with which the remaining speed decays [s]; above half the step of an integration

    Coulomb's law in motion (the largest friction opposes it), equilibrium at rest: while the friction suffices, the
    speed obeys v' = -v/T, so that it decays without a change of sign and nothing creeps. The result is subtracted in a
    balance.
    """
    return limit(driving + inertia / stopping_time * speed, -greatest, greatest)
