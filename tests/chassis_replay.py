"""A chassis alone, driven by steer and speed, and its closed forms: yaw gain, understeer gradient, energy."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.physics.motion import GRAVITY, steady_yaw_gain
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.integration import rosenbrock
from tierod_lab.ground.parts import Reaction, Road, Steer, Wheels, Wind
from tierod_lab.ground.powertrain import Powertrain

STEP = 1e-3
ROAD, WIND = Road(0.0, 0.0, 0.0, 1.0, 1.0, 1.0), Wind(0.0, 0.0)
SMALL_STEER = 1e-4  # Road-wheel angle in the linear range [rad]: at its slip brush tyres deviate by less than 0.1 %


class Driven(NamedTuple):
    road_wheel_angle: float
    road_wheel_rate: float
    speed: float


@dataclass(frozen=True)
class Replay:
    """Both front road wheels at one angle; a stiff speed controller drives and brakes."""

    chassis: Any = field(default_factory=TwoTrack)
    powertrain: Powertrain = field(default_factory=Powertrain)
    start_speed: float = 20.0

    Sample = Driven

    def init(self):
        return self.chassis.init(self.start_speed)

    def step(self, state, sample):
        steer = Steer(*[sample.road_wheel_angle] * 2, *[sample.road_wheel_rate] * 2)
        first = self.chassis.reaction(state, steer, ROAD, WIND)
        torques, brakes = self.powertrain.torques(32e3 * (sample.speed - first.speed), first)

        def slope(motion):
            reaction = self.chassis.reaction(motion[0], steer, ROAD, WIND)
            return (self.chassis.derivative(motion[0], reaction, torques, brakes),)

        (after,) = rosenbrock(slope, (state,), STEP, "", [])
        return after, first._replace(private=0.0)


def courses(steer: np.ndarray, speed: float | np.ndarray) -> np.ndarray:
    """Samples of a replay at 1 kHz."""
    return np.column_stack(np.broadcast_arrays(steer, np.gradient(steer, STEP), speed))


def unresisted(chassis):
    """The chassis without air and rolling resistance, as in the closed forms: no wheel needs a drive torque."""
    still = replace(chassis, drag_area=0.0, side_area=0.0)
    if isinstance(still, SingleTrack):
        return replace(still, rolling_coefficient=0.0)
    return still.on_tyres(*(replace(axle.tyre, rolling_coefficient=0.0) for axle in (still.front, still.rear)))


def steady_turn(chassis, speed: float) -> Reaction:
    inputs = courses(np.full(round(8.0 / STEP), SMALL_STEER), speed)
    return scan(Replay(chassis, start_speed=speed), inputs).at(-1)


def yaw_gain_error(chassis, speed: float) -> float:
    """Relative error of the steady-state yaw gain in the linear range against the closed form."""
    out = steady_turn(chassis, speed)
    closed = steady_yaw_gain(out.speed, chassis.wheelbase, chassis.understeer_gradient)
    return float(out.yaw_rate / SMALL_STEER / closed - 1.0)


class Powers(NamedTuple):
    """Stored energy [J] and powers [W]: over any time, stored = driven - (braked + slipped + turned + damped)."""

    stored: float
    driven: float
    braked: float
    slipped: float  # with the energy of the carcasses
    turned: float  # work of aligning and scrub torques on the yawing body
    damped: float


class Pedals(NamedTuple):
    steer: float
    steer_rate: float
    drive_torque: float
    brake_torque: float


def stored_energy(chassis: TwoTrack, motion: Any) -> Any:
    """Energy of translation, yaw, roll, springs, raised body and wheels [J]."""
    squared = motion.speed * motion.speed + motion.lateral_speed * motion.lateral_speed
    planar = chassis.mass * squared + chassis.yaw_inertia * motion.yaw_rate * motion.yaw_rate
    stiffness = sum(axle.roll_stiffness for axle in (chassis.front, chassis.rear))
    stiffness = stiffness - chassis.mass * GRAVITY * chassis.roll_arm
    roll = chassis.roll_inertia * motion.roll_rate * motion.roll_rate
    roll = roll + stiffness * motion.roll_angle * motion.roll_angle
    wheels = zip(chassis.axles, motion.spins, strict=True)
    return 0.5 * (planar + roll + sum((axle.wheel_inertia * spin * spin for axle, spin in wheels), 0.0))


def powers(chassis: TwoTrack, motion: Any, reaction: Reaction, steer: Steer, torques: Wheels, brakes: Wheels) -> Powers:
    hubs = chassis.hubs(motion, steer)
    contacts = chassis.contacts(motion, reaction.loads, hubs, ROAD)
    rates = chassis.derivative(motion, reaction, torques, brakes).spins
    driven, braked, slipped, aligning = 0.0, 0.0, 0.0, 0.0
    for axle, hub, patch, spin, rate, torque in zip(
        chassis.axles, hubs, contacts, motion.spins, rates, torques, strict=True
    ):
        driven = driven + torque * spin
        braked = braked + (torque - axle.tyre.radius * patch.longitudinal_force - axle.wheel_inertia * rate) * spin
        slipping = axle.tyre.radius * spin - hub.along
        slipped = slipped + patch.longitudinal_force * slipping - patch.lateral_force * hub.across
        aligning = aligning + patch.trail * patch.lateral_force
    turned = (aligning + reaction.scrub_torque) * motion.yaw_rate
    damping = chassis.front.roll_damping + chassis.rear.roll_damping
    damped = damping * motion.roll_rate * motion.roll_rate
    return Powers(stored_energy(chassis, motion), driven, braked, slipped, turned, damped)


@dataclass(frozen=True)
class EnergyAudit:
    chassis: TwoTrack

    Sample = Pedals

    def init(self):
        return self.chassis.init(20.0)

    def step(self, state, sample):
        steer = Steer(sample.steer, sample.steer, sample.steer_rate, sample.steer_rate)
        torques = Wheels(sample.drive_torque, sample.drive_torque, 0.0, 0.0)
        brakes = Wheels(*[sample.brake_torque] * 4)

        def slope(motion):
            reaction = self.chassis.reaction(motion[0], steer, ROAD, WIND)
            return (self.chassis.derivative(motion[0], reaction, torques, brakes),)

        reaction = self.chassis.reaction(state, steer, ROAD, WIND)
        (after,) = rosenbrock(slope, (state,), STEP, "", [])
        return after, powers(self.chassis, state, reaction, steer, torques, brakes)


def energy_error(chassis: TwoTrack) -> float:
    """Energy error of a weave to the tyres' limit, then braking to standstill, over the energy that is dissipated."""
    time = np.arange(round(10.0 / STEP)) * STEP
    steer = 0.08 * np.sin(3.0 * time) * np.minimum(time, 1.0)
    drive, brake = np.where(time < 5.0, 400.0, 0.0), np.where(time > 6.0, 600.0, 0.0)
    audit = EnergyAudit(replace(chassis, drag_area=0.0, side_area=0.0))
    out = scan(audit, np.column_stack([steer, np.gradient(steer, STEP), drive, brake]))
    lost = sum(float(np.trapezoid(out[name], dx=STEP)) for name in ("braked", "slipped", "turned", "damped"))
    stored = out["stored"][-1] - out["stored"][0]
    return float(abs(stored - np.trapezoid(out["driven"], dx=STEP) + lost) / lost)
