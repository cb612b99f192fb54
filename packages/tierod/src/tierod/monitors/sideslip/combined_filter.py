"""The extended Kalman filter of the combined sideslip estimator, from vehicle parameters and a tuning."""

from __future__ import annotations

from typing import Any

from tierod.core.block import Scalar, Tree
from tierod.core.graph.maths import absolute, limit, log, maximum, sqrt
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.lateral_motion import lateral_motion
from tierod.models.lateral_parameters import LateralParameters, Sampled
from tierod.monitors.sideslip.combined_tuning import CombinedTuning, Noises, per_sample
from tierod.physics.gravity import GRAVITY

START = {
    "lateral_speed": 0.5,
    "yaw_rate": 0.2,
    "front_deflection": 0.02,
    "rear_deflection": 0.02,
    "roll_angle": 0.02,
    "roll_rate": 0.05,
    "road_wheel_angle": 0.3,
    "road_wheel_rate": 0.5,
    "friction_share": 0.7,
}
"""Standard deviation of the motion before the first sample, in the units of the states."""

GATE = 10.83
"""Bound on the squared normalised innovation of a reading, and of a jump of the steering angle; the 99.9 % quantile of
the chi-square distribution with one degree of freedom."""

DEFLECTED = 0.03
"""Growth of the tyres' deflection over that of the lateral speed while the estimate is held [s]."""

FARTHEST = 3.5
"""Bound on the logarithm of a factor, in standard deviations of its prior about its usual value; it stops divergence
where the linearised filter is overconfident. Never less than one, a factor of e."""

NARROWEST = 1.0
"""Smallest such bound [-, natural logarithm]; no factor of a tyre is known better than to a factor of e."""


def combined_filter(car: LateralParameters, sample_time: float, tuning: CombinedTuning, steering: bool) -> KalmanFilter:
    """The Kalman filter over the states that the tuning selects.

    Args:
        car: parameters of the car
        sample_time: sampling interval [s]
        tuning: estimated unknowns, and noises
        steering: whether the road wheels' motion is among the states
    """
    followed = tuning.followed(steering)
    model = lateral_motion(tuple(followed), roll=tuning.roll, steering=steering)
    noises, names = tuning.noises, model.State._fields
    moving = ("lateral_speed", "yaw_rate", "roll_rate", "road_wheel_rate")
    process = {name: per_sample(getattr(noises, name), sample_time) for name in moving}
    process |= {name: each.noise(sample_time) for name, each in followed.items()}
    first = START | {name: each.deviation for name, each in followed.items()}
    return KalmanFilter(
        model,
        Sampled(
            car,
            sample_time,
            usual=tuple(each.usual for each in followed.values()),
            fading=tuple(each.fading(sample_time) for each in followed.values()),
        ),
        initial_mean=tuple(followed[name].usual if name in followed else 0.0 for name in names),
        initial_variance=tuple(first[name] ** 2 for name in names),
        process_noise=tuple(process.get(name, 0.0) for name in names),
        measurement_noise=tuple(getattr(noises, f"{name}_reading") ** 2 for name in model.Output._fields),
        gate=GATE,
    )


def held_growth(model: Any, noises: Noises, sample_time: float) -> tuple[float, ...]:
    """Variance that every state gains per sample while the estimate is held, in the order of the states.

    Args:
        model: model of the filter
        noises: noises of the tuning
        sample_time: sampling interval [s]
    """
    moving = ("lateral_speed", "yaw_rate", "road_wheel_angle")
    held = {name: per_sample(getattr(noises, f"held_{name}"), sample_time) for name in moving}
    held |= dict.fromkeys(("front_deflection", "rear_deflection"), held["lateral_speed"] * DEFLECTED * DEFLECTED)
    return tuple(held.get(name, 0.0) for name in model.State._fields)


def bounded(filter: KalmanFilter, mean: Tree, lateral: Scalar) -> Tree:
    """The mean of a belief with every factor held within the bounds of its prior.

    Friction is at least what the lateral acceleration proves, as far as that is below the usual friction.

    Args:
        filter: filter of the belief
        mean: mean after a sample
        lateral: smoothed lateral acceleration [m/s**2]
    """
    car = filter.parameters.car
    shown = absolute(lateral) / ((1.0 + car.roll_share) * GRAVITY * car.tyre_friction)
    least = log(limit(shown, 1e-3, 1.0))
    kept = []
    for name, value, usual, variance in zip(
        mean._fields, mean, filter.initial_mean, filter.initial_variance, strict=True
    ):
        width = maximum(FARTHEST * sqrt(variance), NARROWEST)
        value = limit(value, usual - width, usual + width) if name.startswith("log_") else value
        kept.append(maximum(value, least) if name == "log_friction" else value)
    return type(mean)(*kept)
