"""Corrections by readings that may be left out, and how likely those readings were."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import both, limit, log, minimum, present, sqrt, where
from tierod.methods.estimators.linear_algebra import (
    Matrix,
    Vector,
    dot,
    downdate,
    is_structural,
    minus,
    pack,
    plus,
    times,
    unpack,
)
from tierod.monitors.condition.signals import Readings, readings_by

_ROOTS = 6
"""Square roots before the series of the logarithm: x^(1/64) of what spreads over twenty powers of ten is near one."""


class Correction(NamedTuple):
    """Correction by the readings of one sample.

    Args:
        shift: of the mean, (n,)
        covariance: packed, after all readings
        whitened: every innovation, given the readings before it, over its standard deviation; 0 where it does not count
        widening: variance of every such innovation over the usual noise; 1 where it does not count
    """

    shift: tuple[Scalar, ...]
    covariance: tuple[Scalar, ...]
    whitened: tuple[Scalar, ...]
    widening: tuple[Scalar, ...]


class Seen(NamedTuple):
    """Innovations and correction of one sample.

    Args:
        expected: readings, before any of the sample
        rows: their derivatives by the state
        innovations: readings less the expected ones
        used: whether they count
        spread: variance of every innovation
        usual: variance of each reading that the widening is counted from
        correction: by all that count
    """

    expected: Vector
    rows: Matrix
    innovations: Vector
    used: Vector
    spread: Vector
    usual: Vector
    correction: Correction

    def of_sensors(self, names: Sequence[str]) -> tuple[Readings, Readings, Readings]:
        """Predictions, standard deviations of reading less prediction, and estimates after all readings that count.

        Args:
            names: of the sensors, the first of what is read
        """
        rows = zip(names, self.expected, self.spread, self.rows, strict=False)
        known = [(name, value, sqrt(spread), row) for name, value, spread, row in rows]
        return (
            readings_by({name: value for name, value, _, _ in known}),
            readings_by({name: deviation for name, _, deviation, _ in known}, 1.0),
            readings_by({name: plus(value, dot(row, self.correction.shift)) for name, value, _, row in known}),
        )

    def moved(self, mean: Vector, most: Vector) -> list[Scalar]:
        """The mean after the sample, within bounds.

        Args:
            mean: before its readings, (n,)
            most: magnitude that no state exceeds, (n,)
        """
        shifted = (value + shift for value, shift in zip(mean, self.correction.shift, strict=True))
        return [limit(value, -bound, bound) for value, bound in zip(shifted, most, strict=True)]

    def log_likelihood(self, widths: Vector, influence: Scalar) -> Scalar:
        """See `log_likelihood`; arguments as there."""
        return log_likelihood(self.correction, self.innovations, self.used, self.usual, widths, influence)


def observed(
    covariance: Vector,
    expected: Vector,
    rows: Matrix,
    readings: Vector,
    noise: Vector,
    usual: Vector,
    trusted: Vector,
    influence: Scalar,
) -> Seen:
    """A sample taken in by a filter that may leave readings out.

    Args:
        covariance: P before its readings, packed
        expected: readings, (m,)
        rows: their derivatives by the state, m rows of n
        readings: (m,); NaN where missing
        noise, usual, influence: see `update`
        trusted: 1, or 0 for a reading that is left out, (m,)
    """
    innovations = tuple(reading - value for reading, value in zip(readings, expected, strict=True))
    used = [both(present(each), use > 0.5) for each, use in zip(innovations, trusted, strict=True)]
    spread = [plus(spread_of(covariance, row), variance) for row, variance in zip(rows, noise, strict=True)]
    correction = update(covariance, rows, innovations, noise, usual, used, influence)
    return Seen(expected, rows, innovations, used, spread, usual, correction)


def update(
    covariance: Vector,
    rows: Matrix,
    innovations: Vector,
    noise: Vector,
    usual: Vector,
    used: Vector,
    influence: Scalar,
) -> Correction:
    """Scalar updates in turn; the same as the joint update with a diagonal noise while no reading is bounded.

    Args:
        covariance: P, packed
        rows: derivatives of the expected readings by the state, m rows of n
        innovations: reading less expected reading, (m,); NaN where missing
        noise: variance of each reading, (m,)
        usual: variance of each reading that the widening is counted from, (m,)
        used: whether a reading counts, (m,)
        influence: standard deviations beyond which an innovation moves the mean no further
    """
    after = unpack(covariance)
    n = len(after)
    shift: list[Scalar] = [0.0] * n
    whitened, widening = [], []
    for row, innovation, variance, nominal, counts in zip(rows, innovations, noise, usual, used, strict=True):
        cross = [dot(row, column) for column in after]
        spread = plus(dot(row, cross), variance)
        inverse = 1.0 / where(counts, spread, math.inf)
        left = minus(where(counts, innovation, 0.0), dot(row, shift))
        root = sqrt(inverse)
        over = left * root
        pushed = root * limit(over, -influence, influence)
        shift = [plus(done, times(value, pushed)) for done, value in zip(shift, cross, strict=True)]
        downdate(after, cross, inverse)
        whitened.append(over)
        widening.append(where(counts, spread / nominal, 1.0))
    return Correction(tuple(shift), pack(after), tuple(whitened), tuple(widening))


def log_likelihood(
    correction: Correction, innovations: Vector, used: Vector, usual: Vector, widths: Vector, influence: Scalar
) -> Scalar:
    """Log-likelihood of the present readings: as innovations where used, as anything plausible where left out.

    Args:
        correction: by the readings
        innovations: reading less expected reading, (m,); NaN where missing
        used: whether a reading counts, (m,)
        usual: variance of each reading that the widening is counted from, (m,)
        widths: of the range in which each reading may be that is left out, (m,)
        influence: standard deviations beyond which an innovation counts no more
    """
    squares: Scalar = 0.0
    widening: Scalar = 1.0
    for over, wide in zip(correction.whitened, correction.widening, strict=True):
        squares = squares + minimum(over * over, influence * influence)
        widening = widening * wide
    total = -0.5 * (squares + logarithm(widening))
    for reading, counts, variance, width in zip(innovations, used, usual, widths, strict=True):
        left_out = where(present(reading), -log(width), 0.0)
        total = total + where(counts, -0.5 * log(2.0 * math.pi * variance), left_out)
    return total


def spread_of(covariance: Vector, row: Vector) -> Scalar:
    """row P row', P packed."""
    full = unpack(covariance)
    return dot(
        row, [0.0 if is_structural(entry, 0.0) else dot(row, column) for entry, column in zip(row, full, strict=True)]
    )


def logarithm(value: Scalar) -> Scalar:
    """Natural logarithm of a positive value, without a library function that would keep lanes from vectors.

    Validity: to 1e-9 between 1e-6 and 1e6, to 1e-3 between 1e-20 and 1e20.
    Source: 64 log(x^(1/64)), log(y) = 2 artanh((y - 1) / (y + 1)) by its series.
    """
    for _ in range(_ROOTS):
        value = sqrt(value)
    share = (value - 1.0) / (value + 1.0)
    square = share * share
    series = 1.0 + square * (1.0 / 3.0 + square * (1.0 / 5.0 + square * (1.0 / 7.0 + square / 9.0)))
    return 2.0 ** (_ROOTS + 1) * share * series
