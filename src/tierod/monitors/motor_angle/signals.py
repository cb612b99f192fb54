"""What the monitor of the motor's angle reads."""

from __future__ import annotations

from typing import Annotated, NamedTuple


class MotorAngleSample(NamedTuple):
    """Currents, mean voltages over the sample that ends, and the angle; then whatever else is recorded, or NaN.

    Targets and duty cycles are those of the period that ends with the sample.
    """

    motor_current_alpha: Annotated[float, "A"]
    motor_current_beta: Annotated[float, "A"]
    motor_voltage_alpha: Annotated[float, "V"]
    motor_voltage_beta: Annotated[float, "V"]
    motor_angle_mechanical: Annotated[float, "rad"]
    target_motor_angle_mechanical: Annotated[float, "rad"]
    motor_current_a: Annotated[float, "A"]
    motor_current_b: Annotated[float, "A"]
    motor_current_c: Annotated[float, "A"]
    resolver_sine: Annotated[float, "V"]
    resolver_cosine: Annotated[float, "V"]
    supply_voltage: Annotated[float, "V"]
    steering_wheel_angle: Annotated[float, "rad"]
    pinion_angle: Annotated[float, "rad"]
    driver_torque: Annotated[float, "N*m"]
    motor_target_voltage_alpha: Annotated[float, "V"]
    motor_target_voltage_beta: Annotated[float, "V"]
    motor_duty_cycle_a: Annotated[float, ""]
    motor_duty_cycle_b: Annotated[float, ""]
    motor_duty_cycle_c: Annotated[float, ""]
    vehicle_speed: Annotated[float, "m/s"]
