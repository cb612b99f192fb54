"""Small dense linear algebra on tuples of scalars, in straight-line code.

A matrix is a tuple of rows; a symmetric matrix is packed as its upper triangle, row by row. Entries are floats or
symbols; the floats 0.0 and 1.0 are structural and never enter a product, so that sparse models give short graphs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from tierod.core.block import Scalar
from tierod.core.graph.maths import is_symbol

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
    """P - c c' / s in place: the covariance after one scalar measurement.

    Args:
        cross: c, covariance of the state with the measurement
        inverse: 1 / s, of the variance of the innovation
    """
    gain = [times(value, inverse) for value in cross]
    for i, j in upper(len(cross)):
        rows[i][j] = rows[j][i] = minus(rows[i][j], times(gain[i], cross[j]))


def congruence(matrix: Matrix, packed: Vector) -> tuple[Scalar, ...]:
    """M P M', packed, by way of W = M P: symmetric by construction."""
    full = unpack(packed)
    left = [[dot(row, column) for column in full] for row in matrix]
    return tuple(dot(left[i], matrix[j]) for i, j in upper(len(matrix)))


def scaled_congruence(matrix: Matrix, weights: Vector) -> tuple[Scalar, ...]:
    """G diag(q) G', packed.

    Args:
        weights: q, m values; 0.0 leaves the column out
    """
    scaled = [[times(entry, weight) for entry, weight in zip(row, weights, strict=True)] for row in matrix]
    return tuple(dot(scaled[i], matrix[j]) for i, j in upper(len(matrix)))
