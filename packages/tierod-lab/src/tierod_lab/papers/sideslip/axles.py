"""Uncertain parameters of the axles, and their first-order effect on an estimated sideslip angle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import exp, select
from tierod.physics.motion import front_slip_speed, rear_slip_speed
from tierod.vehicles.classes import held_deviation
from tierod.vehicles.vehicle import Vehicle

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
