"""What carries the body: axles with their wheels, and the geometry of the kingpins."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics.kingpin import scrub_radius_torque, weight_lever, weight_torque
from tierod.proving_ground.chassis.tyres import Tyre
from tierod.proving_ground.chassis.wheel import Contact
from tierod.proving_ground.parts import Wheels


@dataclass(frozen=True)
class Axle:
    """One axle with two wheels alike.

    Args:
        track: distance of the wheels
        roll_centre_height: above ground
        roll_stiffness: of springs and stabiliser, torque per roll angle
        roll_damping: of the dampers, torque per roll rate
        compliance: steer of both wheels per lateral force of the axle, away from the force
        wheel_inertia: of one wheel about its axle, with its share of the drive train
        tyre: on both wheels
    """

    track: Annotated[float, "m", POSITIVE]
    roll_centre_height: Annotated[float, "m"]
    roll_stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE]
    roll_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE]
    compliance: Annotated[float, "rad/N"]
    wheel_inertia: Annotated[float, "kg*m**2", POSITIVE]
    tyre: Tyre = field(default_factory=Tyre)

    def stiffness(self, load: float) -> float:
        """Cornering stiffness of the whole axle at its static load, with its compliance [N/rad]."""
        return 1.0 / (0.5 / self.tyre.stiffness(0.5 * load) + self.compliance)


@dataclass(frozen=True)
class Kingpins:
    """Where the axes lie about which the front wheels turn; typical of a front-driven car.

    Args:
        mechanical_trail: of the contact centre behind the axis, at the ground
        scrub_radius: of the contact centre outside the axis, at the ground
        inclination: of the axis, its upper end inward
    """

    mechanical_trail: Annotated[float, "m"] = 0.025
    scrub_radius: Annotated[float, "m"] = 0.008
    inclination: Annotated[float, "rad"] = 0.20

    def aligning(self, patch: Contact) -> Any:
        """Torque of the lateral force about a kingpin [N*m]."""
        return (self.mechanical_trail + patch.trail) * patch.lateral_force

    def geometry(self, loads: Wheels, hubs: Wheels, contacts: Wheels, wheel_radius: Any) -> tuple[Any, Any]:
        """Torques about the left and the right kingpin from weight, and from forces along the wheels [N*m].

        Args:
            loads: vertical, of every wheel [N]
            hubs: of every wheel
            contacts: of every wheel
            wheel_radius: [m]
        """
        lever = weight_lever(self.scrub_radius, self.inclination, wheel_radius)
        left, right = scrub_radius_torque(
            contacts.front_left.longitudinal_force, contacts.front_right.longitudinal_force, self.scrub_radius
        )
        left = left + weight_torque(loads.front_left, lever, hubs.front_left.sine)
        return left, right + weight_torque(loads.front_right, lever, hubs.front_right.sine)
