"""Sideslip angle and yaw rate by a Kalman filter on the single track."""

from __future__ import annotations

from typing import Any

from tierod.methods.estimators import KalmanFilter
from tierod.models.exponential import discretise_pair
from tierod.models.single_track import SingleTrack


class PrintedSingleTrack(SingleTrack):
    """The single track with the lateral acceleration as it is printed: too small by the speed in its first term.

    Source: Li, Frey, Gauterin, eq (14), C[1,1] = -(cf + cr) / (m v), where -(cf + cr) / m is right.
    """

    @staticmethod
    def output(x: SingleTrack.State, u: SingleTrack.Input, p: SingleTrack.Parameters) -> SingleTrack.Output:
        """Yaw rate and lateral acceleration."""
        right = SingleTrack.output(x, u, p)
        of_sideslip = (p.front_cornering_stiffness + p.rear_cornering_stiffness) / p.mass * x.sideslip_angle
        printed = right.lateral_acceleration + of_sideslip - of_sideslip / u.vehicle_speed
        return right._replace(lateral_acceleration=printed)


def lateral_filter(parameters: SingleTrack.Parameters, sample_time: float, printed: bool = False) -> KalmanFilter:
    """The filter of eqs (13) and (14), sampled exactly: the poles of the printed tyres lie at up to -560 1/s.

    Args:
        parameters: of the vehicle
        sample_time: [s]
        printed: whether the lateral acceleration is the printed one

    The model is trusted more than the gyroscope, so that the yaw rate that it expects stays apart from a faulty one:
    0.3 rad/s of a second's wander against 0.05 rad/s of a reading. The paper prints no noises.
    """
    model: Any = discretise_pair(PrintedSingleTrack if printed else SingleTrack)
    return KalmanFilter(
        model,
        model.Parameters(parameters, sample_time),
        (0.0, 0.0),
        (0.01, 0.01),
        (0.02**2 * sample_time, 0.1**2 * sample_time),
        (0.1**2, 0.5**2),
    )
