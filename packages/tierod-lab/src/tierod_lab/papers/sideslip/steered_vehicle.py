"""The vehicle with its steering, eqs (1) to (13), and the effect of uncertain axles on an estimated sideslip angle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import exp, select
from tierod.models.single_track import SingleTrack
from tierod.physics.motion import front_slip_speed, rear_slip_speed
from tierod.vehicles.classes import held_deviation
from tierod.vehicles.vehicle import Vehicle
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

    Source: Yih, Ryu, Gerdes, eqs (3) and (12); (12) follows from (7) and (8), printed "(8) and (9)".
    """
    front, _ = SingleTrack.axle_forces(x, u, p)
    return (p.mechanical_trail + p.pneumatic_trail) * front


TORQUE_SHARE = 0.35
"""Share of a relative trail error that reaches the sideslip angle, over the front slip angle [-]; measured for
observers with placed poles and a trail that is half too long, those with Kalman gains are less affected (virtual car,
25 m/s)."""


class Slips(NamedTuple):
    """Slip angles of both axles, without and with the lag of the tyres' relaxation length."""

    front: Annotated[Scalar, "rad"]
    rear: Annotated[Scalar, "rad"]
    front_late: Annotated[Scalar, "rad"]
    rear_late: Annotated[Scalar, "rad"]


@dataclass(frozen=True)
class Axles:
    """Uncertainty of the axles: errors of the slip angles are in proportion to errors of stiffness and trail."""

    # front_distance, rear_distance: distances of the axles from the centre of gravity
    front_distance: Annotated[float, "m", POSITIVE]
    rear_distance: Annotated[float, "m", POSITIVE]
    sample_time: Annotated[float, "s", POSITIVE]  # sampling interval
    # front_stiffness_deviation, rear_stiffness_deviation: relative standard deviations of the cornering stiffness
    front_stiffness_deviation: Annotated[float, "", NOT_NEGATIVE] = 0.1
    rear_stiffness_deviation: Annotated[float, "", NOT_NEGATIVE] = 0.1
    # relative standard deviation of mechanical and pneumatic trail together
    trail_deviation: Annotated[float, "", NOT_NEGATIVE] = 0.15
    # front_relaxation, rear_relaxation: relaxation lengths of the tyres, which the observers of the paper neglect
    front_relaxation: Annotated[float, "m", POSITIVE] = 0.4
    rear_relaxation: Annotated[float, "m", POSITIVE] = 0.4

    def follow(
        self,
        before: Slips,
        sideslip_angle: Scalar,
        yaw_rate: Scalar,
        road_wheel_angle: Scalar,
        speed: Scalar,
        running: Scalar,
    ) -> Slips:
        """Slip angles after one sample; held where the observer does not run."""
        across = speed * sideslip_angle
        front = front_slip_speed(across, yaw_rate, speed, road_wheel_angle, self.front_distance) / speed
        rear = rear_slip_speed(across, yaw_rate, self.rear_distance) / speed
        rolled = speed * self.sample_time
        after = Slips(
            front,
            rear,
            front + exp(-rolled / self.front_relaxation) * (before.front_late - front),
            rear + exp(-rolled / self.rear_relaxation) * (before.rear_late - rear),
        )
        return select(running, after, before)

    def variance(self, slips: Slips) -> Scalar:
        """Variance of the sideslip angle [rad2] from errors of stiffness and trail and from neglected tyre lag."""
        errors = (
            self.front_stiffness_deviation * slips.front,
            self.rear_stiffness_deviation * slips.rear,
            TORQUE_SHARE * self.trail_deviation * slips.front,
            slips.front - slips.front_late,
            slips.rear - slips.rear_late,
        )
        return sum((error * error for error in errors[1:]), errors[0] * errors[0])

    def of_vehicle(self, vehicle: Vehicle) -> Axles:
        """These axles with the standard deviations and relaxation lengths that a vehicle file gives."""
        found: dict[str, float] = {}
        for axle in ("front", "rear"):
            if spread := held_deviation(vehicle, f"{axle}_cornering_stiffness"):
                found[f"{axle}_stiffness_deviation"] = spread / vehicle[f"{axle}_cornering_stiffness"]
        trails = ("mechanical_trail", "pneumatic_trail")
        if spread := math.hypot(*(held_deviation(vehicle, name) for name in trails)):
            found["trail_deviation"] = spread / sum(vehicle[name] for name in trails)
        if "relaxation_length" in vehicle:
            found["front_relaxation"] = found["rear_relaxation"] = vehicle["relaxation_length"]
            if "rear_relaxation_ratio" in vehicle:
                found["rear_relaxation"] *= vehicle["rear_relaxation_ratio"]
        return replace(self, **found)
