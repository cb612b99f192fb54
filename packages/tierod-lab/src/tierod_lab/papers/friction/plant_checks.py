"""Checks of the virtual car: closed forms, energy."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple, TypeVar

import numpy as np

from tierod.core.block import Scalar
from tierod.core.graph import scan
from tierod.physics.gravity import GRAVITY
from tierod.physics.single_track import steady_yaw_gain
from tierod_lab.ground.chassis import SingleTrack
from tierod_lab.ground.chassis.two_track import TwoTrack, TwoTrackMotion
from tierod_lab.ground.integration import rosenbrock
from tierod_lab.ground.parts import Reaction, Road, Steer, Wheels, Wind
from tierod_lab.papers.friction.plant_replay import ChassisResponse, Replay


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


STEP = 1e-3
SMALL_STEER = 1e-4
"""Road-wheel angle in the linear range [rad]: at its slip angles brush tyres deviate by less than 0.1 %."""

Body = TypeVar("Body", SingleTrack, TwoTrack)


def courses(steer: np.ndarray, speed: float | np.ndarray) -> np.ndarray:
    """Samples of a replay at 1 kHz on a level road.

    Args:
        steer: road-wheel angle at every millisecond [rad], shape (n,)
        speed: target speed [m/s], a number or shape (n,)
    """
    rate = np.gradient(steer, STEP)
    return np.column_stack(np.broadcast_arrays(steer, rate, speed, 0.0, 0.0))


def steady_turn(chassis: Body, speed: float) -> ChassisResponse:
    """Response of a chassis after 8 s at a speed [m/s] with a small road-wheel angle."""
    inputs = courses(np.full(round(8.0 / STEP), SMALL_STEER), speed)
    return scan(Replay(chassis, start_speed=speed), inputs).at(-1)


def unresisted(chassis: Body) -> Body:
    """The chassis without air and rolling resistance, as in the closed forms: no wheel needs a drive torque."""
    still = replace(chassis, drag_area=0.0, side_area=0.0)
    if isinstance(still, SingleTrack):
        return replace(still, rolling_coefficient=0.0)
    front, rear = (replace(axle.tyre, rolling_coefficient=0.0) for axle in (still.front, still.rear))
    return still.on_tyres(front, rear)


def yaw_gain_error(chassis: Body, speed: float) -> float:
    """Relative error of the steady-state yaw gain in the linear range against the closed form.

    Args:
        chassis: single-track or two-track chassis, see `unresisted`
        speed: speed [m/s]
    """
    out = steady_turn(chassis, speed)
    closed = steady_yaw_gain(out.speed, chassis.wheelbase, chassis.understeer_gradient)
    return float(out.yaw_rate / SMALL_STEER / closed - 1.0)


def understeer_error(chassis: Body) -> float:
    """Relative error of the understeer gradient in the linear range at 30 m/s against the closed form.

    Args:
        chassis: single-track or two-track chassis, see `unresisted`
    """
    out = steady_turn(chassis, 30.0)
    extra = SMALL_STEER - chassis.wheelbase * out.yaw_rate / out.speed
    return float(extra / out.lateral_acceleration / chassis.understeer_gradient - 1.0)


class Pedals(NamedTuple):
    """Steering and torques of the manoeuvre of the energy balance."""

    steer: Annotated[float, "rad"]
    steer_rate: Annotated[float, "rad/s"]
    drive_torque: Annotated[float, "N*m"]
    brake_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class EnergyAudit:
    """Block with a chassis on a level road without air, with given wheel torques, and its powers as output."""

    chassis: TwoTrack = field(default_factory=TwoTrack)
    start_speed: Annotated[float, "m/s"] = 20.0

    Sample = Pedals

    def init(self) -> TwoTrackMotion:
        return self.chassis.init(self.start_speed)

    def step(self, state: TwoTrackMotion, sample: Pedals) -> tuple[TwoTrackMotion, Powers]:
        steer = Steer(sample.steer, sample.steer, sample.steer_rate, sample.steer_rate)
        road, wind = Road(0.0, 0.0, 0.0, 1.0, 1.0, 1.0), Wind(0.0, 0.0)
        torques = Wheels(sample.drive_torque, sample.drive_torque, 0.0, 0.0)
        brakes = Wheels(sample.brake_torque, sample.brake_torque, sample.brake_torque, sample.brake_torque)

        def slope(motion: tuple[TwoTrackMotion]) -> tuple[TwoTrackMotion]:
            reaction = self.chassis.reaction(motion[0], steer, road, wind)
            return (self.chassis.derivative(motion[0], reaction, torques, brakes),)

        reaction = self.chassis.reaction(state, steer, road, wind)
        (after,) = rosenbrock(slope, (state,), STEP, "", [])
        return after, powers(self.chassis, state, reaction, steer, road, torques, brakes)


def energy_error(chassis: TwoTrack | None = None) -> float:
    """Energy error of a manoeuvre, relative to the energy that its wheels dissipate.

    Ten seconds: accelerating in a weave to the limit of the tyres, then braking in a turn to standstill.
    """
    chassis = replace(chassis or TwoTrack(), drag_area=0.0, side_area=0.0)
    time = np.arange(round(10.0 / STEP)) * STEP
    steer = 0.08 * np.sin(3.0 * time) * np.minimum(time, 1.0)
    drive = np.where(time < 5.0, 400.0, 0.0)
    brake = np.where(time > 6.0, 600.0, 0.0)
    out = scan(EnergyAudit(chassis), np.column_stack([steer, np.gradient(steer, STEP), drive, brake]))
    lost = {name: _integral(out[name]) for name in ("braked", "slipped", "turned", "damped")}
    stored = out["stored"][-1] - out["stored"][0]
    return float(abs(stored - _integral(out["driven"]) + sum(lost.values())) / sum(lost.values()))


def _integral(values: np.ndarray) -> float:
    return float(np.sum(0.5 * (values[1:] + values[:-1])) * STEP)
