"""Acceleration of the steering wheel from its rate in the past, smooth and yet on time."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.methods.filters import Differentiator, FirstOrderLowPass

SMOOTHING = 0.005
"""Time constant of the acceleration, whose noise would otherwise pass for motion [s]; at least two samples."""


class WheelRate(NamedTuple):
    """Rate of the steering wheel."""

    steering_wheel_rate: Annotated[float, "rad/s"]


class WheelAcceleration(NamedTuple):
    """Acceleration of the steering wheel."""

    steering_wheel_acceleration: Annotated[float, "rad/s**2"]


def slope_filters(sample_time: float) -> tuple[Differentiator, FirstOrderLowPass]:
    """Slope of the rate, and what that was before.

    Args:
        sample_time: between two samples [s]
    """
    smoothing = max(SMOOTHING, 2.0 * sample_time)
    return (
        Differentiator(WheelRate, sample_time, 0.0, smoothing),
        FirstOrderLowPass(WheelAcceleration, sample_time, 0.0, smoothing),
    )


def accelerated(slope: Differentiator, slow: FirstOrderLowPass, smooth: Any, rate: Any) -> tuple[Any, Any]:
    """Memory of both filters, and the acceleration [rad/s^2] in the middle of the next sample.

    The lag of the smoothing is made up for to first order: with it an error of 20 % of the inertia would leave a tenth
    of its torque at 3 Hz.

    Args:
        slope, slow: from `slope_filters`
        smooth: their memory
        rate: of the wheel [rad/s]
    """
    quick, now = slope.step(smooth[0], WheelRate(rate))
    late, before = slow.step(smooth[1], WheelAcceleration(now.steering_wheel_rate))
    lag = (slope.time_constant + 0.5 * slope.sample_time) / slow.time_constant
    change = now.steering_wheel_rate - before.steering_wheel_acceleration
    return (quick, late), now.steering_wheel_rate + lag * change
