"""What an axle does across the road: lateral force, friction it has left, and the pneumatic trail."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.graph.maths import cos, maximum, sqrt
from tierod.physics.magic_formula import magic_angle, magic_formula

LEAST_ACROSS = 0.25
"""Share of the friction that stays for the lateral force whatever the brakes do [-]: keeps the ellipse open."""


class AxleLoad(NamedTuple):
    """What loads an axle: vertical force [N], that force at rest [N], and force along the wheels [N]."""

    vertical: Any
    static: Any
    longitudinal: Any


class AxleForce(NamedTuple):
    """Force across the wheels [N], greatest force that the road lends [N], pneumatic trail [m]."""

    lateral: Any
    greatest: Any
    trail: Any


@dataclass(frozen=True)
class AxleLaw:
    """Shape of an axle's lateral force over slip, of both tyres, compliance and camber together.

    The defaults lie between those of published tyres and stand for no single one.

    Args:
        shape: C of the Magic Formula
        curvature: E of the Magic Formula
        trail_shape: Ct of the pneumatic trail; above one it turns negative where the tyre slides
        stiffness_growth: relative growth of the cornering stiffness per relative growth of the load
    """

    shape: Annotated[float, ""] = 1.3
    curvature: Annotated[float, ""] = 0.0
    trail_shape: Annotated[float, ""] = 1.15
    stiffness_growth: Annotated[float, ""] = 0.6

    def force(self, slip: Any, stiffness: Any, friction: Any, load: AxleLoad, trail: Any) -> AxleForce:
        """Lateral force, its greatest value and the trail.

        Args:
            slip: tangent of the slip angle, positive where the force is to the left [-]
            stiffness: cornering stiffness at the static load [N/rad]
            friction: greatest force over load [-], positive
            load: of the axle
            trail: pneumatic trail without slip [m]

        The slip is scaled so that the slope at zero is the stiffness whatever the friction (similarity); the force
        along the wheels narrows the friction by the ellipse.
        Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., sections 4.2 and 4.3.
        """
        grip = friction * load.vertical
        used = load.longitudinal / grip
        greatest = grip * sqrt(maximum(1.0 - used * used, LEAST_ACROSS * LEAST_ACROSS))
        slope = stiffness * (1.0 + self.stiffness_growth * (load.vertical / load.static - 1.0))
        factor = slope / (self.shape * greatest)
        lateral = magic_formula(slip, factor, self.shape, greatest, self.curvature)
        return AxleForce(lateral, greatest, trail * cos(self.trail_shape * magic_angle(factor * slip, self.curvature)))
