"""The Kalman filter inside the motor angle's observer."""

from __future__ import annotations

from typing import Any

from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.stator_frame_motor import (
    CommandedMotor,
    CommandedMotorParameters,
    SampledMotorParameters,
    StatorFrameMotor,
)
from tierod.monitors.motor_angle.tuning import MotorAngleTuning

_TINY = 1e-14
"""Variance that the angle gains per sample besides that of the speed [rad^2]: keeps the covariance positive."""


def stator_filter(p: SampledMotorParameters, t: MotorAngleTuning) -> KalmanFilter:
    """The filter of a motor whose voltages are measured, or commanded where its parameters are those of an inverter.

    Args:
        p: of the motor
        t: noises and first deviations
    """
    voltage = (t.voltage_noise * p.sample_time / p.motor_inductance) ** 2
    first: tuple[float, ...] = (
        t.current_noise,
        t.current_noise,
        t.first_speed,
        t.first_angle,
        t.first_load,
        t.first_resistance,
        t.first_flux,
    )
    wander: tuple[float, ...] = (t.resistance_wander**2 * p.sample_time, t.flux_wander**2 * p.sample_time)
    reading = 2.0 * (t.sensor_noise / max(t.increment_time, p.sample_time)) ** 2
    model: Any = StatorFrameMotor
    mean: tuple[float, ...] = (0.0,) * 7
    if isinstance(p, CommandedMotorParameters):
        model, mean = CommandedMotor, (*mean, p.inverter_voltage_loss, 0.0)
        first += (t.first_loss, t.first_knee)
        wander += (t.loss_wander**2 * p.sample_time, t.knee_wander**2 * p.sample_time)
    return KalmanFilter(
        model,
        p,
        model.State(*mean),
        tuple(deviation**2 for deviation in first),
        (voltage, voltage, t.speed_wander**2, _TINY, t.load_wander**2, *wander),
        (t.current_noise**2, t.current_noise**2, reading),
        maskable=("angle", "log_resistance", "log_flux") + (("log_knee",) if model is CommandedMotor else ()),
    )


def angle_variance_place(states: int) -> int:
    """Place of the angle's variance in a packed covariance of so many states: three rows come before it."""
    return 3 * states - 3
