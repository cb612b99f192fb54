"""The vehicle with its steering: eqs (1) to (13)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.models.single_track import SingleTrack
from tierod_lab.ground.steering.road_wheels import SteerByWire, steering_acceleration


@dataclass(frozen=True)
class Trails:
    """Distances behind the kingpin axis at which the lateral force of the front tyres acts."""

    mechanical_trail: Annotated[float, "m"]  # of the steering geometry, t_m
    pneumatic_trail: Annotated[float, "m"]  # of the tyres, t_p


class SteeredVehicle:
    """Single-track vehicle with a steer-by-wire steering, coupled by the aligning torque.

    Validity: small slip angles, constant trail; vehicle_speed above zero, where slip angles are undefined.
    Source: Yih, Ryu, Gerdes, eqs (12), (13) and (15).
    """

    class State(NamedTuple):
        sideslip_angle: Annotated[float, "rad"]
        yaw_rate: Annotated[float, "rad/s"]
        road_wheel_angle: Annotated[float, "rad"]
        road_wheel_rate: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        road_wheel_torque: Annotated[float, "N*m"]
        vehicle_speed: Annotated[float, "m/s"]

    class Output(NamedTuple):
        yaw_rate: Annotated[float, "rad/s"]
        road_wheel_angle: Annotated[float, "rad"]

    @dataclass(frozen=True)
    class Parameters(SteerByWire.Parameters, Trails, SingleTrack.Parameters):
        """Parameters of the vehicle, its trails and its steering."""

    @staticmethod
    def derivative(x: State, u: Input, p: Parameters) -> State:
        own, steer = SteeredVehicle.parts(x, u)
        vehicle = SingleTrack.derivative(own, steer, p)
        resisting = aligning_torque(own, steer, p)
        acceleration = steering_acceleration(x.road_wheel_rate, u.road_wheel_torque, resisting, p)
        return SteeredVehicle.State(*vehicle, x.road_wheel_rate, acceleration)

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        return SteeredVehicle.Output(x.yaw_rate, x.road_wheel_angle)

    @staticmethod
    def parts(x: State, u: Input) -> tuple[SingleTrack.State, SingleTrack.Input]:
        """State and input of the vehicle without its steering."""
        return (
            SingleTrack.State(x.sideslip_angle, x.yaw_rate),
            SingleTrack.Input(x.road_wheel_angle, u.vehicle_speed),
        )


class TorqueShownVehicle:
    """The single-track vehicle with yaw rate and aligning torque as measurements.

    Validity: as `SingleTrack`, with constant trail. Source: Yih, Ryu, Gerdes, eqs (9) and (23).
    """

    State = SingleTrack.State
    Input = SingleTrack.Input

    class Output(NamedTuple):
        yaw_rate: Annotated[float, "rad/s"]
        self_aligning_torque: Annotated[float, "N*m"]

    @dataclass(frozen=True)
    class Parameters(Trails, SingleTrack.Parameters):
        """Parameters of the vehicle and its trails."""

    @staticmethod
    def derivative(x: SingleTrack.State, u: SingleTrack.Input, p: Parameters) -> SingleTrack.State:
        return SingleTrack.derivative(x, u, p)

    @staticmethod
    def output(x: SingleTrack.State, u: SingleTrack.Input, p: Parameters) -> Output:
        return TorqueShownVehicle.Output(x.yaw_rate, aligning_torque(x, u, p))


def aligning_torque(
    x: SingleTrack.State, u: SingleTrack.Input, p: SteeredVehicle.Parameters | TorqueShownVehicle.Parameters
) -> Scalar:
    """Aligning torque of both front tyres about the kingpins [N*m], which opposes positive steer.

    Args:
        p: its parameters, with `Trails`

    Source: Yih, Ryu, Gerdes, eqs (3) and (12); (12) follows from (7) and (8), printed "(8) and (9)".
    """
    front, _ = SingleTrack.axle_forces(x, u, p)
    return (p.mechanical_trail + p.pneumatic_trail) * front
