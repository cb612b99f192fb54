"""The equations of r1 to r19, without memory: expected readings of the models, and residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.core.block import Scalar
from tierod.core.graph.maths import limit, maximum
from tierod.models.single_track import SingleTrack
from tierod.monitors.condition.signals import Measured
from tierod.physics.motion import lateral_acceleration_of_turning, longitudinal_acceleration
from tierod_lab.papers.condition.rules.adaptive_speed import AdaptiveSpeed
from tierod_lab.papers.condition.rules.parameters import Coefficients, ResidualParameters
from tierod_lab.papers.condition.rules.readings import Motion, SensorResiduals
from tierod_lab.papers.condition.rules.routes import route, steer_of_rolling, wheels_of_forward_speed, wheels_of_mean
from tierod_lab.papers.condition.rules.steering_signals import SteeringSignals

_MOST_STEER = 1.2
"""Bound of the road-wheel angle [rad], so that a faulty sensor cannot carry the routes over the pole of the tangent."""


@dataclass(frozen=True)
class Equations:
    """Expected readings of the models, and the residuals."""

    car: ResidualParameters  # the vehicle
    coefficients: Coefficients  # coefficients of `calibrate_residuals`
    moving: Annotated[float, "m/s"]  # lower bound of a speed in a denominator
    printed: bool  # whether the equations keep their misprints

    def expected(
        self,
        now: Measured,
        steer: SteeringSignals.Output,
        turning: SingleTrack.State,
        forward: AdaptiveSpeed.Output,
        unmeasured: Scalar,
    ) -> Motion:
        """Expected readings of the models.

        Args:
            now: readings, zero where missing
            steer: low-passed signals of the steering and their rates
            unmeasured: column angle from torque and tie-rod force alone [rad]

        Source: Li, Frey, Gauterin, eqs (9) to (12), (46), (47).
        """
        known, car = self.coefficients, self.car
        rolling = steer_of_rolling(now.yaw_rate, now.wheel_speed_rear_left, now.wheel_speed_rear_right, car)
        mean = 0.5 * (now.wheel_speed_rear_left + now.wheel_speed_rear_right)
        if self.printed:
            # Misprints: inverted ratio in eq (9), friction without the sign of the rate in eqs (11) and (46).
            angle = rolling * car.steering_ratio
            friction, about = car.nominal_friction, -car.nominal_friction
        else:
            angle = (rolling + known.understeer * mean * now.yaw_rate) / car.steering_ratio + known.angle_offset
            friction, about = known.friction * steer.direction, known.force_friction * steer.direction
        motion = known.angle * steer.angle + known.rate * steer.rate + known.acceleration * steer.acceleration
        torque = motion + friction
        force = tie_rod_force_of_balance(
            steer.torque, about, car.mass, steer.lateral_acceleration, known.per_mass, known.per_torque
        )
        return Motion(
            turning.sideslip_angle,
            turning.yaw_rate,
            forward.forward_speed,
            torque + known.cornering * steer.lateral_acceleration + known.torque_offset,
            force + known.force_offset,
            angle,
            unmeasured,
        )

    def residuals(
        self,
        now: Measured,
        steer: SteeringSignals.Output,
        angle: Scalar,
        turning: SingleTrack.State,
        forward: AdaptiveSpeed.Output,
        expected: Motion,
    ) -> SensorResiduals:
        """Residuals r1 to r19, valid where their signals are present.

        Args:
            now, steer, turning, forward: as in `expected`
            angle: estimate of the filter of r1 [rad]

        Source: Li, Frey, Gauterin, eqs (6) to (47); see `catalogue` for each.
        """
        left, right = now.wheel_speed_rear_left, now.wheel_speed_rear_right
        rolling = steer_of_rolling(now.yaw_rate, left, right, self.car)
        by_yaw = route(limit(rolling, -_MOST_STEER, _MOST_STEER), self.car)
        turned = self.car.steering_ratio * (now.steering_wheel_angle - self.coefficients.angle_offset)
        by_angle = route(limit(turned, -_MOST_STEER, _MOST_STEER), self.car)
        yaw_left, yaw_right = wheels_of_mean(by_yaw, left, right, misprint=self.printed)
        angle_left, angle_right = wheels_of_mean(by_angle, left, right)
        own_left, own_right = wheels_of_forward_speed(by_yaw, forward.forward_speed)
        other_left, other_right = wheels_of_forward_speed(by_angle, forward.forward_speed)
        along, across = self._accelerations(now, turning, forward)
        filtered = longitudinal_acceleration(
            forward.forward_rate, forward.forward_speed, turning.sideslip_angle, now.yaw_rate
        )
        return SensorResiduals(
            r1=angle - now.steering_wheel_angle,
            r2=expected.angle - now.steering_wheel_angle,
            r3=expected.torque - steer.torque,
            r4=turning.yaw_rate - now.yaw_rate,
            r5=along - now.longitudinal_acceleration,
            r6=across - now.lateral_acceleration,
            r7=yaw_left - left,
            r8=own_left - left,
            r9=angle_left - left,
            r10=other_left - left,
            r11=yaw_right - right,
            r12=own_right - right,
            r13=angle_right - right,
            r14=other_right - right,
            r15=forward.forward_speed - 0.5 * (left + right),
            r16=filtered - now.longitudinal_acceleration,
            r17=turning.sideslip_angle - by_angle.sideslip,
            r18=turning.sideslip_angle - by_yaw.sideslip,
            r19=expected.force - steer.force,
        )

    def _accelerations(
        self, now: Measured, turning: SingleTrack.State, forward: AdaptiveSpeed.Output
    ) -> tuple[Scalar, Scalar]:
        """Longitudinal and lateral acceleration from wheel speeds and single-track model: eqs (18) and (19)."""
        mean = maximum(0.5 * (now.wheel_speed_rear_left + now.wheel_speed_rear_right), self.moving)
        rate = 0.5 * (forward.left_rate + forward.right_rate)
        along = longitudinal_acceleration(rate, mean, turning.sideslip_angle, now.yaw_rate)
        steer = self.car.steering_ratio * (now.steering_wheel_angle - self.coefficients.angle_offset)
        slope = SingleTrack.derivative(turning, SingleTrack.Input(steer, mean), self.car.single_track)
        return along, lateral_acceleration_of_turning(mean, now.yaw_rate, slope.sideslip_angle)


def tie_rod_force_of_balance(
    torque: Scalar, friction: Scalar, mass: Scalar, lateral_acceleration: Scalar, per_mass: Scalar, per_torque: Scalar
) -> Scalar:
    """Force of the tie rods [N] as a weighted sum of lateral acceleration and torque.

    Source: Li, Frey, Gauterin, eq (46), whose friction is printed without the sign of the rate.

    Args:
        torque: at the column [N*m]
        friction: dry friction at the column, with the sign of the rate [N*m]
        mass: of the vehicle [kg]
        lateral_acceleration: [m/s**2]
        per_mass: weight of mass times acceleration [-]
        per_torque: force per torque [1/m]; at most the inverse of the rack's travel per radian
    """
    return per_mass * mass * lateral_acceleration + per_torque * (torque - friction)
