"""The unscented filters of r1: column and rack as one body, and as the two bodies of the paper."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from tierod.core.model import Model
from tierod.methods.estimators import UnscentedFilter
from tierod.models.discretise import discretise
from tierod.models.exponential import discretise_pair
from tierod.models.stiff_exponential import discretise_stiff
from tierod.models.stiff_rack import StiffRack
from tierod.models.two_body_rack import TwoBodyRack
from tierod.papers.condition.rules.parameters import ResidualParameters

ANGLE_NOISE, RATE_NOISE = 1e-8, 10.0
"""Variance that the angle gains per sample [rad**2], and the column's rate per second [rad**2/s**3]."""

MEASURED = 0.002**2
"""Variance of the measured angle [rad**2]: the steps of its sensor."""

SQUARINGS = 20
"""Of a sample of 10 ms: the row sums of eq (3) are 3.3e7 per second squared."""

_SLIDING = TwoBodyRack.State(0.0, 0.0, 0.0, 1e3)
"""Where the friction has no slope, so that eq (3) is left."""


def one_body(car: ResidualParameters, sample_time: float = 0.01) -> UnscentedFilter:
    """The filter that the residuals use: column and rack turn together.

    Args:
        car: the vehicle
        sample_time: [s]
    """
    rack: Any = discretise_pair(StiffRack)
    return UnscentedFilter(
        rack,
        rack.Parameters(car.rack, sample_time),
        (0.0, 0.0),
        (0.1, 0.1),
        (ANGLE_NOISE, RATE_NOISE * sample_time),
        (MEASURED,),
    )


def two_bodies(car: ResidualParameters, sample_time: float = 0.01, model: Model | None = None) -> UnscentedFilter:
    """The filter of eqs (3) and (4), with four states.

    A missing rack position leaves one measurement. Given as rack ratio times angle (eq 5), as the paper does, it counts
    the one sensor twice, and the variance that the filter states is almost half as large.

    Args:
        car: the vehicle
        sample_time: [s]
        model: `TwoBodyRack`, discretised; with the exponential of eq (3) and explicit friction if None
    """
    rack: Any = model or exponential()
    ratio = car.rack_ratio * car.rack_ratio
    angle, rate = ANGLE_NOISE, RATE_NOISE * sample_time
    return UnscentedFilter(
        rack,
        rack.Parameters(two_body_parameters(car), sample_time),
        (0.0, 0.0, 0.0, 0.0),
        (0.1 * ratio, 0.1, 0.1 * ratio, 0.1),
        (angle * ratio, angle, rate * ratio, rate),
        (MEASURED * ratio, MEASURED),
    )


def two_body_parameters(car: ResidualParameters) -> TwoBodyRack.Parameters:
    """The steering of a vehicle with the rack and teeth of Table A1."""
    return TwoBodyRack.Parameters(**asdict(car.rack))


def exponential(everywhere: bool = False) -> Model:
    """The four states sampled by an exponential.

    Args:
        everywhere: whether its Jacobian is taken in every state, with the slope of friction; otherwise it is eq (3),
            worked out before all samples, and friction is that at the beginning of each
    """
    return discretise_stiff(TwoBodyRack, SQUARINGS, None if everywhere else _SLIDING)


def explicit(steps: int) -> Model:
    """The four states sampled by Runge and Kutta's method of fourth order, so many steps to a sample."""
    return discretise(TwoBodyRack, "rk4", steps)
