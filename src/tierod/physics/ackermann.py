"""How the inner front wheel steers more than the outer one."""

from __future__ import annotations

from tierod.core.block import Scalar


def ackermann_angle(mean_angle: Scalar, gain: Scalar) -> Scalar:
    """Steer [rad] of the left front wheel; the right one has the gain with the other sign.

    Args:
        mean_angle: mean steer of both front wheels [rad], positive left
        gain: half the difference of both wheels per squared steer [1/rad]; track / (2 wheelbase) lets all wheels roll
            about one centre (full Ackermann), zero keeps the wheels parallel

    Validity: the second order of cot(right) - cot(left) = track / wheelbase; the difference of both wheels is 5 % too
    large at 0.35 rad and 11 % at 0.5 rad.
    Source: Rajamani, Vehicle Dynamics and Control (2012), section 2.2:
    the difference of both wheels is steer^2 track / wheelbase.
    """
    return mean_angle + gain * mean_angle * mean_angle


def ackermann_slope(mean_angle: Scalar, gain: Scalar) -> Scalar:
    """Turn of the left front wheel per turn of the mean steer [-]: the derivative of `ackermann_angle`.

    Args:
        mean_angle: mean steer of both front wheels [rad]
        gain: as in `ackermann_angle` [1/rad]
    """
    return 1.0 + 2.0 * gain * mean_angle
