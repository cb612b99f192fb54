"""Noises, limits and times of the motor angle's observer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.fields import check_ranges
from tierod.ranges import NOT_NEGATIVE, POSITIVE


@dataclass(frozen=True)
class MotorAngleTuning:
    """What the observer believes of its measurements and of itself.

    Args:
        current_noise: standard deviation of a measured current; shunts and converters of such a drive
        voltage_noise: of the mean voltage over a sample, with what the model leaves out
        sensor_noise: of one reading of the angle sensor, used for increments only
        speed_wander: that the balance of torques leaves out, per sample
        load_wander: of the load torque, per sample: it may reverse within some 10 ms
        resistance_wander: of its logarithm per square root of a second: a winding heats over seconds
        flux_wander: the same of the flux: magnets warm over minutes
        standing_wander: of the angle while its currents do not tell it: what increments of the sensor may be wrong by
        first_angle, first_speed, first_load: standard deviations at the first sample
        first_resistance, first_flux: of their logarithms: temperatures from -40 to 120 degrees
        least_current: below it the resistance is left alone, since noise alone would drive it
        standing_speed: below it the back-EMF tells no angle
        standing_time: for so long it must be below
        slow_speed: below it increments of the sensor tell the speed too
        lag: of the speed that decides about this
        widest: logarithms of resistance and flux stay within this
    """

    current_noise: Annotated[float, "A", POSITIVE] = 0.15
    voltage_noise: Annotated[float, "V", POSITIVE] = 0.05
    sensor_noise: Annotated[float, "rad", POSITIVE] = 5e-4
    speed_wander: Annotated[float, "rad/s", POSITIVE] = 0.1
    load_wander: Annotated[float, "N*m", POSITIVE] = 0.02
    resistance_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 0.01
    flux_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 2e-4
    standing_wander: Annotated[float, "rad/s**0.5", POSITIVE] = 0.02
    first_angle: Annotated[float, "rad", POSITIVE] = 0.07
    first_speed: Annotated[float, "rad/s", POSITIVE] = 20.0
    first_load: Annotated[float, "N*m", POSITIVE] = 0.3
    first_resistance: Annotated[float, "", POSITIVE] = 0.2
    first_flux: Annotated[float, "", POSITIVE] = 0.05
    least_current: Annotated[float, "A", POSITIVE] = 3.0
    standing_speed: Annotated[float, "rad/s", POSITIVE] = 1.5
    standing_time: Annotated[float, "s", POSITIVE] = 0.02
    slow_speed: Annotated[float, "rad/s", POSITIVE] = 8.0
    lag: Annotated[float, "s", POSITIVE] = 0.005
    widest: Annotated[float, "", POSITIVE] = 0.7

    def __post_init__(self) -> None:
        check_ranges(self)
