"""Noises, limits and times of the motor angle's observer, and the Kalman filter inside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.graph.maths import minimum
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.stator_frame_motor import (
    CommandedMotor,
    CommandedMotorParameters,
    SampledMotorParameters,
    StatorFrameMotor,
)

_TINY = 1e-14
"""Variance that the angle gains per sample besides that of the speed [rad^2]: keeps the covariance positive."""


@dataclass(frozen=True)
class MotorAngleTuning:
    """Assumptions of the observer about its measurements and itself.

    Args:
        current_noise: standard deviation of a measured current; shunts and converters of such a drive
        voltage_noise: of the mean voltage over a sample, with what the model leaves out
        sensor_noise: of one reading of the angle sensor, used for increments only
        speed_wander: that the balance of torques leaves out, per sample
        load_wander: of the load torque, per sample: it may reverse within some 10 ms
        surprising: square of the normalised innovations, from which the load has
            stepped: noise of two currents goes beyond once in 22 000 samples, of increments besides once in 6 000
        stepped_speed, stepped_load: possible change of both by then: a load at its limit within one sample
        most_surprises, step_memory: a step surprises less often than this within that time; more is a wrong model
        resistance_wander: of its logarithm per square root of a second: a winding heats over seconds
        flux_wander: the same of the flux: magnets warm over minutes
        loss_wander: of what the inverter takes, per square root of a second: its semiconductors warm over seconds
        knee_wander: the same of the logarithm of its knee
        standing_wander: of the angle while its currents do not show it: what increments of the sensor may be wrong by
        first_angle, first_speed, first_load: standard deviations at the first sample
        first_resistance, first_flux: of their logarithms: temperatures from -40 to 120 degrees
        first_loss: of what the inverter takes from a command: its data sheet gives it within so much
        first_knee: of the logarithm of its knee, which no data sheet gives; 0 takes it as known
        learnt_knee: deviation of that logarithm below which a surprise is one of the load
        least_current: below it the resistance is left alone, since noise alone would drive it
        standing_speed: below it the back-EMF determines no angle
        standing_time: for so long it must be below
        slow_speed: below it increments of the sensor give the speed too
        increment_time: they are summed for so long: their noise does not add up, and the motor hardly accelerates
        lag: of the speed that decides about this
        widest: logarithms of resistance and flux stay within this
        widest_knee: that of the knee: from a fifth to five times its value
    """

    current_noise: Annotated[float, "A", POSITIVE] = 0.2
    voltage_noise: Annotated[float, "V", POSITIVE] = 0.05
    sensor_noise: Annotated[float, "rad", POSITIVE] = 5e-4
    speed_wander: Annotated[float, "rad/s", POSITIVE] = 0.1
    load_wander: Annotated[float, "N*m", POSITIVE] = 0.02
    surprising: Annotated[float, "", POSITIVE] = 20.0
    stepped_speed: Annotated[float, "rad/s", POSITIVE] = 5.0
    stepped_load: Annotated[float, "N*m", POSITIVE] = 1.0
    most_surprises: Annotated[float, "", POSITIVE] = 12.0
    step_memory: Annotated[float, "s", POSITIVE] = 0.05
    resistance_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 0.01
    flux_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 2e-4
    loss_wander: Annotated[float, "V/s**0.5", NOT_NEGATIVE] = 0.01
    knee_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 0.0
    standing_wander: Annotated[float, "rad/s**0.5", POSITIVE] = 0.02
    first_angle: Annotated[float, "rad", POSITIVE] = 0.07
    first_speed: Annotated[float, "rad/s", POSITIVE] = 20.0
    first_load: Annotated[float, "N*m", POSITIVE] = 0.3
    first_resistance: Annotated[float, "", POSITIVE] = 0.2
    first_flux: Annotated[float, "", POSITIVE] = 0.05
    first_loss: Annotated[float, "V", POSITIVE] = 0.3
    first_knee: Annotated[float, "", NOT_NEGATIVE] = 0.5
    learnt_knee: Annotated[float, "", POSITIVE] = 0.1
    least_current: Annotated[float, "A", POSITIVE] = 3.0
    standing_speed: Annotated[float, "rad/s", POSITIVE] = 1.0
    standing_time: Annotated[float, "s", POSITIVE] = 0.02
    slow_speed: Annotated[float, "rad/s", POSITIVE] = 8.0
    increment_time: Annotated[float, "s", POSITIVE] = 1e-3
    lag: Annotated[float, "s", POSITIVE] = 0.005
    widest: Annotated[float, "", POSITIVE] = 0.7
    widest_knee: Annotated[float, "", POSITIVE] = 1.6

    def __post_init__(self) -> None:
        check_ranges(self)


def stator_filter(p: SampledMotorParameters, t: MotorAngleTuning) -> KalmanFilter:
    """The filter of a motor whose voltages are measured, or commanded where its parameters are those of an inverter.

    Args:
        p: of the motor
        t: noises and first deviations
    """
    voltage = (t.voltage_noise * p.sample_time / _least_inductance(p)) ** 2
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


def _least_inductance(p: SampledMotorParameters) -> float:
    """Along or across the flux: of the axis that a voltage moves most [H]."""
    return minimum(p.motor_inductance, p.inductance_across)


def angle_variance_place(states: int) -> int:
    """Place of the angle's variance in a packed covariance of so many states: three rows come before it."""
    return 3 * states - 3
