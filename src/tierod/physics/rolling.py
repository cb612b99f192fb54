"""What resists a rolling wheel, and dry friction that holds what stands."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import limit


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
