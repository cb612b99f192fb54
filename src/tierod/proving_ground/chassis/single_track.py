"""The light chassis: both wheels of an axle as one, brush tyres, no roll."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.graph.maths import cos, limit, maximum, sin
from tierod.physics import single_track
from tierod.physics.aerodynamics import air_forces
from tierod.physics.rolling import holding_friction, rolling_resistance
from tierod.physics.tyre import (
    bounded_relaxation_rate,
    brush_aligning_torque,
    brush_lateral_force,
    parking_torque,
    relaxation_speed,
    twist_rate,
)
from tierod.proving_ground.parts import Reaction, Road, Steer, Wheels, Wind
from tierod.ranges import NOT_NEGATIVE, POSITIVE

GRAVITY = 9.81
TREAD_LAG = 1e-3
"""Of the tread against the rim [s]: keeps a sliding tyre within what a step of 1 ms can follow."""


class SingleTrackMotion(NamedTuple):
    """What the differential equations of the single track carry on."""

    speed: Any
    lateral_speed: Any
    yaw_rate: Any
    front_deflection: Any
    rear_deflection: Any
    twist: Any
    longitudinal_force: Any


class _Balance(NamedTuple):
    """What the derivative needs of a reaction: finished rates, and the forces along the body without the tyres'."""

    rates: SingleTrackMotion
    driving: Any
    resistance: Any
    adhesion_limit: Any


@dataclass(frozen=True)
class SingleTrack:
    """Body and tyres of the single track; stiffness of an axle, trail and contact length of a wheel.

    Loads stay what they are at rest. The tyres' longitudinal force follows the torques with a lag and does not weaken
    the lateral one. Equations: Mohtat et al., eq (3), with brush tyres, relaxation and free speed. Unless said
    otherwise a value is typical of a mid-size car; the paper of Mohtat et al. prints none.

    Args:
        adhesion: of the tyres on a road of adhesion 1
        relaxation_length: rolled distance over which lateral force builds up
        greatest_slip: tangent of the slip angle that a sliding tyre is taken to have at most
        contact_half_length: half the contact length; a third of it is the pneumatic trail
        twist_angle: angle over which the scrub torque of a standing tyre builds up
        twist_length: rolled distance over which it fades, about that of a brush model with the width of the patch
        weight_lever: torque about a kingpin per load and sine of the steer, from lifting the car
        force_lag: of the longitudinal force behind the torques
    """

    mass: Annotated[float, "kg", POSITIVE] = 1600.0
    yaw_inertia: Annotated[float, "kg*m**2", POSITIVE] = 2800.0
    front_distance: Annotated[float, "m", POSITIVE] = 1.14
    rear_distance: Annotated[float, "m", POSITIVE] = 1.69
    track: Annotated[float, "m", POSITIVE] = 1.55
    wheel_radius: Annotated[float, "m", POSITIVE] = 0.31
    front_stiffness: Annotated[float, "N/rad", POSITIVE] = 110e3
    rear_stiffness: Annotated[float, "N/rad", POSITIVE] = 130e3
    adhesion: Annotated[float, "", POSITIVE] = 1.0
    relaxation_length: Annotated[float, "m", POSITIVE] = 0.3
    greatest_slip: Annotated[float, "", POSITIVE] = 0.4
    mechanical_trail: Annotated[float, "m"] = 0.025
    contact_half_length: Annotated[float, "m", POSITIVE] = 0.075
    tyre_pressure: Annotated[float, "Pa", POSITIVE] = 2.2e5
    twist_angle: Annotated[float, "rad", POSITIVE] = math.radians(2.0)
    twist_length: Annotated[float, "m", POSITIVE] = 0.05
    weight_lever: Annotated[float, "m"] = 0.012
    rolling_coefficient: Annotated[float, "", NOT_NEGATIVE] = 0.010
    drag_area: Annotated[float, "m**2", NOT_NEGATIVE] = 0.65
    side_area: Annotated[float, "m**2", NOT_NEGATIVE] = 5.0
    side_force_lead: Annotated[float, "m"] = 0.5
    force_lag: Annotated[float, "s", POSITIVE] = 0.01

    @property
    def wheelbase(self) -> float:
        """Distance of the axles [m]."""
        return self.front_distance + self.rear_distance

    @property
    def front_load(self) -> float:
        """Static load of the front axle [N]."""
        return single_track.front_axle_load(self.mass, self.front_distance, self.rear_distance)

    @property
    def rear_load(self) -> float:
        """Static load of the rear axle [N]."""
        return single_track.front_axle_load(self.mass, self.rear_distance, self.front_distance)

    @property
    def understeer_gradient(self) -> float:
        """Extra road-wheel angle per lateral acceleration [rad*s**2/m]."""
        return single_track.understeer_gradient(
            self.mass, self.front_distance, self.rear_distance, self.front_stiffness, self.rear_stiffness
        )

    def init(self, speed: float) -> SingleTrackMotion:
        """Rolling straight ahead on level ground at a speed [m/s]."""
        return SingleTrackMotion(speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def reaction(self, motion: SingleTrackMotion, steer: Steer, road: Road, wind: Wind) -> Reaction:
        """Forces, accelerations and kingpin torques in a state of motion."""
        angle, angle_rate = 0.5 * (steer.left + steer.right), 0.5 * (steer.left_rate + steer.right_rate)
        sine, cosine = sin(angle), cos(angle)
        adhesion = self.adhesion * maximum(0.5 * (road.adhesion_left + road.adhesion_right), 1e-3)
        front_slip = motion.front_deflection / self.relaxation_length
        front_tyre = (self.front_stiffness, adhesion, self.front_load)
        front_force = road.support * brush_lateral_force(front_slip, *front_tyre)
        aligning = road.support * brush_aligning_torque(front_slip, *front_tyre, self.contact_half_length)
        rear_force = road.support * brush_lateral_force(
            motion.rear_deflection / self.relaxation_length, self.rear_stiffness, adhesion, self.rear_load
        )
        scrub = road.support * self._parking_torque(adhesion) * motion.twist / self.twist_angle
        self_aligning = aligning + self.mechanical_trail * front_force
        kingpin = 0.5 * (self_aligning + scrub + road.support * self.front_load * self.weight_lever * sine)
        across = cosine * front_force
        air = air_forces(
            motion.speed + wind.headwind_speed,
            motion.lateral_speed - wind.crosswind_speed,
            self.drag_area,
            self.side_area,
            self.side_force_lead,
        )
        lateral = single_track.lateral_acceleration(across, rear_force + road.support * air.lateral, self.mass)
        yaw_acceleration = (
            single_track.yaw_acceleration(across, rear_force, self.yaw_inertia, self.front_distance, self.rear_distance)
            + road.support * air.yaw_moment / self.yaw_inertia
        )
        drag = road.support * air.longitudinal - sine * front_force
        balance = self._balance(motion, (sine, cosine, angle_rate), road, (lateral, yaw_acceleration, drag, adhesion))
        return Reaction(
            speed=motion.speed,
            lateral_speed=motion.lateral_speed,
            yaw_rate=motion.yaw_rate,
            yaw_acceleration=yaw_acceleration,
            longitudinal_acceleration=(motion.longitudinal_force + drag) / self.mass,
            lateral_acceleration=lateral,
            roll_angle=0.0,
            roll_rate=0.0,
            roll_acceleration=0.0,
            kingpin_left=kingpin,
            kingpin_right=kingpin,
            front_lateral_force=across,
            rear_lateral_force=rear_force,
            front_slip_angle=front_slip,
            loads=self._loads(road),
            wheel_speeds=self._wheel_speeds(motion, sine, cosine),
            self_aligning_torque=self_aligning,
            scrub_torque=scrub,
            private=balance,
        )

    def derivative(
        self, motion: SingleTrackMotion, reaction: Reaction, torques: Wheels, brakes: Wheels
    ) -> SingleTrackMotion:
        """Rate of change of the motion, see `tierod.proving_ground.parts.Chassis`."""
        balance: _Balance = reaction.private
        drive = sum(torques) / self.wheel_radius
        greatest = sum(brakes) / self.wheel_radius + balance.resistance
        held = holding_friction(motion.speed, balance.driving + drive, greatest, self.mass, 4.0 * self.force_lag)
        wanted = limit(drive - held, -balance.adhesion_limit, balance.adhesion_limit)
        return balance.rates._replace(longitudinal_force=(wanted - motion.longitudinal_force) / self.force_lag)

    def _balance(self, motion: SingleTrackMotion, steer: tuple, road: Road, forces: tuple) -> _Balance:
        sine, cosine, angle_rate = steer
        lateral, yaw_acceleration, drag, adhesion = forces
        gravity = road.support * GRAVITY
        driving = drag - self.mass * gravity * sin(road.grade_angle)
        front_across = motion.lateral_speed + self.front_distance * motion.yaw_rate
        rear_slip_speed = single_track.rear_slip_speed(motion.lateral_speed, motion.yaw_rate, self.rear_distance)
        front_rolling = cosine * motion.speed + sine * front_across
        rates = SingleTrackMotion(
            speed=(motion.longitudinal_force + driving) / self.mass + motion.lateral_speed * motion.yaw_rate,
            lateral_speed=lateral - motion.speed * motion.yaw_rate - gravity * sin(road.bank_angle),
            yaw_rate=yaw_acceleration,
            front_deflection=self._deflection_rate(
                motion.front_deflection, sine * motion.speed - cosine * front_across, front_rolling
            ),
            rear_deflection=self._deflection_rate(motion.rear_deflection, rear_slip_speed, motion.speed),
            twist=twist_rate(
                motion.twist, angle_rate + motion.yaw_rate, front_rolling, self.twist_angle, self.twist_length
            ),
            longitudinal_force=0.0,
        )
        weight = self.mass * gravity
        return _Balance(rates, driving, rolling_resistance(weight, self.rolling_coefficient), adhesion * weight)

    def _deflection_rate(self, deflection: Any, slip_speed: Any, rolling_speed: Any) -> Any:
        speed = relaxation_speed(rolling_speed * rolling_speed, slip_speed * slip_speed, self.greatest_slip)
        return bounded_relaxation_rate(deflection, slip_speed, speed, self.relaxation_length, TREAD_LAG)

    def _parking_torque(self, adhesion: Any) -> Any:
        """About both kingpins [N*m]."""
        return 2.0 * parking_torque(0.5 * self.front_load, adhesion, self.tyre_pressure)

    def _loads(self, road: Road) -> Wheels:
        front, rear = (0.5 * road.support * load for load in (self.front_load, self.rear_load))
        return Wheels(front, front, rear, rear)

    def _wheel_speeds(self, motion: SingleTrackMotion, sine: Any, cosine: Any) -> Wheels:
        half = 0.5 * self.track * motion.yaw_rate
        across = sine * (motion.lateral_speed + self.front_distance * motion.yaw_rate)
        return Wheels(
            cosine * (motion.speed - half) + across,
            cosine * (motion.speed + half) + across,
            motion.speed - half,
            motion.speed + half,
        )
