"""Road wheels turned by an actuator against friction and the aligning torque of the tyres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.physics.friction import viscous
from tierod_lab.ground.laws import smooth_coulomb


class SteerByWire:
    """Road wheels turned by an actuator: inertia, damping, dry friction and the tyres' aligning torque.

    Validity: rigid between actuator and road wheels; constant power assist.
    Source: Yih, Ryu, Gerdes, eqs (1), (4) and (5). Friction is F_w tanh(rate / friction_rate), printed as
    F_w sgn(rate), which chatters with an estimated rate and is undefined at rest.
    """

    class State(NamedTuple):
        """Mean steer of the front wheels and its rate."""

        road_wheel_angle: Annotated[float, "rad"]
        road_wheel_rate: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        """Torque of the actuator and, against it, of the tyres."""

        road_wheel_torque: Annotated[float, "N*m"]
        self_aligning_torque: Annotated[float, "N*m"]

    class Output(NamedTuple):
        """Measurement of the angle sensor."""

        road_wheel_angle: Annotated[float, "rad"]

    @dataclass(frozen=True)
    class Parameters:
        """Inertia, damping and friction, all referred to the road wheels."""

        road_wheel_inertia: Annotated[float, "kg*m**2"]  # rotor, gear, rack and road wheels together, J_w
        road_wheel_damping: Annotated[float, "N*m*s/rad"]  # viscous, b_w
        road_wheel_friction: Annotated[float, "N*m"]  # level of dry friction, F_w
        # rate of the road wheels at which dry friction has 76 % of its level; a tenth of a usual steering rate, and
        # above the error of an estimated rate
        friction_rate: Annotated[float, "rad/s"] = 0.02

    @staticmethod
    def derivative(x: State, u: Input, p: Parameters) -> State:
        """Rate of the road wheels and their acceleration, eq (1)."""
        return SteerByWire.State(x.road_wheel_rate, steering_acceleration(x.road_wheel_rate, *u, p))

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        return SteerByWire.Output(x.road_wheel_angle)


def steering_acceleration(
    rate: Scalar, road_wheel_torque: Scalar, self_aligning_torque: Scalar, p: SteerByWire.Parameters
) -> Scalar:
    """Acceleration of the road wheels [rad/s**2].

    Source: Yih, Ryu, Gerdes, eq (1) with the friction of eq (5) smoothed.

    Args: rate: of the road wheels [rad/s]; road_wheel_torque: of the actuator [N*m]; self_aligning_torque: of both
    front tyres, against it [N*m].
    """
    friction = smooth_coulomb(rate, p.road_wheel_friction, p.friction_rate)
    resistance = viscous(rate, p.road_wheel_damping) + friction + self_aligning_torque
    return (road_wheel_torque - resistance) / p.road_wheel_inertia


class DisturbedSteering:
    """The steering with the aligning torque as a third state, which is constant.

    The process noise of the estimator lets it vary. Validity: aligning torque that is slow against the estimator.
    Source: Yih, Ryu, Gerdes, eqs (18) and (19).
    """

    class State(NamedTuple):
        """State of the steering, and the torque of the tyres."""

        road_wheel_angle: Annotated[float, "rad"]
        road_wheel_rate: Annotated[float, "rad/s"]
        self_aligning_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        """Torque of the actuator."""

        road_wheel_torque: Annotated[float, "N*m"]

    Output = SteerByWire.Output
    Parameters = SteerByWire.Parameters

    @staticmethod
    def derivative(x: State, u: Input, p: SteerByWire.Parameters) -> State:
        """Eq (18), with a constant aligning torque."""
        acceleration = steering_acceleration(x.road_wheel_rate, u.road_wheel_torque, x.self_aligning_torque, p)
        return DisturbedSteering.State(x.road_wheel_rate, acceleration, 0.0)

    @staticmethod
    def output(x: State, u: Input, p: SteerByWire.Parameters) -> SteerByWire.Output:
        """The angle, eq (19)."""
        return SteerByWire.Output(x.road_wheel_angle)
