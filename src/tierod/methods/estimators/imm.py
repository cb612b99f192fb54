"""Interacting multiple models (IMM): Kalman filters of one state under several models, weighted by likelihood."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Annotated, NamedTuple, get_type_hints

from tierod.core.block import Scalar, Tree, Truth, named_tuple, rebuild
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import log, present, where
from tierod.core.model import Model
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import correct_in_turn, held_covariance, usable
from tierod.methods.estimators.linear_algebra import Matrix, Vector, add, diagonal, dot, plus
from tierod.methods.estimators.mixing import (
    Switching,
    check_probabilities,
    check_switching,
    mixing,
    mixture_covariance,
    mixture_variance,
    posterior,
    weighed,
)
from tierod.methods.estimators.shapes import (
    Belief,
    estimate_class,
    filled,
    leaf_names,
    leaf_values,
    sample_class,
)


class Likely(NamedTuple):
    """A correction with its likelihood: mean, packed covariance, NIS, number of measurements, log-likelihood."""

    mean: tuple[Scalar, ...]
    covariance: tuple[Scalar, ...]
    nis: Scalar
    present: Scalar
    log_likelihood: Scalar


def correct_with_likelihood(mean: Vector, covariance: Vector, rows: Matrix, residuals: Vector, noise: Vector) -> Likely:
    """`kernels.correct` output by output, with the log-likelihood of the outputs that are present.

    The constant of the Gaussian density is left out, since the compared models have the same outputs.
    """
    done, _, spreads = correct_in_turn(covariance, rows, residuals, noise)
    logarithms = [where(present(value), log(spread), 0.0) for value, spread in zip(residuals, spreads, strict=True)]
    log_likelihood = -0.5 * (done.nis + functools.reduce(plus, logarithms, 0.0))
    return Likely(add(mean, done.shift), done.covariance, done.nis, done.present, log_likelihood)


class ImmState(NamedTuple):
    """Estimate of every filter, and the probability of its model."""

    beliefs: tuple[Belief, ...]
    probabilities: tuple[Scalar, ...]


@dataclass(frozen=True)
class ImmFilter:
    """Interacting multiple models: Kalman filters of one state with estimates mixed by the models' probabilities.

    Args:
        filters: any number of `KalmanFilter` with the same State, Input and Output, without masks and gate; they may
            differ in model, parameters and noises
        switching: between the models, see `switching_of`
        initial_probabilities: of the models

    A sample is that of a `KalmanFilter`. The estimate has the same fields, for the mixture (`nis` is weighted with the
    models' probabilities), and `probabilities`. Missing outputs neither correct nor change the model probabilities, a
    missing input holds all means.

    Validity: as `KalmanFilter`; each model holds for many samples at a time.
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
        return imm_estimate_class(self.filters[0].model, len(self.filters))

    def init(self) -> ImmState:
        """Estimates and probabilities before the first sample."""
        return ImmState(tuple(f.init() for f in self.filters), tuple(self.initial_probabilities))

    def step(self, state: ImmState, sample: Tree) -> tuple[ImmState, Tree]:
        """State and estimate after one sample: mixing, a step of every filter, and new model probabilities."""
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

    def _held(self, state: ImmState, probabilities: Vector, done: list[Likely], sample: Tree) -> ImmState:
        """The next state; a missing input holds means and probabilities, and the covariances grow."""
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
        return ImmState(tuple(beliefs), shares)

    def _whole(self, sample: Tree) -> Truth:
        return usable(leaf_values(sample.input)) if self.filters[0].hold_missing_input else True

    def _estimate(
        self,
        state: ImmState,
        predicted: Vector,
        done: list[Likely],
        innovations: Matrix,
        spreads: Matrix,
        whole: Truth,
    ) -> Tree:
        means = [leaf_values(belief.mean) for belief in state.beliefs]
        mean = weighed(state.probabilities, means)
        covariances = [belief.covariance for belief in state.beliefs]
        variance = diagonal(mixture_covariance(state.probabilities, mean, means, covariances))
        expected = weighed(predicted, innovations)
        spread = mixture_variance(predicted, expected, innovations, spreads)
        nis, count = dot(state.probabilities, [each.nis for each in done]), done[0].present
        if whole is not True:
            nis, count = where(whole, nis, 0.0), where(whole, count, 0.0)
        return filled(self.Estimate, mean, variance, expected, spread, (nis, count), state.probabilities)


@functools.lru_cache(maxsize=64)
def imm_estimate_class(model: Model, count: int) -> type:
    """Class of the output of a bank: the fields of one filter, and the probability of each model."""
    single = estimate_class(model, False)
    hints = get_type_hints(single, include_extras=True)
    fields = [(name, hints[name]) for name in single._fields]  # type: ignore[attr-defined]
    shares = tuple[(Annotated[float, ""],) * count]  # type: ignore[misc, valid-type]
    return named_tuple("ImmEstimate", [*fields, ("probabilities", shares)])


def _filtered(filter_: KalmanFilter, start: Belief, sample: Tree) -> tuple[Likely, Vector, Vector]:
    """One filter's step from a mixed estimate: its correction, innovations, and their variances."""
    entering = leaf_values(filter_.input_noise)
    predicted = filter_._predict(start, sample.input, leaf_values(filter_.process_noise), entering)
    rows, innovation, known = filter_.innovations(predicted, sample)
    noise = leaf_values(filter_.measurement_noise)
    spread = tuple(plus(each, value) for each, value in zip(known, noise, strict=True))
    return correct_with_likelihood(predicted.mean, predicted.covariance, rows, innovation, noise), innovation, spread
