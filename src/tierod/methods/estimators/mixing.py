"""Interaction of multiple models: switching between them, mixing of their estimates, and their probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import exp, greatest_of, present, where
from tierod.methods.estimators.linear_algebra import Matrix, Vector, dot, plus, times
from tierod.methods.estimators.linear_algebra import upper as pairs

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


def switching_of(lasting: Sequence[float], sample_time: float) -> Switching:
    """Transition probabilities from the mean duration of each model, with equal probabilities of all successors.

    Args:
        lasting: mean duration of each model [s]
        sample_time: sampling interval [s]

    Raises:
        ParameterError: a model that does not last longer than a sampling interval
    """
    if not all(time > sample_time > 0.0 for time in lasting):
        raise ParameterError(f"models last {tuple(lasting)} s; expected more than a sample of {sample_time} s each")
    others = max(len(lasting) - 1, 1)
    leave = [sample_time / time if len(lasting) > 1 else 0.0 for time in lasting]
    return tuple(
        tuple(1.0 - leave[i] if i == j else leave[i] / others for j in range(len(lasting))) for i in range(len(lasting))
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
    """Weighted sum of vectors."""
    return tuple(dot(weights, column) for column in zip(*vectors, strict=True))


def mixture_covariance(weights: Vector, mean: Vector, means: Matrix, covariances: Matrix) -> tuple[Scalar, ...]:
    """Packed covariance of a mixture: the covariances within its parts plus that of their means."""
    total: list[Scalar] = [0.0] * len(covariances[0])
    for weight, part, covariance in zip(weights, means, covariances, strict=True):
        away = [a - b for a, b in zip(part, mean, strict=True)]
        spread = [plus(value, away[i] * away[j]) for value, (i, j) in zip(covariance, pairs(len(mean)), strict=True)]
        total = [plus(done, times(weight, value)) for done, value in zip(total, spread, strict=True)]
    return tuple(total)


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


def check_probabilities(values: Sequence[float], count: int) -> None:
    """Check that there is one probability per model.

    Raises:
        ParameterError: another length, a negative probability, or a sum other than 1
    """
    if len(values) != count or not all(value >= 0.0 for value in values) or abs(sum(values) - 1.0) > 1e-9:
        raise ParameterError(f"initial_probabilities is {values}; expected {count} of them whose sum is 1")
