"""The parts of a virtual car and what they exchange.

A car is put together from a chassis, a steering, a driver and their controllers, each a frozen dataclass of parameters
with pure functions. What obeys a differential equation is a part's *motion*, integrated by the car with all other
parts at once; what is updated once a step (dry friction, delays, a control unit) is its *memory*. Signs are those of
ISO 8855: left is positive; a kingpin torque opposes a turn to the left.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Annotated, Generic, NamedTuple, Protocol, TypeAlias

from typing_extensions import TypeVar

from tierod.core.block import Block, Scalar, Tree, named_tuple
from tierod.core.fields import NOT_NEGATIVE, SHARE, Range
from tierod.core.graph.maths import where

Motion: TypeAlias = Tree
"""Tree of numbers that a part's differential equations carry on."""

Memory: TypeAlias = Tree
"""Tree of numbers (and Rings) that a part updates once a step."""


STEEPEST = Range(-0.5, 0.5)
"""Slopes that a car can stand on [rad]."""


class Road(NamedTuple):
    """The road under the car."""

    curvature: Annotated[float, "1/m"]
    bank_angle: Annotated[float, "rad", STEEPEST]
    grade_angle: Annotated[float, "rad", STEEPEST]
    adhesion_left: Annotated[float, "", NOT_NEGATIVE]
    adhesion_right: Annotated[float, "", NOT_NEGATIVE]
    support: Annotated[float, "", SHARE]
    """Share of the weight on the road: 1 on the ground, 0 on a hoist."""


class Wind(NamedTuple):
    """The air around the car, over ground, in the directions of the car."""

    crosswind_speed: Annotated[float, "m/s"]
    headwind_speed: Annotated[float, "m/s"]


class Demand(NamedTuple):
    """Demand of the course on the driver."""

    speed: Annotated[float, "m/s", NOT_NEGATIVE]
    acceleration: Annotated[float, "m/s**2"]
    curvature_ahead: Annotated[float, "1/m"]
    """Of the road where the driver looks for it, see `Driver.anticipation`."""
    steering_wheel_angle: Annotated[float, "rad"]
    """Added to what the road asks for: the whole of an open-loop manoeuvre, restlessness on a road."""
    hand_torque: Annotated[float, "N*m"]
    """Added to the torque of the hands: tremor, or a torque step."""
    grip: Annotated[float, "", NOT_NEGATIVE]
    """Share of the arms' stiffness and damping that holds the wheel: 0 is hands off."""
    attention: Annotated[float, "", NOT_NEGATIVE]
    """Share of the correction of offset and heading that is made: 0 on a proving ground without lane."""


class Port(NamedTuple):
    """A signal or actuator inside the car's own loops, as a fault changes it: held, then gain * value + offset."""

    gain: Annotated[float, ""]
    offset: Annotated[float, "unit of the signal"]
    held: Annotated[float, ""]


NO_FAULT = Port(1.0, 0.0, 0.0)


Each = TypeVar("Each", default=Scalar)


class Steer(NamedTuple):
    """Steer of the front road wheels."""

    left: Scalar
    right: Scalar
    left_rate: Scalar
    right_rate: Scalar


class Wheels(NamedTuple, Generic[Each]):
    """One of a kind per wheel; a number where nothing else is stated."""

    front_left: Each
    front_right: Each
    rear_left: Each
    rear_right: Each


class Hand(NamedTuple):
    """The steering wheel as it acts on the hands."""

    angle: Scalar
    rate: Scalar


class Loads(NamedTuple):
    """External loads of a steering, at one stage of the integration.

    Args:
        kingpin_left, kingpin_right: torque of tyre and road about each kingpin, opposing a turn to the left [N*m]
        hand_torque: of the driver's hands on the steering wheel [N*m]
        actuator_torques: of every motor at its shaft, as requested by its controller [N*m], one per actuator; a motor
            that turns by itself gives the speed of its shaft instead [rad/s]
        front_load: vertical load of the front axle [N]
        speed: forward speed [m/s]
    """

    kingpin_left: Scalar
    kingpin_right: Scalar
    hand_torque: Scalar
    actuator_torques: tuple[Scalar, ...]
    front_load: Scalar
    speed: Scalar


class Reaction(NamedTuple):
    """Loads and motion of a chassis at one instant; both chassis give all of it.

    Args:
        speed, lateral_speed: of the centre of gravity along and across the body [m/s]
        yaw_rate, yaw_acceleration: [rad/s], [rad/s**2]
        longitudinal_acceleration, lateral_acceleration: sum of tyre and air forces over mass, along and across the
            body, at the centre of gravity: what an accelerometer on a body without roll would read [m/s**2]
        roll_angle, roll_rate, roll_acceleration: of the body, positive when the right side goes down [rad], ...
        kingpin_left, kingpin_right: see `Loads`
        front_lateral_force, rear_lateral_force: of the axles, across the body [N]
        front_slip_angle: of the front axle, positive in a left turn; its tangent, as it acts on the tyres [-]
        loads: vertical load of every wheel [N]
        wheel_speeds: rotation times effective radius of every wheel [m/s]
        self_aligning_torque: of the tyres alone about the kingpins (with mechanical trail), both sides [N*m]
        scrub_torque: of the turning, hardly rolling contact patches, both sides [N*m]
        private: whatever else the derivative needs
    """

    speed: Scalar
    lateral_speed: Scalar
    yaw_rate: Scalar
    yaw_acceleration: Scalar
    longitudinal_acceleration: Scalar
    lateral_acceleration: Scalar
    roll_angle: Scalar
    roll_rate: Scalar
    roll_acceleration: Scalar
    kingpin_left: Scalar
    kingpin_right: Scalar
    front_lateral_force: Scalar
    rear_lateral_force: Scalar
    front_slip_angle: Scalar
    loads: Wheels
    wheel_speeds: Wheels
    self_aligning_torque: Scalar
    scrub_torque: Scalar
    private: Tree


class Plant(Block[Tree, Tree, Tree], Protocol):
    """A car or a bench as a block."""

    @property
    def step_time(self) -> float:
        """Between two samples [s]."""


class Chassis(Protocol):
    """Body, wheels and tyres. Two forms: single track (light) and two track."""

    @property
    def wheelbase(self) -> float:
        """Distance of the axles [m]."""

    def init(self, speed: float) -> Motion:
        """Rolling straight ahead on level ground at a speed [m/s]."""

    def reaction(self, motion: Motion, steer: Steer, road: Road, wind: Wind) -> Reaction:
        """Forces, accelerations and kingpin torques in a state of motion."""

    def derivative(self, motion: Motion, reaction: Reaction, torques: Wheels, brakes: Wheels) -> Motion:
        """Rate of change of the motion.

        Args:
            motion: state
            reaction: of the same state
            torques: of the drive on every wheel, either sign [N*m]
            brakes: greatest torque of every brake, not negative [N*m]
        """


class Steering(Protocol):
    """Steering from the steering wheel (or its actuator) to the road wheels."""

    @property
    def actuators(self) -> tuple[str, ...]:
        """Canonical names of the motors' torques, in the order of `Loads.actuator_torques`."""

    def init(self) -> Motion:
        """Straight ahead, at rest."""

    def remembered(self) -> Memory:
        """Memory before the first step: friction relaxed."""

    def steer(self, motion: Motion) -> Steer:
        """Steering angle and rate of the road wheels."""

    def hand(self, motion: Motion) -> Hand:
        """Angle and rate of the steering wheel."""

    def derivative(self, motion: Motion, start: Motion, memory: Memory, loads: Loads) -> Motion:
        """Rate of change of the motion; dry friction follows the path from the `start` of the step."""

    def advance(self, motion: Motion, start: Motion, memory: Memory, loads: Loads) -> Memory:
        """Memory after a step from `start` to `motion`."""

    def stiff(self) -> Motion:
        """A motion around which all but dry friction is linearised for the implicit part of the integration."""

    def sticking(self, motion: Motion, memory: Memory) -> Mapping[tuple[str, str], Scalar]:
        """Entries of dry friction, which holds like a spring while it sticks, in the Jacobian of that part.

        Returns:
            by (dotted name of a rate, dotted name of an angle) in the motion: growth of the rate's derivative per angle
        """

    def signals(self, motion: Motion, memory: Memory, loads: Loads) -> Tree:
        """NamedTuple of the signals at one instant: canonical names, and `truth_...` for those without a sensor."""


class Seen(NamedTuple):
    """Inputs of a driver at one instant, seen and felt.

    Args:
        speed: [m/s]
        acceleration: along the body [m/s**2]
        lateral_speed, yaw_rate: [m/s], [rad/s]
        lateral_offset: of the car from its path, positive to the left [m]
        heading_error: of the car against its path [rad]
        curvature: of the path here [1/m]
        hand: the steering wheel
    """

    speed: Scalar
    acceleration: Scalar
    lateral_speed: Scalar
    yaw_rate: Scalar
    lateral_offset: Scalar
    heading_error: Scalar
    curvature: Scalar
    hand: Hand

    @property
    def offset_rate(self) -> Scalar:
        """At which the lateral offset grows, for small heading errors [m/s]."""
        return self.speed * self.heading_error + self.lateral_speed


class Intent(NamedTuple):
    """Decision of a driver, until the next step.

    Args:
        steering_wheel_angle: wanted [rad]
        force: wanted along the road, negative brakes [N]
    """

    steering_wheel_angle: Scalar
    force: Scalar


class Driver(Protocol):
    """Whoever steers with hands on the wheel and keeps the speed."""

    @property
    def anticipation(self) -> float:
        """Time ahead at which the curvature is read [s]."""

    def init(self) -> Motion:
        """Muscles relaxed."""

    def remembered(self) -> Memory:
        """Memory before the first step."""

    def decide(self, memory: Memory, seen: Seen, demand: Demand) -> tuple[Memory, Intent]:
        """Once a step: judge what is seen, after the reaction time."""

    def hand_torque(self, motion: Motion, hand: Hand, demand: Demand) -> Scalar:
        """Torque of the hands on the steering wheel [N*m]."""

    def derivative(self, motion: Motion, intent: Intent, hand: Hand, demand: Demand) -> Motion:
        """Rate of change of muscles and the like."""


@cache
def ports_type(names: tuple[str, ...]) -> type:
    """The NamedTuple class with one `Port` per name."""
    return named_tuple("Ports", [(name, Port) for name in names])


def pass_through(port: Port, held: Scalar, value: Scalar) -> tuple[Scalar, Scalar]:
    """Output of a port, as (value to hold from now on, output).

    Args:
        port: the fault, `NO_FAULT` for none
        held: value of the step before
        value: what goes in
    """
    kept = where(port.held > 0.5, held, value)
    return kept, port.gain * kept + port.offset
