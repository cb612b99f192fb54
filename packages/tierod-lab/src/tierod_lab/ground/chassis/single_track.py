"""Single-track chassis: one wheel per axle, brush tyres, no roll."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import limit, maximum, sin, sqrt, where
from tierod.physics import motion as single_track
from tierod.physics.motion import GRAVITY
from tierod.physics.steering import weight_torque
from tierod.physics.tyre import twist_rate
from tierod_lab.ground.chassis.laws import (
    bounded_relaxation_rate,
    brush_aligning_torque,
    brush_lateral_force,
    parking_torque,
    relaxation_speed,
)
from tierod_lab.ground.chassis.two_track import OnTwoAxles
from tierod_lab.ground.chassis.tyres import LEAST_ADHESION, TREAD_LAG, holding_friction, hub, rolling_resistance
from tierod_lab.ground.parts import Reaction, Road, Steer, Wheels, Wind


class SingleTrackMotion(NamedTuple):
    """State of motion of the single-track chassis."""

    speed: Scalar
    lateral_speed: Scalar
    yaw_rate: Scalar
    front_deflection: Scalar
    rear_deflection: Scalar
    twist: Scalar
    longitudinal_force: Scalar


class _Tyres(NamedTuple):
    """Tyre forces of the axles across the body and of both along it [N], with aligning torque and slip in front."""

    front: Scalar
    rear: Scalar
    drag: Scalar
    self_aligning_torque: Scalar
    front_slip: Scalar


class _Balance(NamedTuple):
    rates: SingleTrackMotion
    driving: Scalar
    resistance: Scalar
    adhesion_limit: Scalar


@dataclass(frozen=True)
class SingleTrack(OnTwoAxles):
    """Body and tyres of the single-track model; stiffnesses are per axle, trail and contact length per wheel.

    The wheel loads are constant. The longitudinal tyre force follows the torques with a lag and does not reduce the
    lateral one. Equations: Mohtat et al., eq (3), with brush tyres, relaxation and variable speed. Unless stated
    otherwise a value is typical of a mid-size car; Mohtat et al. print none.
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
    damping_time: Annotated[float, "s", NOT_NEGATIVE] = 0.003
    greatest_slip: Annotated[float, "", POSITIVE] = 0.4
    mechanical_trail: Annotated[float, "m"] = 0.025
    # half the contact length; a third of it is the pneumatic trail
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
    def understeer_gradient(self) -> float:
        """Understeer gradient: additional road-wheel angle per lateral acceleration [rad*s**2/m]."""
        return single_track.understeer_gradient(
            self.mass, self.front_distance, self.rear_distance, self.front_stiffness, self.rear_stiffness
        )

    def init(self, speed: float) -> SingleTrackMotion:
        return SingleTrackMotion(speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def reaction(self, motion: SingleTrackMotion, steer: Steer, road: Road, wind: Wind) -> Reaction:
        """Forces, accelerations and kingpin torques in a state of motion."""
        adhesion = self.adhesion * maximum(0.5 * (road.adhesion_left + road.adhesion_right), LEAST_ADHESION)
        sine, rates, tyres = self._tyres(motion, steer, road, adhesion)
        air = self.air(motion, road, wind)
        scrub = road.support * self._parking_torque(adhesion) * motion.twist / self.twist_angle
        weight = weight_torque(road.support * self.front_load, self.weight_lever, sine)
        kingpin = 0.5 * (tyres.self_aligning_torque + scrub + weight)
        lateral = single_track.lateral_acceleration(tyres.front, tyres.rear + air.lateral, self.mass)
        yaw_moment = single_track.yaw_moment(tyres.front, tyres.rear, self.front_distance, self.rear_distance)
        yaw_acceleration = (yaw_moment + air.yaw_moment) / self.yaw_inertia
        drag = tyres.drag + air.longitudinal
        gravity = road.support * GRAVITY
        driving = drag - self.mass * gravity * sin(road.grade_angle)
        rates = rates._replace(
            speed=(motion.longitudinal_force + driving) / self.mass + motion.lateral_speed * motion.yaw_rate,
            lateral_speed=lateral - motion.speed * motion.yaw_rate - gravity * sin(road.bank_angle),
            yaw_rate=yaw_acceleration,
        )
        resistance = rolling_resistance(self.mass * gravity, self.rolling_coefficient)
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
            front_lateral_force=tyres.front,
            rear_lateral_force=tyres.rear,
            front_slip_angle=tyres.front_slip,
            loads=self._loads(road),
            wheel_speeds=self._wheel_speeds(motion, sine),
            self_aligning_torque=tyres.self_aligning_torque,
            scrub_torque=scrub,
            private=_Balance(rates, driving, resistance, adhesion * self.mass * gravity),
        )

    def derivative(
        self, motion: SingleTrackMotion, reaction: Reaction, torques: Wheels, brakes: Wheels
    ) -> SingleTrackMotion:
        balance: _Balance = reaction.private
        drive = sum(torques) / self.wheel_radius
        greatest = sum(brakes) / self.wheel_radius + balance.resistance
        # A stopping time of four times the lag of the force makes the stop critically damped.
        held = holding_friction(motion.speed, balance.driving + drive, greatest, self.mass, 4.0 * self.force_lag)
        wanted = limit(drive - held, -balance.adhesion_limit, balance.adhesion_limit)
        return balance.rates._replace(longitudinal_force=(wanted - motion.longitudinal_force) / self.force_lag)

    def _tyres(
        self, motion: SingleTrackMotion, steer: Steer, road: Road, adhesion: Scalar
    ) -> tuple[Scalar, SingleTrackMotion, _Tyres]:
        angle, angle_rate = 0.5 * (steer.left + steer.right), 0.5 * (steer.left_rate + steer.right_rate)
        across = motion.lateral_speed + self.front_distance * motion.yaw_rate
        front_hub = hub(angle, motion.speed, across)
        rear_slip_speed = single_track.rear_slip_speed(motion.lateral_speed, motion.yaw_rate, self.rear_distance)
        front_rate = self._deflection_rate(motion.front_deflection, -front_hub.across, front_hub.along)
        rear_rate = self._deflection_rate(motion.rear_deflection, rear_slip_speed, motion.speed)
        turning = angle_rate + motion.yaw_rate
        loaded = twist_rate(motion.twist, turning, front_hub.along, self.twist_angle, self.twist_length)
        twisting = where(road.support > 0.0, loaded, -motion.twist / self.force_lag)
        front_slip = (motion.front_deflection + self.damping_time * front_rate) / self.relaxation_length
        rear_slip = (motion.rear_deflection + self.damping_time * rear_rate) / self.relaxation_length
        front_tyre = (self.front_stiffness, adhesion, self.front_load)
        front_force = road.support * brush_lateral_force(front_slip, *front_tyre)
        rear_force = road.support * brush_lateral_force(rear_slip, self.rear_stiffness, adhesion, self.rear_load)
        aligning = road.support * brush_aligning_torque(front_slip, *front_tyre, self.contact_half_length)
        drag, front_across = front_hub.to_body(0.0, front_force)
        tyres = _Tyres(front_across, rear_force, drag, aligning + self.mechanical_trail * front_force, front_slip)
        return front_hub.sine, SingleTrackMotion(0.0, 0.0, 0.0, front_rate, rear_rate, twisting, 0.0), tyres

    def _deflection_rate(self, deflection: Scalar, slip_speed: Scalar, rolling_speed: Scalar) -> Scalar:
        speed = relaxation_speed(rolling_speed * rolling_speed, slip_speed * slip_speed, self.greatest_slip)
        return bounded_relaxation_rate(deflection, slip_speed, speed, self.relaxation_length, TREAD_LAG)

    def _parking_torque(self, adhesion: Scalar) -> Scalar:
        """Parking torque about both kingpins [N*m]."""
        return 2.0 * parking_torque(0.5 * self.front_load, adhesion, self.tyre_pressure)

    def _loads(self, road: Road) -> Wheels:
        front, rear = (0.5 * road.support * load for load in (self.front_load, self.rear_load))
        return Wheels(front, front, rear, rear)

    def _wheel_speeds(self, motion: SingleTrackMotion, sine: Scalar) -> Wheels:
        half = 0.5 * self.track * motion.yaw_rate
        left, right = motion.speed - half, motion.speed + half
        cosine = sqrt(1.0 - sine * sine)
        across = sine * (motion.lateral_speed + self.front_distance * motion.yaw_rate)
        return Wheels(cosine * left + across, cosine * right + across, left, right)
