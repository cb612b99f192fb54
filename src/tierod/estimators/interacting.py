"""Interacting multiple models: Kalman filters of one state, each for one behaviour, weighed by their likelihood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, get_type_hints

from tierod.block import Tree, named_tuple, rebuild, skeleton
from tierod.errors import ParameterError
from tierod.estimators.kalman import KalmanFilter
from tierod.estimators.kernels import correct, held_covariance, usable
from tierod.estimators.linear_algebra import Matrix, Vector, add, diagonal, dot, minus, plus, product, times, unpack
from tierod.estimators.linear_algebra import upper as pairs
from tierod.estimators.shapes import (
    Belief,
    class_of_innovation_variance,
    class_of_variance,
    estimate_class,
    leaf_names,
    leaf_values,
    sample_class,
)
from tierod.graph.derivatives import jacobian
from tierod.graph.maths import exp, log, maximum, present, where

Switching = tuple[tuple[float, ...], ...]
"""Probability of going from one model (row) to another (column) in one sample; each row sums to 1."""


def check_switching(switching: Switching, count: int) -> None:
    """Refuse probabilities that are not those of a chain in which every model can be reached from every other.

    Raises:
        ParameterError: of another size, not positive, or rows that do not sum to 1
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
    """Switching of models that last for mean times and are followed by any other alike.

    Args:
        lasting: mean time of each model [s]
        sample_time: [s]

    Raises:
        ParameterError: a model that does not last longer than a sample
    """
    if not all(time > sample_time > 0.0 for time in lasting):
        raise ParameterError(f"models last {tuple(lasting)} s; expected more than a sample of {sample_time} s each")
    others = max(len(lasting) - 1, 1)
    leave = [sample_time / time if len(lasting) > 1 else 0.0 for time in lasting]
    return tuple(
        tuple(1.0 - leave[i] if i == j else leave[i] / others for j in range(len(lasting))) for i in range(len(lasting))
    )


class Mixing(NamedTuple):
    """Probability of each model before the sample, and the weights of the old estimates in each new one."""

    predicted: tuple[Any, ...]
    weights: tuple[tuple[Any, ...], ...]


def mixing(probabilities: Vector, switching: Switching) -> Mixing:
    """Step one of the interaction: where each model comes from.

    Source: Blom and Bar-Shalom, IEEE Trans. Automatic Control 33 (1988) 780, doi 10.1109/9.1299.
    """
    count = len(switching)
    predicted = tuple(dot(probabilities, [row[j] for row in switching]) for j in range(count))
    weights = tuple(
        tuple(probabilities[i] * switching[i][j] / predicted[j] for i in range(count)) for j in range(count)
    )
    return Mixing(predicted, weights)


def weighed(weights: Vector, vectors: Matrix) -> tuple[Any, ...]:
    """Weighted sum of vectors."""
    return tuple(dot(weights, column) for column in zip(*vectors, strict=True))


def mixture_covariance(weights: Vector, mean: Vector, means: Matrix, covariances: Matrix) -> tuple[Any, ...]:
    """Packed covariance of a mixture: that of its parts and that between their means."""
    total: list[Any] = [0.0] * len(covariances[0])
    for weight, part, covariance in zip(weights, means, covariances, strict=True):
        away = [a - b for a, b in zip(part, mean, strict=True)]
        spread = [plus(value, away[i] * away[j]) for value, (i, j) in zip(covariance, pairs(len(mean)), strict=True)]
        total = [plus(done, times(weight, value)) for done, value in zip(total, spread, strict=True)]
    return tuple(total)


def posterior(predicted: Vector, log_likelihoods: Vector) -> tuple[Any, ...]:
    """Probability of each model after the sample; the likeliest counts 1 before scaling, so nothing underflows."""
    best = log_likelihoods[0]
    for value in log_likelihoods[1:]:
        best = maximum(best, value)
    shares = [prior * exp(value - best) for prior, value in zip(predicted, log_likelihoods, strict=True)]
    scale = 1.0 / sum(shares[1:], start=shares[0])
    return tuple(share * scale for share in shares)


class Likely(NamedTuple):
    """A correction with its likelihood: mean, packed covariance, normalised innovation squared, number, logarithm."""

    mean: tuple[Any, ...]
    covariance: tuple[Any, ...]
    nis: Any
    present: Any
    log_likelihood: Any


def correct_with_likelihood(mean: Vector, covariance: Vector, rows: Matrix, residuals: Vector, noise: Vector) -> Likely:
    """`kernels.correct` one output after the other, with the logarithm of the likelihood of what is present.

    The constant of the Gaussian density is left out: models that are compared see the same outputs.
    """
    shift: Vector = [0.0] * len(mean)
    nis: Any = 0.0
    count: Any = 0.0
    log_determinant: Any = 0.0
    for row, residual, variance in zip(rows, residuals, noise, strict=True):
        spread = plus(dot(row, product(unpack(covariance), row)), variance)
        done = correct(covariance, (row,), (minus(residual, dot(row, shift)),), (variance,), shift)
        log_determinant = plus(log_determinant, where(present(residual), log(spread), 0.0))
        nis, count = plus(nis, done.nis), plus(count, done.present)
        shift, covariance = done.shift, done.covariance
    return Likely(add(mean, shift), tuple(covariance), nis, count, -0.5 * (nis + log_determinant))


class InteractingState(NamedTuple):
    """Belief of every filter, and the probability that its model is the right one."""

    beliefs: tuple[Any, ...]
    probabilities: tuple[Any, ...]


@dataclass(frozen=True)
class InteractingFilter:
    """Interacting multiple models: Kalman filters of one state whose estimates are mixed by the models' probabilities.

    Args:
        filters: any number of `KalmanFilter` with the same State, Input and Output, without masks and gate; they may
            differ in model, parameters and noises
        switching: between the models, see `switching_of`
        initial_probabilities: of the models

    A sample is that of a `KalmanFilter`. The estimate has its fields, of the mixture (`nis` weighed by the models'
    probabilities), and `probabilities`. Missing outputs correct nothing and say nothing about the models, a missing
    input holds all means.

    Validity: as `KalmanFilter`; models that last many samples.
    Source: Blom and Bar-Shalom, IEEE Trans. Automatic Control 33 (1988) 780, doi 10.1109/9.1299.
    """

    filters: tuple[KalmanFilter, ...]
    switching: Switching
    initial_probabilities: tuple[float, ...]

    def __post_init__(self) -> None:
        check_switching(self.switching, len(self.filters))
        check_probabilities(self.initial_probabilities, len(self.filters))
        first = self.filters[0].model
        shapes = {(leaf_names(f.model.State), f.model.Input, f.model.Output) for f in self.filters}
        if len(shapes) > 1 or any(f.maskable or f.gate is not None for f in self.filters):
            raise ParameterError(
                "the filters of a bank share one state, input and output and have no masks and no gate; "
                f"{first.__name__} and {', '.join(f.model.__name__ for f in self.filters[1:])} do not"
            )

    @property
    def Sample(self) -> type:
        """NamedTuple class with `input` and `measured`."""
        return sample_class(self.filters[0].model, ())

    @property
    def Estimate(self) -> type:
        """NamedTuple class of the output."""
        return interacting_estimate_class(self.filters[0].model, len(self.filters))

    def init(self) -> InteractingState:
        """The beliefs before the first sample."""
        return InteractingState(tuple(f.init() for f in self.filters), tuple(self.initial_probabilities))

    def step(self, state: InteractingState, sample: Any) -> tuple[InteractingState, Any]:
        """One sample on: mix, let every filter predict and correct, weigh."""
        origin = mixing(state.probabilities, self.switching)
        means = [leaf_values(belief.mean) for belief in state.beliefs]
        covariances = [belief.covariance for belief in state.beliefs]
        done, innovations, spreads = [], [], []
        for filter_, weights in zip(self.filters, origin.weights, strict=True):
            mean = weighed(weights, means)
            start = Belief(rebuild(state.beliefs[0].mean, mean), mixture_covariance(weights, mean, means, covariances))
            likely, innovation, spread = _filtered(filter_, start, sample)
            done.append(likely)
            innovations.append(innovation)
            spreads.append(spread)
        probabilities = posterior(origin.predicted, [each.log_likelihood for each in done])
        held = self._held(state, probabilities, done, sample)
        return held, self._estimate(held, origin.predicted, done, innovations, spreads, self._whole(sample))

    def _held(self, state: InteractingState, probabilities: Vector, done: list[Likely], sample: Any) -> Any:
        """The next state; a missing input holds means and probabilities and lets the covariances grow."""
        whole = self._whole(sample)
        beliefs = []
        for filter_, before, now in zip(self.filters, state.beliefs, done, strict=True):
            mean, covariance = now.mean, now.covariance
            if whole is not True:
                grown = held_covariance(before.covariance, leaf_values(filter_.process_noise))
                mean = tuple(where(whole, a, b) for a, b in zip(mean, leaf_values(before.mean), strict=True))
                covariance = tuple(where(whole, a, b) for a, b in zip(covariance, grown, strict=True))
            beliefs.append(Belief(rebuild(before.mean, mean), covariance))
        shares = tuple(probabilities)
        if whole is not True:
            shares = tuple(where(whole, a, b) for a, b in zip(shares, state.probabilities, strict=True))
        return InteractingState(tuple(beliefs), shares)

    def _whole(self, sample: Any) -> Any:
        return usable(leaf_values(sample.input)) if self.filters[0].hold_missing_input else True

    def _estimate(
        self,
        state: InteractingState,
        predicted: Vector,
        done: list[Likely],
        innovations: Matrix,
        spreads: Matrix,
        whole: Any,
    ) -> Any:
        model = self.filters[0].model
        means = [leaf_values(belief.mean) for belief in state.beliefs]
        mean = weighed(state.probabilities, means)
        covariance = mixture_covariance(
            state.probabilities, mean, means, [belief.covariance for belief in state.beliefs]
        )
        expected = weighed(predicted, innovations)
        outputs = skeleton(model.Output)
        nis, count = dot(state.probabilities, [each.nis for each in done]), done[0].present
        if whole is not True:
            nis, count = where(whole, nis, 0.0), where(whole, count, 0.0)
        return self.Estimate(
            rebuild(state.beliefs[0].mean, mean),
            rebuild(skeleton(class_of_variance(model)), diagonal(covariance)),
            rebuild(outputs, expected),
            rebuild(
                skeleton(class_of_innovation_variance(model)),
                mixture_variance(predicted, expected, innovations, spreads),
            ),
            nis,
            count,
            state.probabilities,
        )


def mixture_variance(weights: Vector, mean: Vector, means: Matrix, variances: Matrix) -> tuple[Any, ...]:
    """Variance of every entry of a mixture; entries that are missing (NaN) count with the variance of the parts."""
    total: list[Any] = [0.0] * len(mean)
    for weight, part, spread in zip(weights, means, variances, strict=True):
        for k, (a, b, variance) in enumerate(zip(part, mean, spread, strict=True)):
            away = where(present(a), a - b, 0.0)
            total[k] = plus(total[k], times(weight, variance + away * away))
    return tuple(total)


def check_probabilities(values: Sequence[float], count: int) -> None:
    """Refuse what is not one probability per model.

    Raises:
        ParameterError: of another length, negative, or with another sum than 1
    """
    if len(values) != count or not all(value >= 0.0 for value in values) or abs(sum(values) - 1.0) > 1e-9:
        raise ParameterError(f"initial_probabilities is {values}; expected {count} of them whose sum is 1")


@lru_cache(maxsize=64)
def interacting_estimate_class(model: type, count: int) -> type:
    """Output of a bank: that of one filter, and the probability of each model."""
    single = estimate_class(model, False)
    hints = get_type_hints(single, include_extras=True)
    fields = [(name, hints[name]) for name in single._fields]  # type: ignore[attr-defined]
    shares = tuple[(Annotated[float, ""],) * count]  # type: ignore[misc, valid-type]
    return named_tuple("InteractingEstimate", [*fields, ("probabilities", shares)])


def _filtered(filter_: KalmanFilter, start: Belief, sample: Any) -> tuple[Likely, tuple[Any, ...], tuple[Any, ...]]:
    """One filter's step from a mixed belief: its correction, innovations, and their variances."""
    entering = leaf_values(filter_.input_noise)
    predicted = filter_._predict(start, sample.input, leaf_values(filter_.process_noise), entering)

    def output(at: Tree) -> Tree:
        return filter_.model.output(at, sample.input, filter_.parameters)

    at = rebuild(skeleton(filter_.model.State), predicted.mean)
    rows = jacobian(output, at)
    measured, expected = leaf_values(sample.measured), leaf_values(output(at))
    innovation = tuple(a - b for a, b in zip(measured, expected, strict=True))
    noise = leaf_values(filter_.measurement_noise)
    full = unpack(predicted.covariance)
    spread = tuple(plus(dot(row, product(full, row)), value) for row, value in zip(rows, noise, strict=True))
    return correct_with_likelihood(predicted.mean, predicted.covariance, rows, innovation, noise), innovation, spread
