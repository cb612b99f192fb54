"""Bounds, initial deviations and process noise of the state of the whole vehicle's filter."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute
from tierod.methods.estimators.linear_algebra import Vector, pack, unpack
from tierod.models.automated_vehicle import AutomatedVehicle, turning_column
from tierod.monitors.condition.bank.tuning import ModelError
from tierod.physics.lag import gauss_markov_noise

LIMITS = AutomatedVehicle.State(
    *(80.0, 30.0, 10.0, 1.0, 1.0, 20.0, 80.0, 1.0),
    *(600.0, 600.0, 500.0, 1.1, 0.03, 0.15, 1.7, 1.2, 0.03, 0.25, 0.25),
)
"""Bounds of the state estimates; a faulty sensor then cannot drive a filter to infinity, and a wrong hypothesis cannot
explain readings by a bank of thirty degrees, tyres of another size or a motor that loses more than its whole torque
(plus a tenth for the error of a calibration), however much time it has."""


def start_deviations(error: ModelError) -> AutomatedVehicle.State:
    """Standard deviations of the initial state: unknown speed, wheels approximately straight ahead.

    Args:
        error: standard deviations of the model error
    """
    return AutomatedVehicle.State(
        *(20.0, 0.5, 0.5, 0.02, 0.02, 4.0, 2.0, 0.7, error.force, error.force, error.tie_rod + error.standing),
        *(error.loss, error.yaw_rate_offset, error.angle_offset, error.road, error.road),
        *(error.wheel_speed_difference, error.wheel_speed_scale, error.drive_excess),
    )


def process_noise(
    error: ModelError,
    vehicle: AutomatedVehicle.Parameters,
    mean: AutomatedVehicle.State,
    inputs: AutomatedVehicle.Input,
) -> AutomatedVehicle.State:
    """Process noise: variance that each state gains per sample; for the force errors it grows with the forces.

    Args:
        error: standard deviations of the model error
        vehicle: parameters of `AutomatedVehicle`
        mean: state before the sample
        inputs: inputs of the sample
    """
    fading, step = vehicle.fading, vehicle.sample_time
    forces = AutomatedVehicle.forces(mean, inputs, vehicle)
    standing = error.standing / (1.0 + mean.speed * mean.speed)
    rod = vehicle.steering_ratio / vehicle.rack_ratio * absolute(forces.kingpin)

    def white(deviation: Scalar) -> Scalar:
        return deviation * deviation

    def gained(deviation: Scalar, time: Scalar) -> Scalar:
        return gauss_markov_noise(deviation, time, step)

    return AutomatedVehicle.State(
        speed=white(step * error.acceleration),
        lateral_speed=white(step * error.lateral_acceleration),
        yaw_rate=white(step * error.yaw_acceleration),
        front_slip=white(error.slip),
        rear_slip=white(error.slip),
        column_angle=0.0,
        column_rate=0.0,
        friction_share=white(error.friction_share),
        front_force_error=gained(error.force + error.force_share * absolute(forces.front), fading.force),
        rear_force_error=gained(error.force + error.force_share * absolute(forces.rear), fading.force),
        tie_rod_force_error=gained(error.tie_rod + error.tie_rod_share * rod + standing, fading.tie_rod),
        torque_loss=gained(error.loss, fading.loss),
        yaw_rate_offset=gained(error.yaw_rate_offset, fading.offset),
        angle_offset=gained(error.angle_offset, fading.offset),
        grade_acceleration=gained(error.road, fading.road),
        bank_acceleration=gained(error.road, fading.road),
        wheel_speed_difference=gained(error.wheel_speed_difference, fading.offset),
        wheel_speed_scale=gained(error.wheel_speed_scale, fading.share),
        drive_excess=gained(error.drive_excess, fading.share),
    )


def with_torque_noise(covariance: Vector, vehicle: AutomatedVehicle.Parameters, variance: Scalar) -> Vector:
    """Covariance with the effect of an error of the steering torque on column angle and rate.

    Args:
        covariance: packed covariance
        vehicle: parameters of `AutomatedVehicle`
        variance: variance of the mean torque over a sample [N**2*m**2]
    """
    full = unpack(covariance)
    # The torque error is constant over a sample: its effects on angle and rate are fully correlated.
    turning = turning_column(vehicle)
    angle = AutomatedVehicle.State._fields.index("column_angle")
    gain = {angle: turning.angle_per_torque, angle + 1: turning.rate_per_torque}
    for i, first in gain.items():
        for j, second in gain.items():
            full[i][j] = full[i][j] + first * second * variance
    return pack(full)
