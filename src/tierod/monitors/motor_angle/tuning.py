"""Noises, limits and times of the motor angle observer, and its Kalman filter."""

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
"""Variance that the angle gains per sample besides that of the speed [rad^2]; keeps the covariance positive."""


@dataclass(frozen=True)
class MotorAngleTuning:
    """Assumptions of the observer on its measurements, the motor and the inverter.

    Args:
        current_noise: standard deviation of a measured current; shunts and converters of such a drive
        voltage_noise: standard deviation of the mean voltage over a sample, with unmodelled effects
        sensor_noise: standard deviation of one reading of the angle sensor, used for increments only
        speed_wander: standard deviation of the unmodelled change of speed per sample
        load_wander: random walk of the load torque per sample; it may reverse within some 10 ms
        surprising: NIS above which the load has stepped; noise of two currents exceeds it once in 22 000 samples,
            with increments once in 6 000
        stepped_speed, stepped_load: standard deviations of both after a step: a load at its limit within one sample
        most_surprises, step_memory: number of surprises within that time up to which they are steps; more show a wrong
            model
        resistance_wander: random walk of its logarithm; a winding heats over seconds
        flux_wander: random walk of the logarithm of the flux; magnets warm over minutes
        loss_wander: random walk of the inverter's voltage loss; its semiconductors warm over seconds
        knee_wander: random walk of the logarithm of its knee
        standing_wander: random walk of the angle at standstill, the possible error of the sensor's increments
        first_angle, first_speed, first_load: initial standard deviations
        first_resistance, first_flux: initial standard deviations of their logarithms; temperatures from -40 to 120
            degrees
        first_loss: initial standard deviation of the inverter's voltage loss; the accuracy of its data sheet
        first_knee: initial standard deviation of the logarithm of its knee, which no data sheet gives; 0 takes it as
            known
        learnt_knee: standard deviation of that logarithm below which a surprise is attributed to the load
        least_current: current below which the resistance is not estimated, since noise alone would make it drift
        standing_speed: speed below which the back-EMF does not determine the angle
        standing_time: time for which the speed must be below
        slow_speed: speed below which increments of the sensor serve as speed measurements
        increment_time: time over which they are summed: their noise does not add up, and the motor hardly accelerates
        lag: time constant of the speed that selects the mode
        widest: bound of the logarithms of resistance and flux
        widest_knee: bound of that of the knee; from a fifth to five times its value
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
    """The filter of a motor with measured voltages, or with commanded ones where its parameters include an inverter.

    Args:
        p: parameters of the motor
        t: noises and initial standard deviations
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
    # Two readings bound an increment, and both have noise.
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
    """Smaller inductance of both axes, in which the voltage noise moves the current most [H]."""
    return minimum(p.motor_inductance, p.inductance_across)


def angle_variance_place(states: int) -> int:
    """Index of the angle's variance in a packed covariance of so many states, after the first three rows."""
    return 3 * states - 3
