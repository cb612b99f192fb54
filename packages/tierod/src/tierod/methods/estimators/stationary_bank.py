"""Interacting bank of Kalman filters with stationary gains: one linear model with several process noises."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple, get_type_hints

import numpy as np

from tierod.core.block import Model, Scalar, Tree, named_tuple, rebuild, require_discrete, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import all_of, exp, greatest_of, present, select, where
from tierod.methods.estimators import kernels
from tierod.methods.estimators.observers import Gain, Noises, check_gain, stationary_gain
from tierod.methods.estimators.shapes import estimate_class, filled, leaf_values, sample_class
from tierod.models.linear import LinearSystem

# Transition probabilities from one model (row) to another (column) in one sample; each row sums to 1
Switching = tuple[tuple[float, ...], ...]


def check_switching(switching: Switching, count: int) -> None:
    """Check that probabilities are those of a Markov chain in which every model can be reached from every other."""
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


def mixing(probabilities: kernels.Vector, switching: Switching) -> Mixing:
    """First step of the interaction: predicted probabilities and mixing weights.

    Source: Blom and Bar-Shalom, IEEE Trans. Automatic Control 33 (1988) 780, doi 10.1109/9.1299.
    """
    count = len(switching)
    predicted = tuple(kernels.dot(probabilities, [row[j] for row in switching]) for j in range(count))
    weights = tuple(
        tuple(probabilities[i] * switching[i][j] / predicted[j] for i in range(count)) for j in range(count)
    )
    return Mixing(predicted, weights)


def weighed(weights: kernels.Vector, vectors: kernels.Matrix) -> tuple[Scalar, ...]:
    return tuple(kernels.dot(weights, column) for column in zip(*vectors, strict=True))


def posterior(predicted: kernels.Vector, log_likelihoods: kernels.Vector) -> tuple[Scalar, ...]:
    """Probability of each model after the sample; the largest likelihood is scaled to 1, so that none underflows."""
    best = greatest_of(*log_likelihoods)
    shares = [prior * exp(value - best) for prior, value in zip(predicted, log_likelihoods, strict=True)]
    scale = 1.0 / sum(shares[1:], start=shares[0])
    return tuple(share * scale for share in shares)


def mixture_variance(
    weights: kernels.Vector, mean: kernels.Vector, means: kernels.Matrix, variances: kernels.Matrix
) -> tuple[Scalar, ...]:
    """Variance of every entry of a mixture; for missing entries (NaN) the mean variance of the parts."""
    total: list[Scalar] = [0.0] * len(mean)
    for weight, part, spread in zip(weights, means, variances, strict=True):
        for k, (a, b, variance) in enumerate(zip(part, mean, spread, strict=True)):
            away = where(present(a), a - b, 0.0)
            total[k] = kernels.plus(total[k], kernels.times(weight, variance + away * away))
    return tuple(total)


class BankState(NamedTuple):
    """Mean of every filter of a bank, flat, and the probability of each filter."""

    means: tuple[tuple[Scalar, ...], ...]
    probabilities: tuple[Scalar, ...]


class StationaryNoise(NamedTuple):
    gain: Gain  # of the filter, rows by state, columns by output
    covariance: tuple[float, ...]  # packed, of the estimate
    innovation_covariance: tuple[float, ...]  # packed
    information: tuple[float, ...]  # inverse of the innovation covariance, packed
    log_determinant: float  # of the innovation covariance


@dataclass(frozen=True)
class StationaryBank:
    """Interacting multiple models with stationary gains, for one linear model with several process noises.

    Only means are mixed; each filter keeps its steady-state gain. The loss is small where each noise lasts longer than
    the settling time of its filter, and the cost is a few multiplications per filter and sample.

    A sample is `input` and `measured`. A missing output (NaN) corrects
    nothing, and a sample with one gives no likelihood; a missing input holds the state.

    Source: Blom and Bar-Shalom, IEEE Trans. Automatic Control 33 (1988) 780, doi 10.1109/9.1299, with the covariance of
    each model taken at its steady state.
    """

    model: Model
    parameters: Tree  # of the model; its floats are tuning
    initial_mean: Tree  # state before the first sample, one float per state
    noises: tuple[StationaryNoise, ...]  # gain and covariances of each filter; `design` computes them
    switching: Switching  # between the filters, each row with sum 1

    def __post_init__(self) -> None:
        require_discrete(self.model)
        check_switching(self.switching, len(self.noises))
        for noise in self.noises:
            check_gain(self.model, noise.gain, self.initial_mean)

    @classmethod
    def design(
        cls,
        system: LinearSystem,
        model: Model,
        parameters: Tree,
        process_noises: Sequence[Noises],
        measurement_noise: Noises,
        switching: Switching,
    ) -> StationaryBank:
        if not process_noises:
            raise ParameterError("process_noises is empty; expected the noise of at least one filter")
        noises = tuple(stationary_noise(system, noise, measurement_noise) for noise in process_noises)
        return cls(model, parameters, (0.0,) * len(system.A), noises, switching)

    @property
    def Sample(self) -> type:
        return sample_class(self.model, ())

    @property
    def Estimate(self) -> type:
        return _estimate_class(self.model, len(self.noises))

    def at(self, mean: Tree) -> BankState:
        """The state of a bank that starts at a mean, with equal probabilities of all filters."""
        count = len(self.noises)
        return BankState((leaf_values(mean),) * count, (1.0 / count,) * count)

    def mean(self, state: BankState) -> Tree:
        """The estimate of a state: the means of all filters weighted with their probabilities, as the model's State."""
        return rebuild(skeleton(self.model.State), weighed(state.probabilities, state.means))

    def init(self) -> BankState:
        return self.at(self.initial_mean)

    def step(self, state: BankState, sample: Tree) -> tuple[BankState, Tree]:
        origin = mixing(state.probabilities, self.switching)
        measured = leaf_values(sample.measured)
        complete = all_of(*(present(value) for value in measured))
        means, innovations, scores = [], [], []
        for noise, weights in zip(self.noises, origin.weights, strict=True):
            predicted, innovation = self._predicted(weighed(weights, state.means), sample)
            used = [where(present(value), value, 0.0) for value in innovation]
            means.append(kernels.add(predicted, kernels.product(noise.gain, used)))
            innovations.append(innovation)
            scores.append(
                where(complete, kernels.dot(used, kernels.product(kernels.unpack(noise.information), used)), 0.0)
            )
        likelihoods = [
            where(complete, -0.5 * (score + noise.log_determinant), 0.0)
            for score, noise in zip(scores, self.noises, strict=True)
        ]
        after = BankState(tuple(means), posterior(origin.predicted, likelihoods))
        count: Scalar = sum(where(present(value), 1.0, 0.0) for value in measured)
        whole = kernels.usable(leaf_values(sample.input))
        if whole is not True:
            after = select(whole, after, state)
            count = where(whole, count, 0.0)
            scores = [where(whole, score, 0.0) for score in scores]
        return after, self._estimate(after, origin.predicted, innovations, scores, count)

    def _predicted(self, mean: kernels.Vector, sample: Tree) -> tuple[tuple[Scalar, ...], tuple[Scalar, ...]]:
        at = self.model.transition(rebuild(skeleton(self.model.State), mean), sample.input, self.parameters)
        expected = leaf_values(self.model.output(at, sample.input, self.parameters))
        return leaf_values(at), tuple(y - z for y, z in zip(leaf_values(sample.measured), expected, strict=True))

    def _estimate(
        self,
        state: BankState,
        predicted: kernels.Vector,
        innovations: kernels.Matrix,
        scores: kernels.Vector,
        count: Scalar,
    ) -> Tree:
        mean = weighed(state.probabilities, state.means)
        variance = mixture_variance(
            state.probabilities, mean, state.means, [kernels.diagonal(noise.covariance) for noise in self.noises]
        )
        expected = weighed(predicted, innovations)
        spread = mixture_variance(
            predicted, expected, innovations, [kernels.diagonal(noise.innovation_covariance) for noise in self.noises]
        )
        figures = (kernels.dot(state.probabilities, scores), count)
        return filled(self.Estimate, mean, variance, expected, spread, figures, state.probabilities)


def stationary_noise(system: LinearSystem, process_noise: Noises, measurement_noise: Noises) -> StationaryNoise:
    """Gain and covariances of the stationary Kalman filter of a discrete system."""
    found = stationary_gain(system, process_noise, measurement_noise)
    return StationaryNoise(
        tuple(tuple(map(float, row)) for row in found.filter),
        kernels.pack(found.covariance.tolist()),
        kernels.pack(found.innovation_covariance.tolist()),
        kernels.pack(np.linalg.inv(found.innovation_covariance).tolist()),
        float(np.linalg.slogdet(found.innovation_covariance)[1]),
    )


@lru_cache(maxsize=64)
def _estimate_class(model: Model, count: int) -> type:
    """Class of the output of a bank: the fields of one filter, and the probability of each model."""
    single = estimate_class(model, False)
    hints = get_type_hints(single, include_extras=True)
    fields = [(name, hints[name]) for name in single._fields]  # type: ignore[attr-defined]
    shares = tuple[(Annotated[float, ""],) * count]  # type: ignore[misc, valid-type]
    return named_tuple("ImmEstimate", [*fields, ("probabilities", shares)])
