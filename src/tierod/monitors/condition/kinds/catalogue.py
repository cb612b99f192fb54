"""The kinds of faults by number, the estimate of one, and the state while they are weighed."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Ring, Scalar, Tree
from tierod.core.graph.maths import where

KINDS = ("loss", "stuck", "offset", "gain", "drift", "outlier", "noise", "delay", "loss of torque")
"""Kinds of faults, the last one of an actuator; the number of a kind is its place here plus one, 0 stands for none."""

NONE, LOSS, STUCK, OFFSET, GAIN, DRIFT, OUTLIER, NOISE, DELAY, LOST_TORQUE = map(float, range(len(KINDS) + 1))


class Kind(NamedTuple):
    """The kind of a fault.

    Args:
        kind: number of the kind; 0 while nothing is declared
        magnitude: of an offset in the unit of the signal, of a gain or an outlier the factor, of a drift per second, of
            noise its standard deviation, of a delay in seconds; 0 of what has none
        deviation: standard deviation of the magnitude
        effect: least addition of the fault to this reading, by all kinds that it may well be [unit of the signal];
            infinite where a reading that never changed moves again, and as it should
    """

    kind: Annotated[Scalar, ""]
    magnitude: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]
    effect: Annotated[Scalar, ""]


class Fit(NamedTuple):
    """One parameter learnt from readings, and how likely the readings were on the way."""

    value: Scalar
    variance: Scalar
    score: Scalar


class SlopeFit(NamedTuple):
    """Start and slope learnt from readings, and how likely the readings were on the way."""

    start: Scalar
    slope: Scalar
    start_variance: Scalar
    covariance: Scalar
    slope_variance: Scalar
    score: Scalar


class KindState(NamedTuple):
    """State of the kind of one sensor's fault.

    Args:
        age: samples since the readings began to be off, with or without a reading
        seen: those with a reading
        declared_for: samples with a reading since the declaration
        last: reading of the sample before
        repeated: whether every reading since the declaration was the same
        smooth: recent mean of reading less prediction
        constant, offset, gain: fits of one parameter
        drift: fit of a slope
        weight, power, expected: sum of weights, mean squared deviation, and what it would be without fault
        quick: mean squared deviation from the recent mean
        noise: likelihood of the readings as noise
        counted, common: weight of the readings, and the sum of the logarithms of their variances
        undelayed, delays: squared deviations over their variance as they are, and with each of the delays
        past: predictions, one line for each delay
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


def selected(condition: Scalar, first: KindState, second: KindState) -> KindState:
    """One of two states, their delay lines left alone."""

    def pick(a: Tree, b: Tree) -> Tree:
        if isinstance(a, tuple):
            picked = [pick(x, y) for x, y in zip(a, b, strict=True)]
            return type(a)(*picked) if hasattr(a, "_fields") else tuple(picked)
        return where(condition, a, b)

    lines = first.past
    picked: KindState = pick(first._replace(past=()), second._replace(past=()))
    return picked._replace(past=lines)
