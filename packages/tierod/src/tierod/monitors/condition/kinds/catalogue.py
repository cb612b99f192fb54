"""Kinds of faults by number, and the estimates and states of their classification."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar, Tree
from tierod.core.graph.maths import where

KINDS = ("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay", "loss of torque")
"""Kinds of faults, the last one of an actuator; the number of a kind is its index here plus one, and 0 is no kind."""

NONE, LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY, LOST_TORQUE = map(float, range(len(KINDS) + 1))
"""Numbers of the kinds, as floats for the outputs of a block."""


class Kind(NamedTuple):
    """Kind and magnitude of a fault.

    Args:
        kind: number of the kind; 0 while no fault is declared
        magnitude: offset [unit of the signal], factor of a gain or an outlier, drift [unit per second], standard
            deviation of noise [unit of the signal], delay [s]; 0 for a kind without magnitude
        deviation: standard deviation of the magnitude
        effect: change that the fault adds to this reading, the smallest of all kinds that are likely [unit of the
            signal]; infinite if a reading that never changed changes again and is consistent
    """

    kind: Annotated[Scalar, ""]
    magnitude: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]
    effect: Annotated[Scalar, ""]


class Named(NamedTuple):
    """Kind, magnitude and standard deviation of the magnitude, as in `Kind`."""

    kind: Scalar
    magnitude: Scalar
    deviation: Scalar


class Fit(NamedTuple):
    """Recursive estimate of one parameter, its variance, and the log-likelihood of the readings."""

    value: Scalar
    variance: Scalar
    score: Scalar


class SlopeFit(NamedTuple):
    """Recursive estimate of start and slope, their covariance, and the log-likelihood of the readings."""

    start: Scalar
    slope: Scalar
    start_variance: Scalar
    covariance: Scalar
    slope_variance: Scalar
    score: Scalar


class KindState(NamedTuple):
    """State of the kind of one sensor's fault.

    Args:
        age: number of samples since the readings began to be inconsistent, with or without a reading
        seen: number of these with a reading
        declared_for: number of samples with a reading since the declaration
        last: last reading
        repeated: whether every reading since the declaration was the same
        smooth: recent mean of reading less prediction
        constant, offset, gain: fits of one parameter
        drift: fit of start and slope
        weight, power, expected: sum of weights, mean squared deviation, and its expectation without a fault
        quick: mean squared deviation from the recent mean
        noise: log-likelihood of the readings as noise
        counted, common: weight of the readings, and weighted sum of the log variances
        undelayed, delays: sum of squared deviations over their variance, without delay, and with each delay
        past: delay lines of the predictions, one for each delay
        named: kind at the last reading that supported a fault; none without evidence for one
        supports: whether the last reading supported a fault, see `KindOfFault.Sample`
        likeliest: number of the kind that is likeliest now, whose effect `Kind` gives
    """

    age: Scalar
    seen: Scalar
    declared_for: Scalar
    last: Scalar
    repeated: Scalar
    smooth: Scalar
    constant: Fit
    offset: Fit
    gain: Fit
    drift: SlopeFit
    weight: Scalar
    power: Scalar
    expected: Scalar
    quick: Scalar
    noise: Scalar
    counted: Scalar
    common: Scalar
    undelayed: Scalar
    delays: tuple[Scalar, ...]
    past: tuple[Ring, ...]
    named: Named
    supports: Scalar
    likeliest: Scalar


def selected(condition: Scalar, first: KindState, second: KindState) -> KindState:
    """One of two states, with the delay lines of the first in either case."""

    def pick(a: Tree, b: Tree) -> Tree:
        if isinstance(a, tuple):
            picked = [pick(x, y) for x, y in zip(a, b, strict=True)]
            return type(a)(*picked) if hasattr(a, "_fields") else tuple(picked)
        return where(condition, a, b)

    lines = first.past
    picked: KindState = pick(first._replace(past=()), second._replace(past=()))
    return picked._replace(past=lines)
