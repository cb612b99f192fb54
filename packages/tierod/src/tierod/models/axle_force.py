"""Lateral force of an axle under load transfer and longitudinal force."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import maximum, sin, sqrt
from tierod.physics.magic_formula import magic_angle

LEAST_ACROSS = 0.3
"""Smallest share of the friction that is left for the lateral force under braking [-], so that it stays positive."""


class AxleLoad(NamedTuple):
    """Loads of an axle: vertical force [N], static vertical force [N], and force along the wheels [N]."""

    vertical: Scalar
    static: Scalar
    longitudinal: Scalar


class AxleForce(NamedTuple):
    """Force across the wheels [N], its largest possible value [N], angle inside the Magic Formula [rad]."""

    lateral: Scalar
    greatest: Scalar
    angle: Scalar


def axle_force(
    slip: Scalar, stiffness: Scalar, friction: Scalar, shape: Scalar, load: AxleLoad, growth: Scalar
) -> AxleForce:
    """Lateral force of an axle, and the other fields of `AxleForce`.

    Args:
        slip: tangent of the slip angle, positive where the force is to the left [-]
        stiffness: cornering stiffness at the static load [N/rad]
        friction: peak force over load [-], positive
        shape: C of the Magic Formula [-], above 1; its curvature E is zero
        growth: relative growth of the stiffness per relative growth of the load [-]

    The slip is scaled so that the slope at zero is the stiffness for any friction (similarity); the force along the
    wheels reduces the lateral friction by the friction ellipse.
    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., sections 4.2 and 4.3.
    """
    grip = friction * load.vertical
    used = load.longitudinal / grip
    greatest = grip * sqrt(maximum(1.0 - used * used, LEAST_ACROSS * LEAST_ACROSS))
    slope = stiffness * (1.0 + growth * (load.vertical / load.static - 1.0))
    angle = magic_angle(slope / (shape * greatest) * slip, 0.0)
    return AxleForce(greatest * sin(shape * angle), greatest, angle)
