"""Balance of a stiff rack and its column."""

from __future__ import annotations

from tierod.core.block import Scalar


def column_balance(
    torque: Scalar,
    friction: Scalar,
    tie_rod_force: Scalar,
    angle: Scalar,
    rate: Scalar,
    rack_ratio: Scalar,
    stiffness: Scalar,
    damping: Scalar,
) -> Scalar:
    """Torque that is left to turn column and rack [N*m]: their inertia at the column times its acceleration.

    Args:
        torque: at the column, towards the left [N*m]
        friction: dry friction at the column, with the sign of the rate [N*m]
        tie_rod_force: positive where it opposes a turn to the left [N]
        angle: of the column [rad]
        rate: of the column [rad/s]
        rack_ratio: rack travel per turn of the column [m/rad]
        stiffness: of the rack to its middle [N/m]
        damping: of the rack [N*s/m]

    Validity: below the frequency at which pinion and rack swing against each other (hundreds of hertz).
    Source: Li, Frey, Gauterin, eq (2), both rows added with S = ratio times angle. The first row is printed without the
    ratio before the force of the teeth, which adds newtons to newton metres.
    """
    rack = tie_rod_force + rack_ratio * (stiffness * angle + damping * rate)
    return torque - friction - rack_ratio * rack


def tie_rod_force_of_balance(
    torque: Scalar, friction: Scalar, mass: Scalar, lateral_acceleration: Scalar, per_mass: Scalar, per_torque: Scalar
) -> Scalar:
    """Force of the tie rods [N] as a mix of lateral acceleration and torque.

    Args:
        torque: at the column [N*m]
        friction: dry friction at the column, with the sign of the rate [N*m]
        mass: of the vehicle [kg]
        lateral_acceleration: [m/s**2]
        per_mass: share of mass times acceleration [-]
        per_torque: force per torque [1/m]; up to the inverse of the rack's travel per radian

    Source: Li, Frey, Gauterin, eq (46), whose friction is printed without the sign of the rate.
    """
    return per_mass * mass * lateral_acceleration + per_torque * (torque - friction)
