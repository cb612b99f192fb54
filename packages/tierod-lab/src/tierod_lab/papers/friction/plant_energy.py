"""Energy balance of a chassis: a check of its equations."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.physics.gravity import GRAVITY
from tierod_lab.ground.chassis.two_track import TwoTrack, TwoTrackMotion
from tierod_lab.ground.parts import Reaction, Road, Steer, Wheels


class Powers(NamedTuple):
    """Energy stored in a chassis, and the powers that change it, on a level road without wind.

    Over any time, stored = driven - (braked + slipped + turned + damped). `slipped` includes the energy of the
    carcasses; `turned` is the work of aligning and scrub torques on the yawing body, which steering and contact patches
    share.
    """

    stored: Annotated[Scalar, "J"]
    driven: Annotated[Scalar, "W"]
    braked: Annotated[Scalar, "W"]
    slipped: Annotated[Scalar, "W"]
    turned: Annotated[Scalar, "W"]
    damped: Annotated[Scalar, "W"]


def stored_energy(chassis: TwoTrack, motion: TwoTrackMotion) -> Scalar:
    """Energy of translation, yaw, roll, springs, raised body and wheels [J]."""
    squared = motion.speed * motion.speed + motion.lateral_speed * motion.lateral_speed
    planar = chassis.mass * squared + chassis.yaw_inertia * motion.yaw_rate * motion.yaw_rate
    stiffness = sum(axle.roll_stiffness for axle in (chassis.front, chassis.rear))
    stiffness = stiffness - chassis.mass * GRAVITY * chassis.roll_arm
    roll = chassis.roll_inertia * motion.roll_rate * motion.roll_rate
    roll = roll + stiffness * motion.roll_angle * motion.roll_angle
    wheels = zip(chassis.axles, motion.spins, strict=True)
    return 0.5 * (planar + roll + sum((axle.wheel_inertia * spin * spin for axle, spin in wheels), 0.0))


def powers(
    chassis: TwoTrack,
    motion: TwoTrackMotion,
    reaction: Reaction,
    steer: Steer,
    road: Road,
    torques: Wheels,
    brakes: Wheels,
) -> Powers:
    """Energy and powers at one instant.

    Args:
        chassis: two-track chassis without aerodynamic drag
        motion, reaction: state of motion and reaction at the instant
        steer, road: inputs of this reaction
        torques, brakes: drive and maximum brake torques of every wheel [N*m]
    """
    hubs = chassis.hubs(motion, steer)
    contacts = chassis.contacts(motion, reaction.loads, hubs, road)
    spins_rate = chassis.derivative(motion, reaction, torques, brakes).spins
    driven, braked, slipped, aligning = 0.0, 0.0, 0.0, 0.0
    for axle, hub, patch, spin, rate, torque in zip(
        chassis.axles, hubs, contacts, motion.spins, spins_rate, torques, strict=True
    ):
        driven = driven + torque * spin
        held = torque - axle.tyre.radius * patch.longitudinal_force - axle.wheel_inertia * rate
        braked = braked + held * spin
        slipping = axle.tyre.radius * spin - hub.along
        slipped = slipped + patch.longitudinal_force * slipping - patch.lateral_force * hub.across
        aligning = aligning + patch.trail * patch.lateral_force
    turned = (aligning + reaction.scrub_torque) * motion.yaw_rate
    damping = chassis.front.roll_damping + chassis.rear.roll_damping
    damped = damping * motion.roll_rate * motion.roll_rate
    return Powers(stored_energy(chassis, motion), driven, braked, slipped, turned, damped)
