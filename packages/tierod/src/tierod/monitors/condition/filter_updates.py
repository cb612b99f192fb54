"""Kalman correction by readings that may be left out, and the log-likelihood of the readings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import both, limit, log, minimum, present, sqrt, where
from tierod.methods.estimators.kernels import (
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

_ROOTS = 6  # number of square roots before the series of the logarithm: x^(1/64) is near one over twenty powers of ten


class Correction(NamedTuple):
    """Correction by the readings of one sample."""

    shift: tuple[Scalar, ...]  # correction of the mean, (n,)
    covariance: tuple[Scalar, ...]  # packed covariance after all readings
    # normalised innovations, each given the readings before it; 0 for readings that are left out
    whitened: tuple[Scalar, ...]
    # variances of these innovations over the usual noise; 1 for readings that are left out
    widening: tuple[Scalar, ...]


class Innovations(NamedTuple):
    """Innovations and correction of one sample."""

    expected: Vector  # expected readings before the sample
    rows: Matrix  # their derivatives by the state
    innovations: Vector  # readings less expected readings
    used: Vector  # whether each reading is used
    spread: Vector  # variance of every innovation, before any correction
    usual: Vector  # nominal noise variance of each reading, the reference of `Correction.widening`
    correction: Correction  # correction by all readings that are used

    def of_sensors(self, names: Sequence[str]) -> tuple[Readings, Readings, Readings]:
        """Predictions, standard deviations of reading less prediction, and estimates after the correction."""
        rows = zip(names, self.expected, self.spread, self.rows, strict=False)
        known = [(name, value, sqrt(spread), row) for name, value, spread, row in rows]
        return (
            readings_by({name: value for name, value, _, _ in known}),
            readings_by({name: deviation for name, _, deviation, _ in known}, 1.0),
            readings_by({name: plus(value, dot(row, self.correction.shift)) for name, value, _, row in known}),
        )

    def moved(self, mean: Vector, most: Vector) -> list[Scalar]:
        """Mean after the correction, limited to its bounds."""
        shifted = (value + shift for value, shift in zip(mean, self.correction.shift, strict=True))
        return [limit(value, -bound, bound) for value, bound in zip(shifted, most, strict=True)]

    def log_likelihood(self, widths: Vector, influence: Scalar) -> Scalar:
        """Log-likelihood of the present readings: normal innovations if used, uniform over a range if left out [nat].

        A normalised innovation counts up to `influence`.
        """
        squares: Scalar = 0.0
        widening: Scalar = 1.0
        for over, wide in zip(self.correction.whitened, self.correction.widening, strict=True):
            squares = squares + minimum(over * over, influence * influence)
            # One logarithm of the product in place of one per reading: relative to the usual noise it stays near one,
            # where the series of `logarithm` is exact.
            widening = widening * wide
        total = -0.5 * (squares + logarithm(widening))
        for reading, counts, variance, width in zip(self.innovations, self.used, self.usual, widths, strict=True):
            left_out = where(present(reading), -log(width), 0.0)
            total = total + where(counts, -0.5 * log(2.0 * math.pi * variance), left_out)
        return total


def observed(
    covariance: Vector,
    expected: Vector,
    rows: Matrix,
    readings: Vector,
    noise: Vector,
    usual: Vector,
    trusted: Vector,
    influence: Scalar,
) -> Innovations:
    """Innovations and correction of a sample by a filter that may leave readings out."""
    innovations = tuple(reading - value for reading, value in zip(readings, expected, strict=True))
    used = [both(present(each), use > 0.5) for each, use in zip(innovations, trusted, strict=True)]
    spread = [plus(spread_of(covariance, row), variance) for row, variance in zip(rows, noise, strict=True)]
    correction = update(covariance, rows, innovations, noise, usual, used, influence)
    return Innovations(expected, rows, innovations, used, spread, usual, correction)


def update(
    covariance: Vector,
    rows: Matrix,
    innovations: Vector,
    noise: Vector,
    usual: Vector,
    used: Vector,
    influence: Scalar,
) -> Correction:
    """Sequential scalar updates; equal to the joint update with diagonal noise while no innovation is bounded."""
    after = unpack(covariance)
    n = len(after)
    shift: list[Scalar] = [0.0] * n
    whitened, widening = [], []
    for row, innovation, variance, nominal, counts in zip(rows, innovations, noise, usual, used, strict=True):
        cross = [dot(row, column) for column in after]
        spread = plus(dot(row, cross), variance)
        # An infinite variance leaves a reading out without a branch, so that all lanes run the same code.
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


def spread_of(covariance: Vector, row: Vector) -> Scalar:
    """Variance row P row' of a linear function of the state, P packed."""
    full = unpack(covariance)
    return dot(
        row, [0.0 if is_structural(entry, 0.0) else dot(row, column) for entry, column in zip(row, full, strict=True)]
    )


def logarithm(value: Scalar) -> Scalar:
    """Natural logarithm of a positive value, without a library function, which would prevent vectorisation of lanes.

    Validity: to 1e-9 between 1e-6 and 1e6, to 1e-3 between 1e-20 and 1e20.
    Source: 64 log(x^(1/64)), log(y) = 2 artanh((y - 1) / (y + 1)) by its series.
    """
    for _ in range(_ROOTS):
        value = sqrt(value)
    share = (value - 1.0) / (value + 1.0)
    square = share * share
    series = 1.0 + square * (1.0 / 3.0 + square * (1.0 / 5.0 + square * (1.0 / 7.0 + square / 9.0)))
    return 2.0 ** (_ROOTS + 1) * share * series
