"""What can be seen of a steering at one instant; every steering with a steering wheel and one motor gives the same."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.proving_ground.parts import Hand
from tierod.proving_ground.steering.linkage import Linkage, Resistance


class SteeringSignals(NamedTuple):
    """Signals before sensors, and what no sensor sees (`truth_`).

    `truth_friction_torque` is the sliding level of all dry friction at the steering wheel's axis, at the reference
    loads and the present angle; `truth_friction_resistance` is what all dry friction does right now, with its sign.
    """

    steering_wheel_angle: Annotated[Any, "rad"]
    steering_wheel_rate: Annotated[Any, "rad/s"]
    driver_torque: Annotated[Any, "N*m"]
    motor_torque: Annotated[Any, "N*m"]
    motor_angle_mechanical: Annotated[Any, "rad"]
    motor_speed: Annotated[Any, "rad/s"]
    pinion_angle: Annotated[Any, "rad"]
    rack_position: Annotated[Any, "m"]
    rack_speed: Annotated[Any, "m/s"]
    rack_force: Annotated[Any, "N"]
    tie_rod_force_left: Annotated[Any, "N"]
    tie_rod_force_right: Annotated[Any, "N"]
    road_wheel_angle_left: Annotated[Any, "rad"]
    road_wheel_angle_right: Annotated[Any, "rad"]
    truth_friction_torque: Annotated[Any, "N*m"]
    truth_friction_resistance: Annotated[Any, "N*m"]
    truth_steering_wheel_acceleration: Annotated[Any, "rad/s**2"]


class Shaft(NamedTuple):
    """A rotor at one instant: torque of its currents [N*m], angle [rad], rate [rad/s]."""

    torque: Any
    angle: Any
    rate: Any


class Rack(NamedTuple):
    """A rack at one instant, as the turn of the pinion that it stands for: [rad], [rad/s], [rad/s**2]."""

    angle: Any
    rate: Any
    acceleration: Any


class Dry(NamedTuple):
    """Dry friction of a whole steering at the steering wheel's axis: level and signed torque [N*m]."""

    level: Any
    torque: Any


def steering_signals(
    linkage: Linkage,
    hand: Hand,
    hand_acceleration: Any,
    driver_torque: Any,
    motor: Shaft,
    pinion_angle: Any,
    rack: Rack,
    resistance: Resistance,
    dry: Dry,
) -> SteeringSignals:
    """Signals of a steering, with the tie rods' forces from the balance of their road wheels.

    Args:
        hand, hand_acceleration: steering wheel, [rad/s**2]
        driver_torque: in the torsion bar [N*m]
        motor, rack: rotor and travel
        pinion_angle: [rad]
        linkage, resistance: behind the rack
        dry: friction
    """
    steer = linkage.steer(rack.angle, rack.rate)
    swing = 0.5 * linkage.inertia * rack.acceleration
    left = (resistance.left + swing) / linkage.rack_ratio
    right = (resistance.right + swing) / linkage.rack_ratio
    return SteeringSignals(
        steering_wheel_angle=hand.angle,
        steering_wheel_rate=hand.rate,
        driver_torque=driver_torque,
        motor_torque=motor.torque,
        motor_angle_mechanical=motor.angle,
        motor_speed=motor.rate,
        pinion_angle=pinion_angle,
        rack_position=linkage.rack_ratio * rack.angle,
        rack_speed=linkage.rack_ratio * rack.rate,
        rack_force=left + right,
        tie_rod_force_left=left,
        tie_rod_force_right=right,
        road_wheel_angle_left=steer.left,
        road_wheel_angle_right=steer.right,
        truth_friction_torque=dry.level,
        truth_friction_resistance=dry.torque,
        truth_steering_wheel_acceleration=hand_acceleration,
    )
