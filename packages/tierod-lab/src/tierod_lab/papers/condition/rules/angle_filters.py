"""The unscented filters of r1, with column and rack as one body and as the two bodies of the paper."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from tierod.core.block import Model
from tierod.models.linear import discretise
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.condition.rules.parameters import ResidualParameters
from tierod_lab.papers.condition.rules.rack import StiffRack, TwoBodyRack, discretise_pair, discretise_stiff

ANGLE_NOISE, RATE_NOISE = 1e-8, 10.0
"""Process noise: variance of the angle per sample [rad**2] and of the column rate per second [rad**2/s**3]."""

MEASURED = 0.002**2  # Variance of the measured angle [rad**2], due to the quantisation of its sensor

SQUARINGS = 20  # Squarings of the matrix exponential over 10 ms; the row sums of eq (3) are 3.3e7 per second squared

_SLIDING = TwoBodyRack.State(0.0, 0.0, 0.0, 1e3)
"""State of fast sliding, in which friction has no slope and the Jacobian is the matrix of eq (3)."""


def one_body(car: ResidualParameters, sample_time: float = 0.01) -> UnscentedFilter:
    """The filter that the residuals use, with column and rack as one rigid body.

    Args:
        sample_time: sampling interval [s]
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

    A missing rack position leaves the angle as the only measurement. If it is given as rack ratio times angle (eq 5),
    as in the paper, the one sensor counts twice, and the variance of the filter is almost half as large.

    Args:
        sample_time: sampling interval [s]
        model: `TwoBodyRack`, discretised; by the exponential of eq (3) with explicit friction if None
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
    """Parameters of the steering of a vehicle, with the rack and teeth of Table A1."""
    return TwoBodyRack.Parameters(**asdict(car.rack))


def exponential(everywhere: bool = False) -> Model:
    """The model with four states, discretised by a matrix exponential.

    Args:
        everywhere: whether the Jacobian is evaluated in every state, with the slope of friction; otherwise it is the
            matrix of eq (3), computed once, and friction is that at the beginning of each sample
    """
    return discretise_stiff(TwoBodyRack, SQUARINGS, None if everywhere else _SLIDING)


def explicit(steps: int) -> Model:
    """The model with four states, discretised by the fourth-order Runge-Kutta method with `steps` steps per sample."""
    return discretise(TwoBodyRack, "rk4", steps)
