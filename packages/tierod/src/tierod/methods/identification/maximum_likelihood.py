"""Maximum likelihood estimation of parameters and noises of a model, from the innovations of a Kalman filter."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.block import Model, Tree, rebuild, skeleton, values_of
from tierod.core.graph import scan
from tierod.core.graph.maths import log, present, select, sqrt, where
from tierod.core.graph.trace import jacobian
from tierod.methods.estimators import kernels
from tierod.methods.estimators.shapes import Belief, leaf_values, sample_class
from tierod.methods.identification.experiment import Estimate, Experiment, Free, sandwich, with_values
from tierod.methods.identification.map_search import End, MapSearch


@dataclass(frozen=True)
class Simulation:
    """Simulation of a discrete model with recorded inputs; a missing input holds the state."""

    model: Model
    parameters: Tree  # of the model; its floats are tuning
    initial: Tree

    @property
    def Sample(self) -> type:
        kind: type = self.model.Input
        return kind

    def init(self) -> Tree:
        return rebuild(skeleton(self.model.State), values_of(self.initial))

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Tree]:
        output = self.model.output(state, sample, self.parameters)
        ahead = self.model.transition(state, sample, self.parameters)
        whole = kernels.usable(values_of(sample))
        return ahead if whole is True else select(whole, ahead, state), output


class Surprise(NamedTuple):
    """Standardised innovations of a sample."""

    standardised: Tree  # innovation given the past and the outputs before it, over its standard deviation
    logarithm: Tree  # natural logarithm of that standard deviation; 0 where the output is missing


@dataclass(frozen=True)
class Innovations:
    """Extended Kalman filter that gives the terms of the likelihood of a recording.

    The likelihood of a sample is the product over its outputs, each given those before it. It is valid for correlated
    outputs, and a missing one (NaN) adds no factor. A missing input holds the state.

    Source: F. C. Schweppe, IEEE TIT 11 (1965) 61; L. Ljung, System Identification (1999), section 7.4.
    """

    model: Model
    parameters: Tree  # of the model; its floats are tuning
    initial_mean: Tree
    initial_variance: Tree
    input_variance: Tree  # of the unrecorded part of every input, per sample
    measurement_variance: Tree
    # model for the Jacobians of the covariance; the model itself by default. One with smoothed kinks makes the
    # likelihood a smooth function of the parameters
    tangent: Model | None = None

    @property
    def Sample(self) -> type:
        return sample_class(self.model, ())

    def init(self) -> Belief:
        mean = rebuild(skeleton(self.model.State), leaf_values(self.initial_mean))
        return Belief(mean, kernels.from_diagonal(leaf_values(self.initial_variance)))

    def step(self, state: Belief, sample: Tree) -> tuple[Belief, Surprise]:
        mean, covariance, surprise = self._corrected(state, sample)
        tangent = self.tangent or self.model
        rows = jacobian(lambda x: tangent.transition(x, sample.input, self.parameters), mean)
        gain = jacobian(lambda u: self.model.transition(mean, u, self.parameters), sample.input)
        none = (0.0,) * len(leaf_values(mean))
        ahead = kernels.predict_covariance(rows, covariance, none, gain, leaf_values(self.input_variance))
        moved, whole = (
            self.model.transition(mean, sample.input, self.parameters),
            kernels.usable(leaf_values(sample.input)),
        )
        held = tuple(where(whole, a, b) for a, b in zip(leaf_values(moved), leaf_values(mean), strict=True))
        spread = tuple(where(whole, a, b) for a, b in zip(ahead, covariance, strict=True))
        return Belief(rebuild(mean, held), spread), surprise

    def _corrected(self, state: Belief, sample: Tree) -> tuple[Tree, kernels.Vector, Surprise]:
        def output(x: Tree) -> Tree:
            return self.model.output(x, sample.input, self.parameters)

        rows, expected = jacobian(output, state.mean), leaf_values(output(state.mean))
        innovations = [value - mean for value, mean in zip(leaf_values(sample.measured), expected, strict=True)]
        done = kernels.correct_in_turn(state.covariance, rows, innovations, leaf_values(self.measurement_variance))
        (shift, covariance, _, _), residuals, spreads = done
        standardised, logarithms = [], []
        for residual, spread in zip(residuals, spreads, strict=True):
            there = present(residual)
            standardised.append(where(there, residual, 0.0) / sqrt(spread))
            logarithms.append(where(there, 0.5 * log(spread), 0.0))
        mean = rebuild(state.mean, [kernels.plus(a, b) for a, b in zip(leaf_values(state.mean), shift, strict=True)])
        outputs = skeleton(self.model.Output)
        return mean, covariance, Surprise(rebuild(outputs, standardised), rebuild(outputs, logarithms))


Progress = Callable[[float], None]  # Called with the completed share


@dataclass(frozen=True, eq=False)
class MaximumLikelihood:
    """Parameters of a discrete model, and the noise of its inputs and outputs, from experiments.

    Noise of an input (an unrecorded torque) drives the model. A simulation without it drifts, which least squares of
    simulated outputs would attribute to wrong parameters. For an exact input the estimated noise is zero, and the
    estimate that of least squares (`OutputError`).
    """

    model: Model
    parameters: Tree  # of the model: values of the fixed ones, and start of the free ones
    free: tuple[Free, ...]
    input_deviation: tuple[float, ...]  # standard deviation of the noise of every input per sample, at the start
    output_deviation: tuple[float, ...]  # standard deviation of the noise of every output, at the start
    tangent: Model | None = None  # model for the filter's Jacobians, see `Innovations`
    # factors on the noise of the inputs with which the parameters are fitted first, at fixed noises, since the
    # likelihood for small noise has many local maxima
    widened: tuple[float, ...] = (5.0, 1.5)
    most_steps: int = 30  # largest number of steps of each part of the search
    starts: tuple[tuple[float, ...], ...] = ()  # further starts, as shifts of the coordinates
    # largest number of further searches if one has not converged: from the start, then from the best place
    begin_again: int = 2

    # Step of the finite differences in the coordinates of the search. It shifts the result by half of it, far less
    # than a standard deviation, and is a million times the rounding errors of a run.
    STEP = 1e-5
    ENOUGH = 0.01  # A smaller decrease of the cost ends the search
    LEAST_NOISE = 1e-2  # Lower limit of the noises, over those at the start [-]

    @property
    def _count(self) -> int:
        return len(self.free)

    def start(self) -> np.ndarray:
        """Start of the search: coordinates of the free parameters, logarithms of the noises of inputs and outputs."""
        values = [each.coordinate(getattr(self.parameters, each.name)) for each in self.free]
        return np.array([*values, *map(math.log, (*self.input_deviation, *self.output_deviation))])

    def filter(self, place: np.ndarray, experiment: Experiment) -> Innovations:
        count, inputs = self._count, len(self.input_deviation)
        parameters = with_values(self.parameters, self.free, place[:count], experiment.setting)
        variances = tuple(np.exp(2.0 * place[count:]).tolist())
        return Innovations(
            self.model,
            parameters,
            experiment.initial_mean,
            experiment.initial_variance,
            variances[:inputs],
            variances[inputs:],
            self.tangent,
        )

    def search(self, experiments: Sequence[Experiment]) -> MapSearch:
        """The search over coordinates of parameters and noises, with what is known before as its prior."""
        start, noises = self.start(), len(self.input_deviation) + len(self.output_deviation)
        precision = [0.0 if each.spread is None else each.spread**-2 for each in self.free]
        least = [*[-np.inf] * self._count, *(start[self._count :] + math.log(self.LEAST_NOISE))]
        return MapSearch(
            lambda place, k: scan(self.filter(place, experiments[k]), experiments[k].samples).values,
            len(experiments),
            start,
            np.array([*precision, *[0.0] * noises]),
            np.array(least),
            self.STEP,
            most_steps=self.most_steps,
        )

    def cost(self, place: np.ndarray, experiments: Sequence[Experiment]) -> float:
        """Negative log-likelihood of experiments at a place of the search, infinite where it is not finite."""
        return self.search(experiments).cost(place)

    def fit(
        self,
        experiments: Sequence[Experiment],
        start: np.ndarray | None = None,
        progress: Progress = lambda share: None,
    ) -> Estimate:
        """The maximum-likelihood estimate.

        Args: start: place near the maximum, from which the last part of the search starts; None for the whole search.
        """
        place, steps, done = self.start() if start is None else np.array(start, float), 0, 0.0
        if start is None:
            place = self._best_start(place, experiments)
            for factor in self.widened:
                place[self._count :] = self._noise_at(factor)
                end = self.search(experiments).descend(place, 1.0, range(self._count))
                place, steps, done = end.place, steps + end.steps, done + 0.7 / len(self.widened)
                progress(done)
        end = self._to_the_end(place, experiments)
        progress(1.0)
        covariance = sandwich(end.found.information, end.found.scores, np.diag(self.search(experiments).precision))
        return self._estimate(end, experiments, covariance, steps + end.steps)

    def _to_the_end(self, place: np.ndarray, experiments: Sequence[Experiment]) -> End:
        """Last part of the search; without convergence it is repeated from the start and from the best place.

        From parameters fitted with a large noise, parameters and noise descend together along a narrow curved valley in
        many small steps; from the start with its small noise the way is often shorter.
        """
        search = self.search(experiments)
        best = search.descend(place, self.ENOUGH)
        begins, steps = [self._nearest_start(experiments)] if not best.converged else [], best.steps
        for _ in range(self.begin_again):
            if best.converged:
                break
            again = search.descend(begins.pop() if begins else best.place, self.ENOUGH)
            best, steps = min(best, again, key=lambda each: each.found.cost), steps + again.steps
        return best._replace(steps=steps)

    def place_of(self, estimate: Estimate) -> np.ndarray:
        """Place at the estimate of another search; parameters that were not free there are at the start of this one."""
        place = self.start()
        for k, each in enumerate(self.free):
            if each.name in estimate.names:
                place[k] = each.coordinate(estimate[each.name])
        place[self._count :] = np.log([*estimate.input_deviation, *estimate.output_deviation])
        return place

    def places(self) -> list[np.ndarray]:
        """All starts of the search."""
        place = self.start()
        return [place, *(place + np.pad(each, (0, len(place) - self._count)) for each in self.starts)]

    def _best_start(self, place: np.ndarray, experiments: Sequence[Experiment]) -> np.ndarray:
        noise = np.concatenate([place[: self._count] * 0.0, self._noise_at(self.widened[0]) - place[self._count :]])
        return min(self.places(), key=lambda at: self.cost(at + noise, experiments))

    def _nearest_start(self, experiments: Sequence[Experiment]) -> np.ndarray:
        return min(self.places(), key=lambda at: self.cost(at, experiments))

    def _noise_at(self, factor: float) -> np.ndarray:
        return np.log([*np.multiply(self.input_deviation, factor), *self.output_deviation])

    def _estimate(self, end: End, experiments: Sequence[Experiment], covariance: np.ndarray, steps: int) -> Estimate:
        place, found, count, inputs = end.place, end.found, self._count, len(self.input_deviation)
        noise = tuple(np.exp(place[count:]).tolist())
        return Estimate(
            self.free,
            tuple(float(getattr(self.parameters, each.name)) for each in self.free),
            tuple(each.value(float(x)) for each, x in zip(self.free, place[:count], strict=True)),
            covariance[:count, :count],
            found.information,
            found.cost,
            tuple(
                np.where(np.isfinite(each.measured), whitened, np.nan)
                for each, whitened in zip(experiments, found.whitened, strict=True)
            ),
            noise[:inputs],
            noise[inputs:],
            steps,
            end.converged,
        )
