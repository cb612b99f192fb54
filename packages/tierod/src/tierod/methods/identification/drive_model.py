"""Lateral motion of a car in an ordinary drive, with sensor zeros, road bank and steering compliance as states.

Zeros of the sensors are constant states, so that every drive has its own; bank and twist of the steering are
Gauss-Markov processes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Tree
from tierod.core.model import Model, model_like
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.lateral_motion import lateral_motion
from tierod.models.lateral_parameters import LateralParameters, Sampled
from tierod.physics.gravity import GRAVITY
from tierod.physics.lag import gauss_markov_noise

UNKNOWNS = ("bank_angle", "lateral_acceleration_bias", "yaw_rate_bias", "road_wheel_angle_offset")
_MOTION = lateral_motion(UNKNOWNS, roll=True)
MOVING = ("lateral_speed", "yaw_rate", "front_deflection", "rear_deflection", "roll_angle", "roll_rate")

START = {
    "lateral_speed": 0.3,
    "yaw_rate": 0.1,
    "front_deflection": 0.01,
    "rear_deflection": 0.01,
    "roll_angle": 0.01,
    "roll_rate": 0.03,
}
"""Standard deviations of the motion at the start of a stretch of driving, in the units of the states."""

GATE = 16.0
"""Gate of the filter: bound of a squared innovation over its variance, beyond which the noise is raised."""


class DriveState(NamedTuple):
    """Motion with its unknowns, and the steering angle reading straight ahead, at the road wheels."""

    motion: _MOTION.State  # type: ignore[name-defined]  # made at run time
    steering_zero: Annotated[float, "rad"]


@dataclass(frozen=True)
class DriveParameters:
    """Parameters of the model.

    Args:
        sampled: of the lateral motion
        superelevation: share of the lateral acceleration in a bend that the bank of the road compensates
    """

    sampled: Sampled
    superelevation: Annotated[float, ""] = 0.0


def _driven(x: DriveState, u: Tree) -> Tree:
    return u._replace(road_wheel_angle=u.road_wheel_angle - x.steering_zero)


def _transition(x: DriveState, u: Tree, p: DriveParameters) -> DriveState:
    bank, pulled = x.motion.bank_angle, u.vehicle_speed * x.motion.yaw_rate
    # Roads are banked in bends: this part of the bank follows the bend, only the deviation from it is a state.
    on_road = x.motion._replace(bank_angle=bank - p.superelevation / GRAVITY * pulled)
    moved = _MOTION.transition(on_road, _driven(x, u), p.sampled)
    return DriveState(moved._replace(bank_angle=bank * p.sampled.fading[0]), x.steering_zero)


def _output(x: DriveState, u: Tree, p: DriveParameters) -> Tree:
    return _MOTION.output(x.motion, _driven(x, u), p.sampled)


DRIVE_MODEL: Model = model_like(
    _MOTION,
    "DriveModel",
    "Lateral motion with a zero of the steering angle.",
    State=DriveState,
    Parameters=DriveParameters,
    transition=_transition,
    output=_output,
)


@dataclass(frozen=True)
class DriveNoises:
    """Noises of model and sensors in an ordinary drive, named as in a vehicle file where it has them.

    Args:
        yaw_rate_noise, lateral_acceleration_noise: standard deviation of one measurement
        lateral_speed_drift, yaw_rate_drift: growth of the model error per square root of time
        bank_wander, bank_wander_time: standard deviation and correlation time of the bank beside the superelevation
        superelevation: share of the lateral acceleration in a bend that the bank of the road compensates
        roll_rate_drift: growth of the model error per square root of time
        road_wheel_angle_wander, road_wheel_angle_wander_time: standard deviation and correlation time of the error of
            the angle, by twist and gears
        lateral_acceleration_zero, yaw_rate_zero, steering_zero: prior standard deviations of the sensor zeros
    """

    yaw_rate_noise: Annotated[float, "rad/s"] = 0.004
    lateral_acceleration_noise: Annotated[float, "m/s**2"] = 0.3
    lateral_speed_drift: Annotated[float, "m/s**1.5"] = 0.05
    yaw_rate_drift: Annotated[float, "rad/s**1.5"] = 0.02
    roll_rate_drift: Annotated[float, "rad/s**1.5"] = 0.002
    bank_wander: Annotated[float, "rad"] = 0.015
    bank_wander_time: Annotated[float, "s"] = 10.0
    superelevation: Annotated[float, ""] = 0.1
    road_wheel_angle_wander: Annotated[float, "rad"] = 0.001
    road_wheel_angle_wander_time: Annotated[float, "s"] = 3.0
    lateral_acceleration_zero: Annotated[float, "m/s**2"] = 0.2
    yaw_rate_zero: Annotated[float, "rad/s"] = 0.01
    steering_zero: Annotated[float, "rad"] = 0.005


def drive_filter(car: LateralParameters, noises: DriveNoises, sample_time: float) -> KalmanFilter:
    """The Kalman filter of a car in a drive.

    Args:
        sample_time: sampling interval [s]
    """
    bank = noises.bank_wander, noises.bank_wander_time
    angle = noises.road_wheel_angle_wander, noises.road_wheel_angle_wander_time
    fading = (math.exp(-sample_time / bank[1]), 1.0, 1.0, math.exp(-sample_time / angle[1]))
    deviations = (
        *(START[name] for name in MOVING),
        *(noises.bank_wander, noises.lateral_acceleration_zero, noises.yaw_rate_zero),
        *(noises.road_wheel_angle_wander, noises.steering_zero),
    )
    process = (
        noises.lateral_speed_drift**2 * sample_time,
        noises.yaw_rate_drift**2 * sample_time,
        None,
        None,
        None,
        noises.roll_rate_drift**2 * sample_time,
        float(gauss_markov_noise(*bank, sample_time)),
        None,
        None,
        float(gauss_markov_noise(*angle, sample_time)),
        None,
    )
    return KalmanFilter(
        DRIVE_MODEL,
        DriveParameters(Sampled(car, sample_time, usual=(0.0,) * len(UNKNOWNS), fading=fading), noises.superelevation),
        initial_mean=(0.0,) * len(deviations),
        initial_variance=tuple(each**2 for each in deviations),
        process_noise=process,
        measurement_noise=(noises.yaw_rate_noise**2, noises.lateral_acceleration_noise**2),
        gate=GATE,
    )
