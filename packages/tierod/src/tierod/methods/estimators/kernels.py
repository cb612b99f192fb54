"""Steps of every Kalman-type estimator, and small dense linear algebra, on tuples of scalars in straight-line code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from tierod.core.block import Scalar, Truth
from tierod.core.graph.maths import is_symbol, maximum, minimum, present, where

Vector = Sequence[Scalar]
Matrix = Sequence[Sequence[Scalar]]
Noise = Sequence[Scalar | None]  # Variances; None where there is no noise


def is_structural(value: Scalar, constant: float) -> bool:
    """Whether a value is this constant float, which can be left out of a graph."""
    return not is_symbol(value) and isinstance(value, float) and value == constant


def times(a: Scalar, b: Scalar) -> Scalar:
    """Product a b; structural factors 0.0 and 1.0 add no operation."""
    if is_structural(a, 0.0) or is_structural(b, 0.0):
        return 0.0
    if is_structural(a, 1.0):
        return b
    return a if is_structural(b, 1.0) else a * b


def plus(a: Scalar, b: Scalar) -> Scalar:
    """Sum a + b; a structural term 0.0 adds no operation."""
    if is_structural(a, 0.0):
        return b
    return a if is_structural(b, 0.0) else a + b


def minus(a: Scalar, b: Scalar) -> Scalar:
    """Difference a - b; a structural term b = 0.0 adds no operation."""
    return a if is_structural(b, 0.0) else a - b


def dot(a: Vector, b: Vector) -> Scalar:
    """Sum of a_k b_k, accumulated from the first element to the last."""
    total: Scalar = 0.0
    for left, right in zip(a, b, strict=True):
        total = plus(total, times(left, right))
    return total


def upper(n: int) -> list[tuple[int, int]]:
    """Index pairs (row, column) of a packed symmetric matrix, in order."""
    return [(i, j) for i in range(n) for j in range(i, n)]


def order(packed: Vector) -> int:
    """Number of rows of a packed symmetric matrix."""
    return (math.isqrt(8 * len(packed) + 1) - 1) // 2


def unpack(packed: Vector) -> list[list[Scalar]]:
    """All rows of a packed symmetric matrix."""
    n = order(packed)
    rows: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    for value, (i, j) in zip(packed, upper(n), strict=True):
        rows[i][j] = rows[j][i] = value
    return rows


def pack(rows: Matrix) -> tuple[Scalar, ...]:
    """The upper triangle of a symmetric matrix."""
    return tuple(rows[i][j] for i, j in upper(len(rows)))


def diagonal(packed: Vector) -> tuple[Scalar, ...]:
    return tuple(value for value, (i, j) in zip(packed, upper(order(packed)), strict=True) if i == j)


def from_diagonal(values: Vector) -> tuple[Scalar, ...]:
    """The packed symmetric matrix with this diagonal."""
    return tuple(values[i] if i == j else 0.0 for i, j in upper(len(values)))


def add(a: Vector, b: Vector) -> tuple[Scalar, ...]:
    """a + b, element by element (vectors or packed matrices)."""
    return tuple(plus(left, right) for left, right in zip(a, b, strict=True))


def product(matrix: Matrix, vector: Vector) -> tuple[Scalar, ...]:
    return tuple(dot(row, vector) for row in matrix)


def quadratic(row: Vector, packed: Vector) -> Scalar:
    """c P c': variance of c x for a row c and a state x with the packed covariance P."""
    return dot(row, product(unpack(packed), row))


def downdate(rows: list[list[Scalar]], cross: Vector, inverse: Scalar) -> None:
    """P - c c' / s in place: the covariance after one scalar measurement."""
    gain = [times(value, inverse) for value in cross]
    for i, j in upper(len(cross)):
        rows[i][j] = rows[j][i] = minus(rows[i][j], times(gain[i], cross[j]))


def congruence(matrix: Matrix, packed: Vector) -> tuple[Scalar, ...]:
    """M P M', packed, by way of W = M P: symmetric by construction."""
    full = unpack(packed)
    left = [[dot(row, column) for column in full] for row in matrix]
    return tuple(dot(left[i], matrix[j]) for i, j in upper(len(matrix)))


def scaled_congruence(matrix: Matrix, weights: Vector) -> tuple[Scalar, ...]:
    """G diag(q) G', packed. Args: weights: q, m values; 0.0 leaves the column out."""
    scaled = [[times(entry, weight) for entry, weight in zip(row, weights, strict=True)] for row in matrix]
    return tuple(dot(scaled[i], matrix[j]) for i, j in upper(len(matrix)))


class Correction(NamedTuple):
    """Correction by the measurements of one sample."""

    shift: tuple[Scalar, ...]  # `start` plus the correction of the mean, before any mask, (n,)
    covariance: tuple[Scalar, ...]  # packed covariance after all measurements
    nis: Scalar  # normalised innovation squared over the measurements that were present
    present: Scalar  # number of measurements that were present


def known_variances(values: Noise) -> tuple[Scalar, ...]:
    """Variances, with the structural zero in place of None (no noise)."""
    return tuple(0.0 if value is None else value for value in values)


def predict_covariance(
    transition: Matrix, covariance: Vector, process_noise: Noise, noise_input: Matrix = (), input_noise: Noise = ()
) -> tuple[Scalar, ...]:
    """F P F' + diag(q) + G diag(w) G', packed.

    Args: process_noise: variance added to each state per sample, (n,); None or 0.0 for none.
    """
    predicted = add(congruence(transition, covariance), from_diagonal(known_variances(process_noise)))
    if any(weight is not None for weight in input_noise):
        predicted = add(predicted, scaled_congruence(noise_input, known_variances(input_noise)))
    return predicted


def correct(
    covariance: Vector, rows: Matrix, residuals: Vector, noise: Vector, start: Vector | None = None
) -> Correction:
    """Correction by scalar updates, one per measurement; a missing residual (NaN) changes nothing.

    The result does not depend on the order of the measurements: it is the joint update with a diagonal R.

    Args: residuals: measured minus expected output, (m,); NaN where the measurement is missing; start: that the
    correction is added to, (n,); zeros by default. The mean here saves an addition per state.
    """
    after = unpack(covariance)
    n = len(after)
    shift: list[Scalar] = [0.0] * n if start is None else list(start)
    open_residuals = list(residuals)
    nis: Scalar = 0.0
    count: Scalar = 0.0
    for k, (row, variance) in enumerate(zip(rows, noise, strict=True)):
        there = present(residuals[k])
        cross = [dot(row, column) for column in after]
        inverse = 1.0 / where(there, plus(dot(row, cross), variance), math.inf)
        innovation = where(there, open_residuals[k], 1.0)  # any number: its weight 1 / inf is 0
        weighted = innovation * inverse
        shift = [plus(done, times(value, weighted)) for done, value in zip(shift, cross, strict=True)]
        # `shift` may have started at the mean, so it cannot correct the residuals that follow; each step does.
        for later in range(k + 1, len(rows)):
            open_residuals[later] = minus(open_residuals[later], times(dot(rows[later], cross), weighted))
        downdate(after, cross, inverse)
        nis = plus(nis, innovation * weighted)
        count = plus(count, where(there, 1.0, 0.0))
    return Correction(tuple(shift), pack(after), nis, count)


class InTurn(NamedTuple):
    """A sequential correction by one measurement after the other."""

    correction: Correction  # by all measurements
    residuals: tuple[Scalar, ...]  # innovation of each measurement given those before it, (m,)
    spreads: tuple[Scalar, ...]  # variance of each residual, (m,)


def correct_in_turn(covariance: Vector, rows: Matrix, residuals: Vector, noise: Vector) -> InTurn:
    """`correct`, with the innovation of each measurement given those before it: the factors of the joint likelihood."""
    shift: Vector = [0.0] * order(covariance)
    nis: Scalar = 0.0
    count: Scalar = 0.0
    left, spreads = [], []
    for row, residual, variance in zip(rows, residuals, noise, strict=True):
        left.append(minus(residual, dot(row, shift)))
        spreads.append(plus(quadratic(row, covariance), variance))
        done = correct(covariance, (row,), (left[-1],), (variance,), shift)
        nis, count = plus(nis, done.nis), plus(count, done.present)
        shift, covariance = done.shift, done.covariance
    return InTurn(Correction(tuple(shift), tuple(covariance), nis, count), tuple(left), tuple(spreads))


def clean_mask(mask: Sequence[Truth]) -> tuple[Truth, ...]:
    """Masks limited to 0..1, 0 where missing; the Python value True is kept and adds no operation to a graph."""
    return tuple(True if value is True else minimum(maximum(0.0, value), 1.0) for value in mask)


def unmasked_start(mean: Vector, mask: Sequence[Truth]) -> tuple[Scalar, ...]:
    """Start of a correction: the mean of unmasked states; zero for masked ones, whose correction is scaled first."""
    return tuple(value if share is True else 0.0 for value, share in zip(mean, mask, strict=True))


def masked_mean(mean: Vector, moved: Vector, mask: Sequence[Truth]) -> tuple[Scalar, ...]:
    """x + E K (y - C x), from a correction that started at `unmasked_start`."""
    triples = zip(mean, moved, mask, strict=True)
    return tuple(new if share is True else value + share * new for value, new, share in triples)


def consider(before: Vector, after: Vector, mask: Sequence[Truth]) -> tuple[Scalar, ...]:
    """Covariance of the estimate corrected with the masked gain Ke = E K: consistent (Schmidt, Joseph).

    With the optimal K of the joint update, (I - Ke C) P (I - Ke C)' + Ke R Ke' reduces entry by entry to
    P - (1 - (1 - e_i)(1 - e_j)) (P - P_after): only pairs of masked states differ from the full update.

    Source: Mohtat et al., Table 3, corrected: printed with P = (I - K C) P for every mask; see
    docs/explanation/papers/friction.md.
    """
    entries = []
    for old, new, (i, j) in zip(before, after, upper(len(mask)), strict=True):
        if mask[i] is True or mask[j] is True:
            entries.append(new)
            continue
        # For an open mask the full update itself: old - (old - new) would round off a variance that is much smaller.
        kept = (1.0 - mask[i]) * (1.0 - mask[j])
        entries.append(where(kept <= 0.0, new, old - (1.0 - kept) * (old - new)))
    return tuple(entries)


def usable(inputs: Vector) -> Truth:
    """Whether every input is present; the Python value True for a model without inputs."""
    # One NaN makes the sum NaN: a single test in place of one for each input.
    return present(sum(inputs[1:], start=inputs[0])) if inputs else True


def held_covariance(covariance: Vector, process_noise: Noise) -> tuple[Scalar, ...]:
    """Covariance of a mean that is held for one sample: it grows by the process noise."""
    return add(covariance, from_diagonal(known_variances(process_noise)))
