"""Signals that friction monitors read, and the estimates of the joint filter from them."""

from __future__ import annotations

from typing import Annotated, NamedTuple


class SteeringSample(NamedTuple):
    """Seven signals of one sample, with the vehicle speed; NaN where one is missing."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    driver_torque: Annotated[float, "N*m"]
    motor_torque: Annotated[float, "N*m"]
    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    vehicle_speed: Annotated[float, "m/s"]


class FrictionSample(NamedTuple):
    """Six signals of one sample, as printed, without the vehicle speed; NaN where one is missing."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    driver_torque: Annotated[float, "N*m"]
    motor_torque: Annotated[float, "N*m"]
    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]


class Innovation(NamedTuple):
    """Measured less predicted value, NaN where not measured."""

    steering_wheel_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    yaw_rate: Annotated[float, "rad/s"]


class InnovationVariance(NamedTuple):
    """Variance of each innovation, as predicted by the filter."""

    steering_wheel_angle: Annotated[float, "rad**2"]
    steering_wheel_rate: Annotated[float, "rad**2/s**2"]
    yaw_rate: Annotated[float, "rad**2/s**2"]


class FrictionEstimate(NamedTuple):
    """Output of the refined monitor after a sample.

    Args:
        friction_torque: friction torque at the steering wheel axis
        friction_deviation: standard deviation computed by the filter; the true error is 5 to 20 times larger in the
            printed tuning, since Q contains no errors of the friction model
        enabled: 1 where the sample corrected the friction torque
        self_aligning_torque: self-aligning torque about the kingpins
        innovation, innovation_variance: innovations of the three measurements, and their variances
        nis: normalised innovation squared over the measurements that were present
        present: number of present measurements
    """

    friction_torque: Annotated[float, "N*m"]
    friction_deviation: Annotated[float, "N*m"]
    enabled: Annotated[float, ""]
    self_aligning_torque: Annotated[float, "N*m"]
    innovation: Innovation
    innovation_variance: InnovationVariance
    nis: Annotated[float, ""]
    present: Annotated[float, ""]
