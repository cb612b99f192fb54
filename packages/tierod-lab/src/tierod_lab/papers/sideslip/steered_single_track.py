"""The single track with the front force across the steered wheels: eq (6) with the cosine of the steer."""

from __future__ import annotations

from tierod.core.graph.maths import cos
from tierod.models.single_track import SingleTrack
from tierod.models.steer_by_wire import steering_acceleration
from tierod.physics.single_track import lateral_acceleration, yaw_acceleration
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle, aligning_torque


class TurnedSingleTrack(SingleTrack):
    """`SingleTrack` with a front force across the wheels instead of across the body.

    Slip angles stay small and linear in the steer, as in the paper; the cosine of the steer is an effect of second
    order.

    Validity: small slip angles; steer to about 0.5 rad. The drag F_f sin(delta) of the front force is neglected, as in
    the paper. Source: Yih, Ryu, Gerdes, eqs (6) to (8), before cos(delta) is set to one in eq (9).
    """

    @staticmethod
    def derivative(x: SingleTrack.State, u: SingleTrack.Input, p: SingleTrack.Parameters) -> SingleTrack.State:
        front, rear = SingleTrack.axle_forces(x, u, p)
        across = front * cos(u.road_wheel_angle)
        sideslip_rate = lateral_acceleration(across, rear, p.mass) / u.vehicle_speed - x.yaw_rate
        return SingleTrack.State(
            sideslip_rate, yaw_acceleration(across, rear, p.yaw_inertia, p.front_distance, p.rear_distance)
        )

    @staticmethod
    def output(x: SingleTrack.State, u: SingleTrack.Input, p: SingleTrack.Parameters) -> SingleTrack.Output:
        front, rear = SingleTrack.axle_forces(x, u, p)
        across = front * cos(u.road_wheel_angle)
        return SingleTrack.Output(x.yaw_rate, lateral_acceleration(across, rear, p.mass))


class TurnedSteeredVehicle(SteeredVehicle):
    """`SteeredVehicle` on `TurnedSingleTrack`; the aligning torque is that of the force across the wheels, eq (3)."""

    @staticmethod
    def derivative(
        x: SteeredVehicle.State, u: SteeredVehicle.Input, p: SteeredVehicle.Parameters
    ) -> SteeredVehicle.State:
        own, steer = SteeredVehicle.parts(x, u)
        resisting = aligning_torque(own, steer, p)
        acceleration = steering_acceleration(x.road_wheel_rate, u.road_wheel_torque, resisting, p)
        return SteeredVehicle.State(*TurnedSingleTrack.derivative(own, steer, p), x.road_wheel_rate, acceleration)
