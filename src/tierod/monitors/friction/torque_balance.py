"""Both sides of the torque balance of the default friction estimator, and the row of its regression."""

from __future__ import annotations

from typing import Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, maximum, sin
from tierod.methods.estimators.linear_algebra import dot
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.conditioning import ConditionedSteering
from tierod.monitors.friction.presliding_tuning import Coefficients
from tierod.physics.aligning import force_across_wheels, front_force_from_motion, longitudinal_force_from_motion
from tierod.physics.friction_build_up import BuildUp
from tierod.physics.kingpin import weight_torque
from tierod.physics.single_track import front_axle_load
from tierod.physics.steering_ratio import (
    column_torque_of_motor,
    road_wheel_angle,
    torque_at_steering_wheel,
    torsion_bar_twist,
)
from tierod.physics.tyre import turn_slip


class ColumnMotion(NamedTuple):
    """Motion of the column below the torsion bar.

    Args:
        angle: column angle [rad]
        increment: change of the angle since the previous sample [rad]
        rate: column rate [rad/s]
        acceleration: column acceleration [rad/s**2]
    """

    angle: Scalar
    increment: Scalar
    rate: Scalar
    acceleration: Scalar


def column_motion(clean: ConditionedSteering, stiffness: Scalar, sample_time: Any) -> ColumnMotion:
    """Motion of the steering wheel less the twist of the torsion bar.

    Angle and torque have passed the same low-pass and the same difference, so that twist and angle have equal delay.

    Args:
        clean: conditioned signals
        stiffness: stiffness of the bar [N*m/rad]; infinite for a rigid one
        sample_time: time between two samples [s]
    """
    signals = clean.signals
    twist_rate = torsion_bar_twist(clean.driver_torque_rate, stiffness)
    return ColumnMotion(
        signals.steering_wheel_angle - torsion_bar_twist(signals.driver_torque, stiffness),
        clean.angle_increment - sample_time * twist_rate,
        signals.steering_wheel_rate - twist_rate,
        clean.steering_wheel_acceleration - torsion_bar_twist(clean.driver_torque_acceleration, stiffness),
    )


ROLLING_SPEED = 3.0
"""Speed of the vehicle below which tyres scrub, which the balance does not model [m/s]."""


def reference_load(p: FrictionParameters, lever: Scalar) -> Scalar:
    """Torque of the road at the steering wheel [N*m] for which friction is stated.

    Args:
        p: parameters of the vehicle
        lever: lever of the front axle load about the kingpins [m]
    """
    load = front_axle_load(p.mass, p.front_distance, p.rear_distance)
    return torque_at_steering_wheel(lever * load, p.steering_ratio)


class RoadTorques(NamedTuple):
    """Torques of the road at the steering wheel, each per unit of its coefficient.

    Args:
        aligning: lateral force of the front axle times the trail of the vehicle file [N*m]
        weight: torque of the front axle load per lever [N]
        turn_slip: torque per turn slip stiffness over load [N/m]
        drive: drive and brake force of the whole car, as if all at the front axle, times the trail [N*m]
    """

    aligning: Scalar
    weight: Scalar
    turn_slip: Scalar
    drive: Scalar


class Regressors(NamedTuple):
    """Terms and torques of the balance that pass the second low-pass."""

    finite: Scalar
    finite_sensitivity: Scalar
    exponential: Scalar
    exponential_sensitivity: Scalar
    long: Scalar
    long_sensitivity: Scalar
    aligning_torque: Scalar
    squared_aligning_torque: Scalar
    weight: Scalar
    turn_slip: Scalar
    drive: Scalar
    loaded_friction: Scalar
    rate: Scalar
    acceleration: Scalar
    torque: Scalar
    driver_torque: Scalar
    motor_torque: Scalar
    steering_wheel_rate: Scalar


def regressors(
    clean: ConditionedSteering,
    column: ColumnMotion,
    laws: tuple[BuildUp, BuildUp, BuildUp],
    mean: Coefficients,
    parameters: FrictionParameters,
    reference_load: Scalar,
) -> Regressors:
    """Both sides of the balance before the low-pass.

    Args:
        clean: conditioned signals
        column: motion below the torsion bar
        laws: build-up of friction, exponent 1/2, 1 and 2
        mean: estimated coefficients, which determine the load of the gear
        parameters: parameters of the vehicle
        reference_load: road torque for which friction is stated [N*m]
    """
    signals = clean.signals
    road = road_torques(clean, column, parameters)
    finite, exponential, long = laws
    return Regressors(
        *finite,
        *exponential,
        *long,
        aligning_torque=road.aligning,
        squared_aligning_torque=road.aligning * absolute(road.aligning),
        weight=road.weight,
        turn_slip=road.turn_slip,
        drive=road.drive,
        loaded_friction=exponential.level * (absolute(_load(road, mean)) - reference_load),
        rate=column.rate,
        acceleration=column.acceleration,
        torque=signals.driver_torque + column_torque_of_motor(signals.motor_torque, parameters.motor_ratio),
        driver_torque=signals.driver_torque,
        motor_torque=signals.motor_torque,
        steering_wheel_rate=signals.steering_wheel_rate,
    )


def road_torques(clean: ConditionedSteering, column: ColumnMotion, p: FrictionParameters) -> RoadTorques:
    """Torques of tyres and weight at the steering wheel; they oppose a turn to the left.

    Args:
        clean: conditioned signals
        column: motion below the torsion bar
        p: parameters of the vehicle
    """
    signals = clean.signals
    steer = road_wheel_angle(column.angle, p.steering_ratio)
    across = front_force_from_motion(
        signals.lateral_acceleration,
        clean.yaw_acceleration,
        mass=p.mass,
        yaw_inertia=p.yaw_inertia,
        front_distance=p.front_distance,
        rear_distance=p.rear_distance,
    )
    along = longitudinal_force_from_motion(
        clean.vehicle_acceleration, signals.yaw_rate, mass=p.mass, rear_distance=p.rear_distance
    )
    load = front_axle_load(p.mass, p.front_distance, p.rear_distance)
    turning = road_wheel_angle(column.rate, p.steering_ratio) + signals.yaw_rate
    about_kingpins = RoadTorques(
        aligning=p.trail * force_across_wheels(across, 0.0, steer),
        weight=weight_torque(load, 1.0, sin(steer)),
        # The speed is bounded below, or the turn slip would be infinite at rest.
        turn_slip=load * turn_slip(turning, maximum(signals.vehicle_speed, ROLLING_SPEED)),
        drive=p.trail * force_across_wheels(0.0, along, steer),
    )
    return RoadTorques(*(torque_at_steering_wheel(torque, p.steering_ratio) for torque in about_kingpins))


def _load(road: RoadTorques, mean: Coefficients) -> Scalar:
    """Torque [N*m] that loads gear and joints, by the present estimate of the coefficients."""
    aligning = (mean.aligning_gain + mean.trail_drop * absolute(road.aligning)) * road.aligning
    return aligning + mean.weight_lever * road.weight + mean.turn_slip * road.turn_slip + mean.drive_share * road.drive


def row_of(mean: Coefficients, given: Regressors) -> Coefficients:
    """Row of the regression: derivative of the torque with respect to each coefficient."""
    return Coefficients(
        finite=given.finite,
        exponential=given.exponential,
        long=given.long,
        log_dahl_angle=mean.finite * given.finite_sensitivity
        + mean.exponential * given.exponential_sensitivity
        + mean.long * given.long_sensitivity,
        aligning_gain=given.aligning_torque,
        trail_drop=given.squared_aligning_torque,
        weight_lever=given.weight,
        turn_slip=given.turn_slip,
        drive_share=given.drive,
        load_share=given.loaded_friction,
        offset=1.0,
        damping=given.rate,
        inertia=given.acceleration,
    )


def expected_torque(mean: Coefficients, row: Coefficients) -> Scalar:
    """Torque of the balance [N*m]: linear in every coefficient except the Dahl angle, which acts through build-up."""
    return dot(mean, row._replace(log_dahl_angle=0.0))
