"""Base class of the virtual cars on a road, which advances chassis, steering, driver and control units by one step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, NamedTuple, TypeAlias

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.fields import Range
from tierod.core.graph.maths import arctan, arctan2, where
from tierod.physics.motion import GRAVITY, lateral_acceleration_at
from tierod_lab.ground.chassis import TwoTrack
from tierod_lab.ground.courses.course import Start
from tierod_lab.ground.drivers import HumanDriver
from tierod_lab.ground.integration import START, Path, moved, path_rate, rosenbrock, steering_inverse
from tierod_lab.ground.parts import (
    Chassis,
    Demand,
    Driver,
    Hand,
    Intent,
    Loads,
    Memory,
    Reaction,
    Road,
    Seen,
    Steering,
    Wheels,
    Wind,
    pass_through,
    ports_type,
    signals,
)
from tierod_lab.ground.parts import Motion as PartMotion
from tierod_lab.ground.powertrain import Powertrain


@dataclass(frozen=True)
class InertialUnit:
    """Mounting position of the inertial unit on the body; typically on the tunnel, below the centre of gravity."""

    forward: Annotated[float, "m"] = 0.2
    left: Annotated[float, "m"] = 0.0
    up: Annotated[float, "m"] = -0.15

    def lateral_acceleration(self, reaction: Reaction) -> Scalar:
        """Specific force across the body, with lever arm, bank and roll angle [m/s**2]."""
        at_place = lateral_acceleration_at(
            reaction.lateral_acceleration, reaction.yaw_acceleration, reaction.yaw_rate, self.forward, self.left
        )
        return at_place - self.up * reaction.roll_acceleration + GRAVITY * reaction.roll_angle

    def longitudinal_acceleration(self, reaction: Reaction) -> Scalar:
        """Specific force along the body, with lever arm and grade [m/s**2]."""
        turning = reaction.yaw_rate * reaction.yaw_rate * self.forward + reaction.yaw_acceleration * self.left
        return reaction.longitudinal_acceleration - turning


ROLLING = 0.5  # Speed below which the sideslip angle is set to zero [m/s]


Body = signals(
    "Body",
    """yaw_rate lateral_acceleration longitudinal_acceleration roll_rate vehicle_speed wheel_speed_front_left
    wheel_speed_front_right wheel_speed_rear_left wheel_speed_rear_right truth_speed[m/s] truth_lateral_speed[m/s]
    truth_sideslip_angle[rad] truth_centre_lateral_acceleration[m/s**2] truth_yaw_acceleration[rad/s**2]
    truth_roll_angle[rad] truth_front_lateral_force[N] truth_rear_lateral_force[N] truth_front_slip_angle[rad]
    truth_load_front_left[N] truth_load_front_right[N] truth_load_rear_left[N] truth_load_rear_right[N]
    truth_self_aligning_torque[N*m] truth_scrub_torque[N*m] truth_kingpin_torque[N*m] truth_hand_torque[N*m]
    truth_drive_force[N] truth_distance[m] truth_lateral_offset[m] truth_heading_error[rad] truth_heading[rad]
    truth_position_x[m] truth_position_y[m] truth_bank_angle[rad] truth_grade_angle[rad] truth_road_friction[]""",
)
"""Signals of body and wheels before sensors, and quantities without a sensor (`truth_`)."""


def vehicle_speed(reaction: Reaction) -> Scalar:
    """Speed on the bus, as the brake control unit sends it: the mean of the rear wheels [m/s]."""
    return 0.5 * (reaction.wheel_speeds.rear_left + reaction.wheel_speeds.rear_right)


Torques: TypeAlias = tuple[Scalar, ...]  # Torque of every actuator [N*m], in the order of `Steering.actuators`
Read: TypeAlias = Callable[[str, Scalar], Scalar]  # Function that passes a signal through the port of its name
Controlled: TypeAlias = tuple[Memory, Torques, Tree]
"""Result of the control units: memory, requested torques, and signals as a NamedTuple of canonical names."""


class Motion(NamedTuple):
    """State of all differential equations."""

    chassis: PartMotion
    steering: PartMotion
    driver: PartMotion
    path: Path


class Held(NamedTuple):
    """Values that are updated once per step."""

    steering: Memory
    driver: Memory
    control: Memory
    torques: Torques
    ports: tuple[Scalar, ...]
    position: tuple[Scalar, Scalar]


class Surroundings(NamedTuple):
    """External inputs of a car at one instant; every car has its own class with its `ports`."""

    road: Road
    wind: Wind
    demand: Demand
    ports: Tree


class State(NamedTuple):
    motion: Motion
    held: Held


class Observed(NamedTuple):
    """Signals that the control units of a car can read at one instant, before sensors and ports."""

    reaction: Reaction
    steering: Tree
    view: Seen
    demand: Demand

    @property
    def hand(self) -> Hand:
        return self.view.hand

    @property
    def vehicle_speed(self) -> Scalar:
        """Vehicle speed on the bus [m/s]."""
        return vehicle_speed(self.reaction)


class Output(NamedTuple):
    body: Tree
    steering: Tree
    control: Tree


@dataclass(frozen=True)
class Car:
    """Base class of the virtual cars; a car adds its control units by `ports`, `reset` and `control`."""

    chassis: Chassis = field(default_factory=TwoTrack)
    steering: Steering = None  # type: ignore[assignment]  # every car gives its own
    driver: Driver = field(default_factory=HumanDriver)
    powertrain: Powertrain = field(default_factory=Powertrain)
    inertial_unit: InertialUnit = field(default_factory=InertialUnit)
    start: Start = field(default_factory=Start)
    # step of integration and control units; tyres and brakes are integrated explicitly and allow at most 2 ms
    step_time: Annotated[float, "s", Range(1e-5, 2e-3)] = 1e-3

    @property
    def ports(self) -> tuple[str, ...]:
        return self.steering.actuators

    @property
    def Sample(self) -> type:
        return _sample(self.ports)

    def reset(self) -> Memory:
        return ()

    def control(self, memory: Memory, seen: Observed, read: Read) -> Controlled:
        return memory, (0.0,) * len(self.steering.actuators), ()

    def init(self) -> State:
        motion = Motion(self.chassis.init(self.start.speed), self.steering.init(), self.driver.init(), START)
        held = Held(
            self.steering.remembered(),
            self.driver.remembered(),
            self.reset(),
            (0.0,) * len(self.steering.actuators),
            (0.0,) * len(self.ports),
            (0.0, 0.0),
        )
        return State(motion, held)

    def step(self, state: State, sample: Surroundings) -> tuple[State, Output]:
        motion, held = state
        steer, hand = self.steering.steer(motion.steering), self.steering.hand(motion.steering)
        reaction = self.chassis.reaction(motion.chassis, steer, sample.road, sample.wind)
        moving = (reaction.speed, reaction.longitudinal_acceleration, reaction.lateral_speed, reaction.yaw_rate)
        place = (motion.path.lateral_offset, motion.path.heading_error)
        view = Seen(*moving, *place, sample.road.curvature, hand)
        driver, intent = self.driver.decide(held.driver, view, sample.demand)
        hand_torque = self.driver.hand_torque(motion.driver, hand, sample.demand)
        # These signals contain the torques of the last step, since this step's are decided from them.
        before = _loads(reaction, hand_torque, held.torques)
        signals = self.steering.signals(motion.steering, held.steering, before)
        observed = Observed(reaction, signals, view, sample.demand)
        control, torques, controlled, ports = self._controlled(held, observed, sample.ports)
        drive, brakes = self.drives(intent, reaction, torques)

        def slope(now: Motion) -> Motion:
            steer, hand = self.steering.steer(now.steering), self.steering.hand(now.steering)
            reaction = self.chassis.reaction(now.chassis, steer, sample.road, sample.wind)
            loads = _loads(reaction, self.driver.hand_torque(now.driver, hand, sample.demand), torques)
            return Motion(
                self.chassis.derivative(now.chassis, reaction, drive, brakes),
                self.steering.derivative(now.steering, motion.steering, held.steering, loads),
                self.driver.derivative(now.driver, intent, hand, sample.demand),
                path_rate(now.path, reaction, sample.road.curvature),
            )

        inverse = steering_inverse(self.steering, motion.steering, held.steering, self.step_time)
        after = rosenbrock(slope, motion, self.step_time, "steering", inverse)
        loads = _loads(reaction, hand_torque, torques)
        position = moved(held.position, reaction, motion.path.heading, self.step_time)
        steering = self.steering.advance(after.steering, motion.steering, held.steering, loads)
        next_held = Held(steering, driver, control, torques, ports, position)
        force = self.drive_force(intent, held.torques)
        body = self._body(reaction, motion.path, held.position, sample.road, hand_torque, force)
        return State(after, next_held), Output(body, signals, controlled)

    def _body(
        self,
        reaction: Reaction,
        path: Path,
        position: tuple[Scalar, Scalar],
        road: Road,
        hand_torque: Scalar,
        drive_force: Scalar,
    ) -> Tree:
        rolling = reaction.speed > ROLLING
        sideslip = arctan2(reaction.lateral_speed, where(rolling, reaction.speed, 1.0))
        return Body(
            reaction.yaw_rate,
            self.inertial_unit.lateral_acceleration(reaction),
            self.inertial_unit.longitudinal_acceleration(reaction),
            reaction.roll_rate,
            vehicle_speed(reaction),
            *reaction.wheel_speeds,
            reaction.speed,
            reaction.lateral_speed,
            where(rolling, sideslip, 0.0),
            reaction.lateral_acceleration,
            reaction.yaw_acceleration,
            reaction.roll_angle,
            reaction.front_lateral_force,
            reaction.rear_lateral_force,
            arctan(reaction.front_slip_angle),
            *reaction.loads,
            reaction.self_aligning_torque,
            reaction.scrub_torque,
            reaction.kingpin_left + reaction.kingpin_right,
            hand_torque,
            drive_force,
            *path,
            *position,
            road.bank_angle,
            road.grade_angle,
            0.5 * (road.adhesion_left + road.adhesion_right),
        )

    def drives(self, intent: Intent, reaction: Reaction, torques: Torques) -> tuple[Wheels, Wheels]:
        """Drive torque and maximum brake torque of every wheel [N*m]."""
        return self.powertrain.torques(intent.force, reaction)

    def drive_force(self, intent: Intent, torques: Torques) -> Scalar:
        """Requested force along the road [N], from the driver's intent or the actuators' torques [N*m]."""
        return intent.force

    def _controlled(
        self, held: Held, observed: Observed, ports: Tree
    ) -> tuple[Memory, Torques, Tree, tuple[Scalar, ...]]:
        kept = dict(zip(self.ports, held.ports, strict=True))
        waiting = {name for name in self.steering.actuators if name in kept}

        def read(name: str, value: Scalar) -> Scalar:
            waiting.discard(name)
            kept[name], passed = pass_through(getattr(ports, name), kept[name], value)
            return passed

        memory, requests, signals = self.control(held.control, observed, read)
        requested = zip(self.steering.actuators, requests, strict=True)
        torques = tuple(read(name, wanted) if name in waiting else wanted for name, wanted in requested)
        return memory, torques, signals, tuple(kept[name] for name in self.ports)


@cache
def _sample(ports: tuple[str, ...]) -> type:
    return named_tuple(
        "Surroundings", [("road", Road), ("wind", Wind), ("demand", Demand), ("ports", ports_type(ports))]
    )


def _loads(reaction: Reaction, hand_torque: Scalar, torques: Torques) -> Loads:
    front = reaction.loads.front_left + reaction.loads.front_right
    return Loads(reaction.kingpin_left, reaction.kingpin_right, hand_torque, torques, front, reaction.speed)
