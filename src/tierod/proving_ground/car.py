"""The virtual car: EPS column, single track with brush tyres, and its driver, as one block at 1 kHz."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.block import Ring
from tierod.graph.maths import absolute, arctan2, cos, exp, limit, maximum, where
from tierod.physics import single_track
from tierod.physics.assist import assist_torque
from tierod.physics.friction import dahl_power_update, dahl_update, viscous
from tierod.physics.steering_ratio import (
    column_torque_of_motor,
    road_wheel_angle,
    torque_at_steering_wheel,
    variable_ratio,
)
from tierod.physics.torsion_bar import torsion_bar_torque
from tierod.physics.tyre import brush_aligning_torque, brush_lateral_force, relaxation_rate
from tierod.proving_ground.car_signals import Motion, Output, State, Surroundings, Wheel
from tierod.proving_ground.integration import runge_kutta
from tierod.proving_ground.parameters import AssistMap, Chassis, Driver, Steering, TorsionBar


class _Forces(NamedTuple):
    hand_torque: Any
    driver_torque: Any
    friction: Any
    scrub: Any
    self_aligning_torque: Any
    front_force: Any
    rear_force: Any
    column_acceleration: Any


@dataclass(frozen=True)
class EpsCar:
    """A car with column EPS on a road; friction level, speed and road come from outside.

    Dry friction follows the steering angle, not time, so it enters the Runge-Kutta stages as Dahl's exact solution over
    the angle since the last step. Equations: Mohtat et al., eqs (2) and (3), with brush tyres and relaxation.

    Args:
        chassis: body and tyres
        steering: column, gear, motor
        assist: characteristic of the motor
        driver: who steers
        torsion_bar: elastic bar below the steering wheel, None for a rigid column
        step_time: step of the integration
    """

    chassis: Chassis = field(default_factory=Chassis)
    steering: Steering = field(default_factory=Steering)
    assist: AssistMap = field(default_factory=AssistMap)
    driver: Driver = field(default_factory=Driver)
    torsion_bar: TorsionBar | None = None
    step_time: Annotated[float, "s"] = 1e-3

    Sample = Surroundings

    def init(self) -> State:
        """Straight ahead, at rest, friction relaxed."""
        wheel = () if self.torsion_bar is None else Wheel(0.0, 0.0)
        motion = Motion._make([*[0.0] * 12, wheel])
        return State(motion, 0.0, 0.0, Ring(self.driver.delay_steps))

    def step(self, state: State, sample: Surroundings) -> tuple[State, Output]:
        """One step on; the output belongs to the instant of the sample."""
        start = state.motion.column_angle
        seen_offset = state.seen_offset.oldest

        def derivative(motion: Motion) -> Motion:
            forces = self._forces(motion, state, sample, motion.column_angle - start)
            return self._derivative(motion, forces, sample, seen_offset)

        motion = runge_kutta(derivative, state.motion, self.step_time)
        friction, scrub = self._resistances(state, motion.column_angle - start)
        rolled = absolute(sample.vehicle_speed) * self.step_time / self.chassis.relaxation_length
        after = State(
            motion, friction, scrub * exp(-rolled), state.seen_offset.push(self._offset_ahead(motion, sample))
        )
        return after, self._output(state, sample)

    def _resistances(self, state: State, turned: Any) -> tuple[Any, Any]:
        steering = self.steering
        friction = dahl_power_update(state.friction, turned, steering.dahl_angle, steering.dahl_exponent)
        return friction, dahl_update(state.scrub, turned, steering.scrub_angle)

    def _forces(self, motion: Motion, state: State, sample: Surroundings, turned: Any) -> _Forces:
        chassis, steering = self.chassis, self.steering
        friction, scrub = self._resistances(state, turned)
        friction = sample.friction_torque * friction
        standing = exp(-((sample.vehicle_speed / steering.scrub_fade_speed) ** 2)) * sample.on_ground
        ratio = variable_ratio(motion.column_angle, steering.ratio, steering.ratio_growth)
        scrub = torque_at_steering_wheel(chassis.parking_torque * standing * scrub, ratio)
        front_slip = motion.front_deflection / chassis.relaxation_length
        rear_slip = motion.rear_deflection / chassis.relaxation_length
        front_tyre = (chassis.front_stiffness, chassis.adhesion, chassis.front_load)
        front_force = brush_lateral_force(front_slip, *front_tyre)
        rear_force = brush_lateral_force(rear_slip, chassis.rear_stiffness, chassis.adhesion, chassis.rear_load)
        self_aligning_torque = chassis.mechanical_trail * front_force + brush_aligning_torque(
            front_slip, *front_tyre, chassis.contact_half_length
        )
        hand_torque = self._hand_torque(motion)
        driver_torque = hand_torque if self.torsion_bar is None else self._bar_torque(motion)
        resistance = friction + scrub + torque_at_steering_wheel(self_aligning_torque, ratio)
        drive = driver_torque + column_torque_of_motor(motion.motor_torque, steering.motor_gear)
        inertia = steering.inertia if self.torsion_bar is None else steering.inertia - self.torsion_bar.wheel_inertia
        acceleration = (drive - resistance - viscous(motion.column_rate, steering.damping)) / inertia
        return _Forces(
            hand_torque, driver_torque, friction, scrub, self_aligning_torque, front_force, rear_force, acceleration
        )

    def _derivative(self, motion: Motion, forces: _Forces, sample: Surroundings, seen_offset: Any) -> Motion:
        chassis, driver, speed = self.chassis, self.driver, sample.vehicle_speed
        steer = self._road_wheel_angle(motion)
        front_force = forces.front_force * cos(steer)
        acceleration = single_track.lateral_acceleration(front_force, forces.rear_force, chassis.mass)
        front_slip_speed = single_track.front_slip_speed(
            motion.lateral_speed, motion.yaw_rate, speed, steer, chassis.front_distance
        )
        rear_slip_speed = single_track.rear_slip_speed(motion.lateral_speed, motion.yaw_rate, chassis.rear_distance)
        wanted_angle = self._wanted_angle(sample, seen_offset) + motion.persistent_angle
        lag = driver.muscle_time
        return Motion(
            column_angle=motion.column_rate,
            column_rate=forces.column_acceleration,
            motor_torque=(self._assist(motion, forces, speed) - motion.motor_torque) / self.steering.motor_lag,
            lateral_speed=acceleration - speed * motion.yaw_rate,
            yaw_rate=single_track.yaw_acceleration(
                front_force,
                forces.rear_force,
                chassis.yaw_inertia,
                chassis.front_distance,
                chassis.rear_distance,
            ),
            front_deflection=relaxation_rate(
                motion.front_deflection, front_slip_speed, speed, chassis.relaxation_length
            ),
            rear_deflection=relaxation_rate(motion.rear_deflection, rear_slip_speed, speed, chassis.relaxation_length),
            muscle_angle=motion.muscle_rate,
            muscle_rate=((wanted_angle - motion.muscle_angle) / lag - 2.0 * motion.muscle_rate) / lag,
            persistent_angle=driver.persistence * (sample.steering_demand - self._hand_angle(motion)),
            lateral_offset=self._offset_rate(motion, speed),
            heading_error=motion.yaw_rate - sample.road_curvature * speed,
            wheel=self._wheel_derivative(motion, forces),
        )

    def _wheel_derivative(self, motion: Motion, forces: _Forces) -> Any:
        if self.torsion_bar is None:
            return ()
        torque = forces.hand_torque - forces.driver_torque
        return Wheel(motion.wheel.rate, torque / self.torsion_bar.wheel_inertia)

    def _assist(self, motion: Motion, forces: _Forces, speed: Any) -> Any:
        chart, felt = self.assist, forces.driver_torque
        if self.torsion_bar is not None:
            twist_rate = motion.wheel.rate - motion.column_rate
            felt = felt + chart.lead_time * self.torsion_bar.stiffness * twist_rate
        torque = assist_torque(
            felt,
            speed,
            chart.linear_gain,
            chart.quadratic_gain,
            chart.dead_band,
            chart.half_speed,
            chart.maximum_torque,
        )
        return torque / self.steering.motor_gear

    def _hand_angle(self, motion: Motion) -> Any:
        return motion.column_angle if self.torsion_bar is None else motion.wheel.angle

    def _hand_rate(self, motion: Motion) -> Any:
        return motion.column_rate if self.torsion_bar is None else motion.wheel.rate

    def _hand_torque(self, motion: Motion) -> Any:
        driver = self.driver
        torque = driver.arm_stiffness * (motion.muscle_angle - self._hand_angle(motion))
        torque = torque + driver.arm_damping * (motion.muscle_rate - self._hand_rate(motion))
        return limit(torque, -driver.torque_limit, driver.torque_limit)

    def _bar_torque(self, motion: Motion) -> Any:
        bar = self.torsion_bar
        assert bar is not None
        return torsion_bar_torque(
            motion.wheel.angle, motion.column_angle, bar.stiffness, motion.wheel.rate, motion.column_rate, bar.damping
        )

    def _road_wheel_angle(self, motion: Motion) -> Any:
        return road_wheel_angle(motion.column_angle, self.steering.ratio, self.steering.ratio_growth)

    def _offset_rate(self, motion: Motion, speed: Any) -> Any:
        return speed * motion.heading_error + motion.lateral_speed

    def _offset_ahead(self, motion: Motion, sample: Surroundings) -> Any:
        return motion.lateral_offset + self.driver.preview_time * self._offset_rate(motion, sample.vehicle_speed)

    def _wanted_angle(self, sample: Surroundings, seen_offset: Any) -> Any:
        chassis, driver = self.chassis, self.driver
        reach = driver.preview_time * maximum(sample.vehicle_speed, 3.0)
        curvature = -2.0 * driver.correction * seen_offset / (reach * reach)
        steer = single_track.steady_road_wheel_angle(
            curvature, sample.vehicle_speed, chassis.wheelbase, chassis.understeer_gradient
        )
        return sample.steering_demand + steer / self.steering.ratio

    def _output(self, state: State, sample: Surroundings) -> Output:
        motion, chassis = state.motion, self.chassis
        forces = self._forces(motion, state, sample, 0.0)
        front_force = forces.front_force * cos(self._road_wheel_angle(motion))
        rolling = sample.vehicle_speed > 0.5
        sideslip = arctan2(motion.lateral_speed, where(rolling, sample.vehicle_speed, 1.0))
        acceleration = forces.column_acceleration
        if self.torsion_bar is not None:
            acceleration = (forces.hand_torque - forces.driver_torque) / self.torsion_bar.wheel_inertia
        return Output(
            steering_wheel_angle=self._hand_angle(motion),
            steering_wheel_rate=self._hand_rate(motion),
            driver_torque=forces.driver_torque,
            motor_torque=motion.motor_torque,
            yaw_rate=motion.yaw_rate,
            lateral_acceleration=single_track.lateral_acceleration(front_force, forces.rear_force, chassis.mass),
            vehicle_speed=sample.vehicle_speed,
            truth_friction_torque=sample.friction_torque,
            truth_friction_resistance=forces.friction,
            truth_scrub_resistance=forces.scrub,
            truth_self_aligning_torque=forces.self_aligning_torque,
            truth_front_lateral_force=forces.front_force,
            truth_sideslip=where(rolling, sideslip, 0.0),
            truth_steering_wheel_acceleration=acceleration,
            truth_lateral_offset=motion.lateral_offset,
        )
