"""Load transfer between wheels and between axles under acceleration."""

from __future__ import annotations

from tierod.core.block import Scalar


def lateral_load_transfer(force: Scalar, roll_centre_height: Scalar, roll_torque: Scalar, track: Scalar) -> Scalar:
    """Load [N] that is transferred from the left to the right wheel of an axle.

    Args:
        force: lateral force of the axle's tyres on the body, to the left [N]
        roll_centre_height: of the axle, above ground [m]
        roll_torque: of the axle's springs and dampers, against a roll to the right [N*m]
        track: [m]

    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 23.1: one part through the links at
    once, the other through the springs as the body rolls.
    """
    return (force * roll_centre_height + roll_torque) / track


def longitudinal_load_transfer(force: Scalar, centre_height: Scalar, wheelbase: Scalar) -> Scalar:
    """Load [N] that is transferred from the front to the rear axle.

    Args:
        force: of all tyres along the road, forward [N]
        centre_height: of the centre of gravity, above ground [m]
        wheelbase: [m]
    """
    return force * centre_height / wheelbase
