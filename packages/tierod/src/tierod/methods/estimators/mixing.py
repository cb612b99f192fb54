"""Interaction of multiple models: switching between them, mixing of their estimates, and their probabilities."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import exp, greatest_of, present, where
from tierod.methods.estimators.linear_algebra import Matrix, Vector, dot, plus, times

Switching = tuple[tuple[float, ...], ...]
"""Transition probabilities from one model (row) to another (column) in one sample; each row sums to 1."""


def check_switching(switching: Switching, count: int) -> None:
    """Check that probabilities are those of a Markov chain in which every model can be reached from every other.

    Raises:
        ParameterError: another size, probabilities that are not positive, or rows that do not sum to 1
    """
    if count < 1 or len(switching) != count or any(len(row) != count for row in switching):
        raise ParameterError(f"switching has {len(switching)} rows; expected {count} rows of {count}, one per model")
    for k, row in enumerate(switching):
        if not all(share > 0.0 for share in row) or abs(sum(row) - 1.0) > 1e-9:
            raise ParameterError(
                f"row {k} of switching is {row}; expected probabilities greater than zero whose sum is 1: a model "
                "that can never be entered is lost for good, so give it a small probability instead of none"
            )


class Mixing(NamedTuple):
    """Predicted probability of each model, and the weights of the previous estimates in the start of each filter."""

    predicted: tuple[Scalar, ...]
    weights: tuple[tuple[Scalar, ...], ...]


def mixing(probabilities: Vector, switching: Switching) -> Mixing:
    """First step of the interaction: predicted probabilities and mixing weights.

    Source: Blom and Bar-Shalom, IEEE Trans. Automatic Control 33 (1988) 780, doi 10.1109/9.1299.
    """
    count = len(switching)
    predicted = tuple(dot(probabilities, [row[j] for row in switching]) for j in range(count))
    weights = tuple(
        tuple(probabilities[i] * switching[i][j] / predicted[j] for i in range(count)) for j in range(count)
    )
    return Mixing(predicted, weights)


def weighed(weights: Vector, vectors: Matrix) -> tuple[Scalar, ...]:
    return tuple(dot(weights, column) for column in zip(*vectors, strict=True))


def posterior(predicted: Vector, log_likelihoods: Vector) -> tuple[Scalar, ...]:
    """Probability of each model after the sample; the largest likelihood is scaled to 1, so that none underflows."""
    best = greatest_of(*log_likelihoods)
    shares = [prior * exp(value - best) for prior, value in zip(predicted, log_likelihoods, strict=True)]
    scale = 1.0 / sum(shares[1:], start=shares[0])
    return tuple(share * scale for share in shares)


def mixture_variance(weights: Vector, mean: Vector, means: Matrix, variances: Matrix) -> tuple[Scalar, ...]:
    """Variance of every entry of a mixture; for missing entries (NaN) the mean variance of the parts."""
    total: list[Scalar] = [0.0] * len(mean)
    for weight, part, spread in zip(weights, means, variances, strict=True):
        for k, (a, b, variance) in enumerate(zip(part, mean, spread, strict=True)):
            away = where(present(a), a - b, 0.0)
            total[k] = plus(total[k], times(weight, variance + away * away))
    return tuple(total)
