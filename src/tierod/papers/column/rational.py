"""The rank of an observability matrix without rounding."""

from __future__ import annotations

from fractions import Fraction

from tierod.models.linear import LinearSystem


def rational_rank(system: LinearSystem) -> int:
    """Rank of the observability matrix of exactly these numbers, by elimination in fractions."""
    A = [[Fraction(float(value)) for value in row] for row in system.A]
    block = [[Fraction(float(value)) for value in row] for row in system.C]
    n = len(A)
    rows = list(block)
    for _ in range(n - 1):
        block = [[sum((row[k] * A[k][j] for k in range(n)), Fraction(0)) for j in range(n)] for row in block]
        rows += block
    rank = 0
    for column in range(n):
        pivot = next((k for k in range(rank, len(rows)) if rows[k][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for k in range(rank + 1, len(rows)):
            if rows[k][column]:
                factor = rows[k][column] / rows[rank][column]
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[rank], strict=True)]
        rank += 1
    return rank
