"""What every virtual car on a road shares: one step of chassis, steering, driver and control units together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.block import named_tuple
from tierod.graph.maths import arctan2, cos, maximum, sin, where
from tierod.proving_ground.cars.imu import InertialUnit
from tierod.proving_ground.chassis import TwoTrack
from tierod.proving_ground.driving import HumanDriver
from tierod.proving_ground.integration import rosenbrock
from tierod.proving_ground.parts import (
    Chassis,
    Demand,
    Driver,
    Hand,
    Intent,
    Loads,
    Reaction,
    Road,
    Seen,
    Steering,
    Wheels,
    Wind,
)
from tierod.proving_ground.ports import pass_through, ports_type
from tierod.proving_ground.powertrain import Powertrain
from tierod.proving_ground.steering.implicit import steering_inverse
from tierod.ranges import NOT_NEGATIVE, POSITIVE

ROLLING = 0.5
"""Speed below which there is no sideslip angle [m/s]."""


class Path(NamedTuple):
    """Where the car is along its path, and over ground."""

    distance: Annotated[Any, "m"]
    lateral_offset: Annotated[Any, "m"]
    heading_error: Annotated[Any, "rad"]
    heading: Annotated[Any, "rad"]


class Motion(NamedTuple):
    """All that obeys a differential equation."""

    chassis: Any
    steering: Any
    driver: Any
    path: Path


class Held(NamedTuple):
    """What is updated once a step."""

    steering: Any
    driver: Any
    control: Any
    torques: tuple[Any, ...]
    ports: Any
    position: tuple[Any, Any]


class State(NamedTuple):
    """A car between two steps."""

    motion: Motion
    held: Held


class Observed(NamedTuple):
    """What a car's control units can read at one instant, before sensors and ports.

    Args:
        reaction: of the chassis
        steering: signals of the steering
        hand: steering wheel
        demand: what the course asks for
        intent: what the driver has decided
    """

    reaction: Reaction
    steering: Any
    hand: Hand
    demand: Demand
    intent: Intent


class Body(NamedTuple):
    """Signals of body and wheels before sensors, and what no sensor sees (`truth_`)."""

    yaw_rate: Annotated[Any, "rad/s"]
    lateral_acceleration: Annotated[Any, "m/s**2"]
    longitudinal_acceleration: Annotated[Any, "m/s**2"]
    roll_rate: Annotated[Any, "rad/s"]
    vehicle_speed: Annotated[Any, "m/s"]
    wheel_speed_front_left: Annotated[Any, "m/s"]
    wheel_speed_front_right: Annotated[Any, "m/s"]
    wheel_speed_rear_left: Annotated[Any, "m/s"]
    wheel_speed_rear_right: Annotated[Any, "m/s"]
    truth_speed: Annotated[Any, "m/s"]
    truth_lateral_speed: Annotated[Any, "m/s"]
    truth_sideslip_angle: Annotated[Any, "rad"]
    truth_centre_lateral_acceleration: Annotated[Any, "m/s**2"]
    truth_yaw_acceleration: Annotated[Any, "rad/s**2"]
    truth_roll_angle: Annotated[Any, "rad"]
    truth_front_lateral_force: Annotated[Any, "N"]
    truth_rear_lateral_force: Annotated[Any, "N"]
    truth_front_slip_angle: Annotated[Any, "rad"]
    truth_load_front_left: Annotated[Any, "N"]
    truth_load_front_right: Annotated[Any, "N"]
    truth_load_rear_left: Annotated[Any, "N"]
    truth_load_rear_right: Annotated[Any, "N"]
    truth_self_aligning_torque: Annotated[Any, "N*m"]
    truth_scrub_torque: Annotated[Any, "N*m"]
    truth_kingpin_torque: Annotated[Any, "N*m"]
    truth_hand_torque: Annotated[Any, "N*m"]
    truth_drive_force: Annotated[Any, "N"]
    truth_distance: Annotated[Any, "m"]
    truth_lateral_offset: Annotated[Any, "m"]
    truth_heading_error: Annotated[Any, "rad"]
    truth_heading: Annotated[Any, "rad"]
    truth_position_x: Annotated[Any, "m"]
    truth_position_y: Annotated[Any, "m"]
    truth_bank_angle: Annotated[Any, "rad"]
    truth_grade_angle: Annotated[Any, "rad"]
    truth_road_friction: Annotated[Any, ""]


class Output(NamedTuple):
    """Signals of a car at the instant of a sample; the last part of a leaf's dotted name is its channel."""

    body: Body
    steering: Any
    control: Any


class Start(NamedTuple):
    """How a run begins.

    Args:
        speed: rolling straight ahead
    """

    speed: Annotated[float, "m/s", NOT_NEGATIVE] = 0.0


@dataclass(frozen=True)
class Car:
    """Base of the virtual cars; a car adds its control units by `ports`, `reset` and `control`.

    Args:
        chassis: body, wheels, tyres
        steering: from the steering wheel to the road wheels
        driver: whose hands and feet
        powertrain: from the driver's feet to the wheels
        inertial_unit: where the inertial sensors sit
        start: how a run begins
        step_time: of integration and control units
    """

    chassis: Chassis = field(default_factory=TwoTrack)
    steering: Steering = None  # type: ignore[assignment]
    driver: Driver = field(default_factory=HumanDriver)
    powertrain: Powertrain = field(default_factory=Powertrain)
    inertial_unit: InertialUnit = field(default_factory=InertialUnit)
    start: Start = field(default_factory=Start)
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    @property
    def ports(self) -> tuple[str, ...]:
        """Names of the signals that control units read, and of the actuators, where faults can act.

        An actuator without a port of its own gives what its control unit asks for.
        """
        return self.steering.actuators

    @property
    def Sample(self) -> type:
        """What acts on the car from outside at one instant."""
        return _sample(self.ports)

    def reset(self) -> Any:
        """Memory of the control units before the first step."""
        return ()

    def control(self, memory: Any, seen: Observed, read: Callable[[str, Any], Any]) -> tuple[Any, tuple, Any]:
        """One step of the control units.

        Args:
            memory: of the control units
            seen: what can be read
            read: passes a signal through the port of a name

        Returns:
            memory, requested torque of every actuator [N*m], signals (NamedTuple of canonical names)
        """
        return memory, (0.0,) * len(self.steering.actuators), ()

    def init(self) -> State:
        """Straight ahead at the starting speed."""
        motion = Motion(
            self.chassis.init(self.start.speed),
            self.steering.init(),
            self.driver.init(),
            Path(0.0, 0.0, 0.0, 0.0),
        )
        held = Held(
            self.steering.remembered(),
            self.driver.remembered(),
            self.reset(),
            (0.0,) * len(self.steering.actuators),
            (0.0,) * len(self.ports),
            (0.0, 0.0),
        )
        return State(motion, held)

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One step on; the output belongs to the instant of the sample."""
        motion, held = state
        steer, hand = self.steering.steer(motion.steering), self.steering.hand(motion.steering)
        reaction = self.chassis.reaction(motion.chassis, steer, sample.road, sample.wind)
        driver, intent = self.driver.decide(held.driver, _seen(motion, reaction, hand, sample.road), sample.demand)
        hand_torque = self.driver.hand_torque(motion.driver, hand, sample.demand)
        before = _loads(reaction, hand_torque, held.torques)
        signals = self.steering.signals(motion.steering, held.steering, before)
        observed = Observed(reaction, signals, hand, sample.demand, intent)
        control, torques, controlled, ports = self._controlled(held, observed, sample.ports)
        drive, brakes = self.drives(intent, reaction, torques)

        def slope(now: Motion) -> Motion:
            return self._derivative(now, motion, held.steering, sample, intent, torques, drive, brakes)

        inverse = steering_inverse(self.steering, motion.steering, held.steering, self.step_time)
        after = rosenbrock(slope, motion, self.step_time, "steering", inverse)
        loads = _loads(reaction, hand_torque, torques)
        position = _moved(held.position, reaction, motion.path.heading, self.step_time)
        steering = self.steering.advance(after.steering, motion.steering, held.steering, loads)
        next_held = Held(steering, driver, control, torques[: len(held.torques)], ports, position)
        body = self._body(motion, held, reaction, hand_torque, intent, sample.road)
        return State(after, next_held), Output(body, signals, controlled)

    def drives(self, intent: Intent, reaction: Reaction, torques: tuple) -> tuple[Wheels, Wheels]:
        """Drive torque and greatest brake torque of every wheel [N*m]."""
        return self.powertrain.torques(intent.force, reaction)

    def _controlled(self, held: Held, observed: Observed, ports: Any) -> tuple[Any, tuple, Any, Any]:
        kept = dict(zip(self.ports, held.ports, strict=True))

        def read(name: str, value: Any) -> Any:
            kept[name], passed = pass_through(getattr(ports, name), kept[name], value)
            return passed

        memory, requests, signals = self.control(held.control, observed, read)
        requested = zip(self.steering.actuators, requests, strict=True)
        torques = tuple(read(name, wanted) if name in kept else wanted for name, wanted in requested)
        return memory, torques, signals, tuple(kept[name] for name in self.ports)

    def _derivative(
        self,
        now: Motion,
        start: Motion,
        friction: Any,
        sample: Any,
        intent: Intent,
        torques: tuple,
        drive: Wheels,
        brakes: Wheels,
    ) -> Motion:
        steer, hand = self.steering.steer(now.steering), self.steering.hand(now.steering)
        reaction = self.chassis.reaction(now.chassis, steer, sample.road, sample.wind)
        hand_torque = self.driver.hand_torque(now.driver, hand, sample.demand)
        loads = _loads(reaction, hand_torque, torques)
        return Motion(
            self.chassis.derivative(now.chassis, reaction, drive, brakes),
            self.steering.derivative(now.steering, start.steering, friction, loads),
            self.driver.derivative(now.driver, intent, hand, sample.demand),
            _path_rate(now.path, reaction, sample.road.curvature),
        )

    def _body(
        self, motion: Motion, held: Held, reaction: Reaction, hand_torque: Any, intent: Intent, road: Road
    ) -> Body:
        wheels, loads, path = reaction.wheel_speeds, reaction.loads, motion.path
        rolling = reaction.speed > ROLLING
        sideslip = arctan2(reaction.lateral_speed, where(rolling, reaction.speed, 1.0))
        return Body(
            reaction.yaw_rate,
            self.inertial_unit.lateral_acceleration(reaction),
            self.inertial_unit.longitudinal_acceleration(reaction),
            reaction.roll_rate,
            0.5 * (wheels.rear_left + wheels.rear_right),
            *wheels,
            reaction.speed,
            reaction.lateral_speed,
            where(rolling, sideslip, 0.0),
            reaction.lateral_acceleration,
            reaction.yaw_acceleration,
            reaction.roll_angle,
            reaction.front_lateral_force,
            reaction.rear_lateral_force,
            reaction.front_slip_angle,
            *loads,
            reaction.self_aligning_torque,
            reaction.scrub_torque,
            reaction.kingpin_left + reaction.kingpin_right,
            hand_torque,
            intent.force,
            path.distance,
            path.lateral_offset,
            path.heading_error,
            path.heading,
            *held.position,
            road.bank_angle,
            road.grade_angle,
            0.5 * (road.adhesion_left + road.adhesion_right),
        )


def _sample(ports: tuple[str, ...]) -> type:
    return named_tuple(
        "Surroundings", [("road", Road), ("wind", Wind), ("demand", Demand), ("ports", ports_type(ports))]
    )


def _seen(motion: Motion, reaction: Reaction, hand: Hand, road: Road) -> Seen:
    return Seen(
        reaction.speed,
        reaction.longitudinal_acceleration,
        reaction.lateral_speed,
        reaction.yaw_rate,
        motion.path.lateral_offset,
        motion.path.heading_error,
        road.curvature,
        hand,
    )


def _loads(reaction: Reaction, hand_torque: Any, torques: tuple) -> Loads:
    front = reaction.loads.front_left + reaction.loads.front_right
    return Loads(reaction.kingpin_left, reaction.kingpin_right, hand_torque, torques, front, reaction.speed)


def _path_rate(path: Path, reaction: Reaction, curvature: Any) -> Path:
    along, across = cos(path.heading_error), sin(path.heading_error)
    forward = reaction.speed * along - reaction.lateral_speed * across
    # The path's frame turns over where the car is as far inside the bend as its radius.
    distance_rate = forward / maximum(1.0 - curvature * path.lateral_offset, 0.2)
    sideways = reaction.speed * across + reaction.lateral_speed * along
    return Path(distance_rate, sideways, reaction.yaw_rate - curvature * distance_rate, reaction.yaw_rate)


def _moved(position: tuple[Any, Any], reaction: Reaction, heading: Any, step: Any) -> tuple[Any, Any]:
    middle = heading + 0.5 * step * reaction.yaw_rate
    along, across = cos(middle), sin(middle)
    return (
        position[0] + step * (reaction.speed * along - reaction.lateral_speed * across),
        position[1] + step * (reaction.speed * across + reaction.lateral_speed * along),
    )
