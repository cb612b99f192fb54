"""Interfaces of the parts of a virtual car, and the quantities that the parts exchange.

A car consists of a chassis, a steering, a driver and their controllers, each a frozen dataclass of parameters with pure
functions. The *motion* of a part obeys differential equations, which the car integrates for all parts together; the
*memory* of a part (dry friction, delays, a control unit) is updated once per step. Signs follow ISO 8855: left is
positive; a kingpin torque is positive when it opposes a turn to the left.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Generic, NamedTuple, Protocol, TypeAlias

from typing_extensions import TypeVar

from tierod.core.block import Block, Scalar, Tree, named_tuple
from tierod.core.fields import NOT_NEGATIVE, SHARE, Range
from tierod.core.graph.maths import where
from tierod.core.signals import SIGNALS

Motion: TypeAlias = Tree  # State of a part's differential equations, a tree of numbers

Memory: TypeAlias = Tree  # State that a part updates once per step, a tree of numbers and Rings


STEEPEST = Range(-0.5, 0.5)  # Range of the bank and grade angle of a road [rad]


class Road(NamedTuple):
    """Road under the car."""

    curvature: Annotated[float, "1/m"]
    bank_angle: Annotated[float, "rad", STEEPEST]
    grade_angle: Annotated[float, "rad", STEEPEST]
    adhesion_left: Annotated[float, "", NOT_NEGATIVE]
    adhesion_right: Annotated[float, "", NOT_NEGATIVE]
    support: Annotated[float, "", SHARE]  # Share of the weight that the road carries: 1 on the ground, 0 on a hoist


class Wind(NamedTuple):
    """Wind over ground, in the axes of the car."""

    crosswind_speed: Annotated[float, "m/s"]
    headwind_speed: Annotated[float, "m/s"]


class Demand(NamedTuple):
    """Demand of the course on the driver."""

    speed: Annotated[float, "m/s", NOT_NEGATIVE]
    acceleration: Annotated[float, "m/s**2"]
    curvature_ahead: Annotated[float, "1/m"]
    """Curvature of the road at the driver's preview point, see `Driver.anticipation`."""
    steering_wheel_angle: Annotated[float, "rad"]
    """Angle added to that which the road requires: the whole of an open-loop manoeuvre, or restlessness on a road."""
    hand_torque: Annotated[float, "N*m"]  # Torque added to that of the hands: tremor, or a torque step
    grip: Annotated[float, "", NOT_NEGATIVE]
    """Share of the arms' stiffness and damping that acts on the wheel: 0 is hands off."""
    attention: Annotated[float, "", NOT_NEGATIVE]
    """Share of the correction of offset and heading: 0 on a proving ground without lanes."""


class Port(NamedTuple):
    """Fault of a signal or actuator inside the car's own loops: the value is held, then gain * value + offset."""

    gain: Annotated[float, ""]
    offset: Annotated[float, "unit of the signal"]
    held: Annotated[float, ""]


NO_FAULT = Port(1.0, 0.0, 0.0)


Each = TypeVar("Each", default=Scalar)


class Steer(NamedTuple):
    """Steering angles [rad] and rates [rad/s] of the front road wheels, positive to the left."""

    left: Scalar
    right: Scalar
    left_rate: Scalar
    right_rate: Scalar


class Wheels(NamedTuple, Generic[Each]):
    """One quantity of all four wheels; a number unless stated otherwise."""

    front_left: Each
    front_right: Each
    rear_left: Each
    rear_right: Each


class Hand(NamedTuple):
    """Motion of the steering wheel in the driver's hands."""

    angle: Scalar
    rate: Scalar


class Loads(NamedTuple):
    """External loads of a steering at one stage of the integration."""

    # kingpin_left, kingpin_right: torque of tyre and road about each kingpin, opposing a turn to the left [N*m]
    kingpin_left: Scalar
    kingpin_right: Scalar
    hand_torque: Scalar  # torque of the driver's hands on the steering wheel [N*m]
    # shaft torque of every motor as requested by its controller [N*m], one per actuator; for a motor that rotates on
    # its own, the speed of its shaft instead [rad/s]
    actuator_torques: tuple[Scalar, ...]
    front_load: Scalar  # vertical load of the front axle [N]
    speed: Scalar  # forward speed [m/s]


class Reaction(NamedTuple):
    """Loads and motion of a chassis at one instant; the single-track and the two-track chassis provide all of them."""

    speed: Scalar  # speed, lateral_speed: velocity of the centre of gravity along and across the body [m/s]
    lateral_speed: Scalar
    yaw_rate: Scalar  # yaw_rate, yaw_acceleration: motion about the vertical axis [rad/s], [rad/s**2]
    yaw_acceleration: Scalar
    # longitudinal_acceleration, lateral_acceleration: sum of tyre and air forces over mass, along and across the body,
    # at the centre of gravity: what an accelerometer on a body without roll would read [m/s**2]
    longitudinal_acceleration: Scalar
    lateral_acceleration: Scalar
    # roll_angle, roll_rate, roll_acceleration: roll of the body, positive when the right side goes down [rad], ...
    roll_angle: Scalar
    roll_rate: Scalar
    roll_acceleration: Scalar
    kingpin_left: Scalar  # kingpin_left, kingpin_right: torque about each kingpin, see `Loads` [N*m]
    kingpin_right: Scalar
    front_lateral_force: Scalar  # front_lateral_force, rear_lateral_force: forces of the axles across the body [N]
    rear_lateral_force: Scalar
    # tangent of the slip angle of the front axle as it acts on the tyres, positive in a left turn [-]
    front_slip_angle: Scalar
    loads: Wheels  # vertical load of every wheel [N]
    wheel_speeds: Wheels  # angular speed times effective radius of every wheel [m/s]
    # torque of the tyres alone about the kingpins (with mechanical trail), both sides [N*m]
    self_aligning_torque: Scalar
    scrub_torque: Scalar  # torque of the contact patches turning at almost no speed, both sides [N*m]
    private: Tree


class Plant(Block[Tree, Tree, Tree], Protocol):
    """A car or a bench as a block."""

    @property
    def step_time(self) -> float:
        """Sampling interval [s]."""


class Chassis(Protocol):
    """Body, wheels and tyres, as a single-track (cheap) or a two-track model."""

    @property
    def wheelbase(self) -> float:
        """Distance between the axles [m]."""

    def init(self, speed: float) -> Motion:
        """State of motion rolling straight ahead on level ground at a speed [m/s]."""

    def reaction(self, motion: Motion, steer: Steer, road: Road, wind: Wind) -> Reaction:
        """Forces, accelerations and kingpin torques in a state of motion."""

    def derivative(self, motion: Motion, reaction: Reaction, torques: Wheels, brakes: Wheels) -> Motion:
        """Rate of change of the motion.

        Args:
            torques: drive torque of every wheel, of either sign [N*m]
            brakes: maximum brake torque of every wheel, not negative [N*m]
        """


class Steering(Protocol):
    """Steering from the steering wheel (or its actuator) to the road wheels."""

    @property
    def actuators(self) -> tuple[str, ...]:
        """Canonical names of the motors' torques, in the order of `Loads.actuator_torques`."""

    def init(self) -> Motion:
        """State of motion straight ahead, at rest."""

    def remembered(self) -> Memory:
        """Memory before the first step: friction relaxed."""

    def steer(self, motion: Motion) -> Steer:
        """Steering angle and rate of the road wheels."""

    def hand(self, motion: Motion) -> Hand:
        """Angle and rate of the steering wheel."""

    def derivative(self, motion: Motion, start: Motion, memory: Memory, loads: Loads) -> Motion:
        """Rate of change of the motion; dry friction is evaluated along the path from the `start` of the step."""

    def advance(self, motion: Motion, start: Motion, memory: Memory, loads: Loads) -> Memory:
        """Memory after a step from `start` to `motion`."""

    def stiff(self) -> Motion:
        """Linearisation point of all but dry friction for the implicit part of the integration."""

    def sticking(self, motion: Motion, memory: Memory) -> Mapping[tuple[str, str], Scalar]:
        """Entries of dry friction, which acts like a spring while it sticks, in the Jacobian of the stiff part.

        Returns:
            by (dotted name of a rate, dotted name of an angle) in the motion: derivative of the rate's derivative with
            respect to the angle
        """

    def signals(self, motion: Motion, memory: Memory, loads: Loads) -> Tree:
        """NamedTuple of the signals at one instant: canonical names, and `truth_...` for those without a sensor."""


class Seen(NamedTuple):
    """Inputs of a driver at one instant, seen and felt."""

    speed: Scalar  # forward speed [m/s]
    acceleration: Scalar  # acceleration along the body [m/s**2]
    lateral_speed: Scalar  # lateral_speed, yaw_rate: lateral motion of the car [m/s], [rad/s]
    yaw_rate: Scalar
    lateral_offset: Scalar  # offset of the car from its path, positive to the left [m]
    heading_error: Scalar  # heading of the car relative to its path [rad]
    curvature: Scalar  # curvature of the path at the car [1/m]
    hand: Hand

    @property
    def offset_rate(self) -> Scalar:
        """Rate of change of the lateral offset, for small heading errors [m/s]."""
        return self.speed * self.heading_error + self.lateral_speed


class Intent(NamedTuple):
    """Decision of a driver, held until the next step."""

    steering_wheel_angle: Scalar  # target angle [rad]
    force: Scalar  # target force along the road, negative to brake [N]


class Driver(Protocol):
    """Driver who steers with the hands on the wheel and keeps the speed."""

    @property
    def anticipation(self) -> float:
        """Preview time at which the curvature is read [s]."""

    def init(self) -> Motion:
        """State of motion with relaxed muscles."""

    def remembered(self) -> Memory:
        """Memory before the first step."""

    def decide(self, memory: Memory, seen: Seen, demand: Demand) -> tuple[Memory, Intent]:
        """Decide once per step on what was seen one reaction time earlier."""

    def hand_torque(self, motion: Motion, hand: Hand, demand: Demand) -> Scalar:
        """Torque of the hands on the steering wheel [N*m]."""

    def derivative(self, motion: Motion, intent: Intent, hand: Hand, demand: Demand) -> Motion:
        """Rate of change of the muscles' and other continuous states."""


def signals(name: str, listed: str) -> Any:
    """NamedTuple class of signals before sensors, and of quantities without a sensor (`truth_`).

    Args:
        listed: names in order; one that is no canonical signal carries its unit: "yaw_rate truth_speed[m/s]"
    """
    pairs = (each.removesuffix("]").partition("[") for each in listed.split())
    units = {own: unit if mark else SIGNALS[own].unit for own, mark, unit in pairs}
    return named_tuple(name, [(own, Annotated[Scalar, unit]) for own, unit in units.items()])


@cache
def ports_type(names: tuple[str, ...]) -> type:
    """NamedTuple class with one `Port` per name."""
    return named_tuple("Ports", [(name, Port) for name in names])


def pass_through(port: Port, held: Scalar, value: Scalar) -> tuple[Scalar, Scalar]:
    """Apply the fault of a port, and return (value to hold from now on, output)."""
    kept = where(port.held > 0.5, held, value)
    return kept, port.gain * kept + port.offset
