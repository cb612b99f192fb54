"""Torques about the kingpins from wheel loads and longitudinal forces; positive ones oppose a turn to the left."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import cos, sin


def weight_lever(scrub_radius: Scalar, inclination: Scalar, wheel_radius: Scalar) -> Scalar:
    """Lever [m] of the wheel load in the self-centring torque about the kingpin.

    Args:
        scrub_radius: from the kingpin axis, at the ground, outward to the wheel plane [m]
        inclination: of the kingpin axis, its upper end inward [rad]
        wheel_radius: [m]

    A narrow rigid wheel that turns about an inclined axis lifts the car by rho sin(i) (1 - cos(steer)), where
    rho = s cos(i) + R sin(i) is the distance of the hub from the axis.
    Validity: without caster; the round shoulders of a wide tyre reduce it.
    """
    return (scrub_radius * cos(inclination) + wheel_radius * sin(inclination)) * sin(inclination)


def weight_torque(load: Scalar, lever: Scalar, sine: Scalar) -> Scalar:
    """Torque [N*m] of the wheel load about one kingpin, from the work of lifting the car.

    Args:
        load: of the wheel [N]
        lever: from `weight_lever` [m]
        sine: of the steer [-]
    """
    return load * lever * sine


def scrub_radius_torque(left_force: Scalar, right_force: Scalar, scrub_radius: Scalar) -> tuple[Scalar, Scalar]:
    """Torques [N*m] about the left and right kingpin of drive and brake forces at the ground.

    Args:
        left_force, right_force: of the tyres along their wheels, forward [N]
        scrub_radius: from the kingpin axis, at the ground, outward to the wheel plane [m]

    Validity: brakes and motors inside the wheel, so that their torque acts on the knuckle.
    """
    return scrub_radius * left_force, -scrub_radius * right_force
