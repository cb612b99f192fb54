"""Maximum likelihood estimation of parameters and noises of a model, from the innovations of a Kalman filter."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.block import Tree
from tierod.core.graph import scan
from tierod.core.model import Model
from tierod.methods.identification.experiment import Estimate, Experiment, Free, with_values
from tierod.methods.identification.regression import sandwich
from tierod.methods.identification.simulation import Innovations

Progress = Callable[[float], None]
"""Called with the completed share."""


class Likelihood(NamedTuple):
    """The negative log-likelihood at a place of the search.

    Args:
        cost: negative log-likelihood, without its constant
        information: Fisher information, from the derivatives of innovations and of their standard deviations
        scores: gradient of every sample, per experiment
        residuals: standardised innovations, per experiment
    """

    cost: float
    gradient: np.ndarray
    information: np.ndarray
    scores: tuple[np.ndarray, ...]
    residuals: tuple[np.ndarray, ...]


class End(NamedTuple):
    """Result of a search.

    Args:
        place: coordinates at which the search stopped
    """

    place: np.ndarray
    found: Likelihood
    steps: int
    converged: bool


@dataclass(frozen=True, eq=False)
class MaximumLikelihood:
    """Parameters of a discrete model, and the noise of its inputs and outputs, from experiments.

    Noise of an input (an unrecorded torque) drives the model. A simulation without it drifts, which least squares of
    simulated outputs would attribute to wrong parameters. For an exact input the estimated noise is zero, and the
    estimate that of least squares (`OutputError`).

    Derivatives are finite differences of whole runs of the filter: a graph of sensitivities, because of the covariance,
    would be twenty times as large as the filter, which is compiled once and runs in 0.3 microseconds per sample.

    Args:
        parameters: of the model: values of the fixed ones, and start of the free ones
        input_deviation: standard deviation of the noise of every input per sample, at the start
        output_deviation: standard deviation of the noise of every output, at the start
        tangent: model for the filter's Jacobians, see `Innovations`
        widened: factors on the noise of the inputs with which the parameters are fitted first, at fixed noises, since
            the likelihood for small noise has many local maxima
        most_steps: largest number of steps of each part of the search
        starts: further starts, as shifts of the coordinates
        begin_again: largest number of further searches if one has not converged: from the start, then from the best
            place

    Source: L. Ljung, System Identification (1999), sections 7.4 and 10.2; Fisher scoring after Levenberg, Marquardt.
    """

    model: Model
    parameters: Tree
    free: tuple[Free, ...]
    input_deviation: tuple[float, ...]
    output_deviation: tuple[float, ...]
    tangent: Model | None = None
    widened: tuple[float, ...] = (5.0, 1.5)
    most_steps: int = 30
    starts: tuple[tuple[float, ...], ...] = ()
    begin_again: int = 2

    STEP = 1e-5
    """Step of the finite differences in the coordinates of the search. It shifts the result by half of it, far less
    than a standard deviation, and is a million times the rounding errors of a run."""
    ENOUGH = 0.01
    """A smaller decrease of the cost ends the search."""
    NEAR = 0.125
    """Largest decrease of the cost that an undamped step may still predict at convergence: the minimum is then within
    half a standard deviation in every direction. A search that stops farther off has not converged."""
    LEAST_NOISE = 1e-2
    """Lower limit of the noises, over those at the start [-]."""
    FARTHEST = 1.0
    """Largest step of a coordinate: a factor of 2.7."""

    @property
    def _count(self) -> int:
        return len(self.free)

    def start(self) -> np.ndarray:
        """Start of the search: coordinates of the free parameters, logarithms of the noises of inputs and outputs."""
        values = [each.coordinate(getattr(self.parameters, each.name)) for each in self.free]
        return np.array([*values, *map(math.log, (*self.input_deviation, *self.output_deviation))])

    @property
    def _least(self) -> np.ndarray:
        return np.log(np.multiply(self.LEAST_NOISE, [*self.input_deviation, *self.output_deviation]))

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

    def cost(self, place: np.ndarray, experiments: Sequence[Experiment]) -> float:
        """Negative log-likelihood of experiments at a place of the search, infinite where it is not finite."""
        total = self._known_before(place)[0]
        for each in experiments:
            values, outputs = scan(self.filter(place, each), each.samples).values, each.measured.shape[1]
            total += float(0.5 * np.sum(values[:, :outputs] ** 2) + np.sum(values[:, outputs:]))
        return total if math.isfinite(total) else math.inf

    def likelihood(self, place: np.ndarray, experiments: Sequence[Experiment], moving: Sequence[int]) -> Likelihood:
        """The likelihood and its derivatives with respect to the coordinates `moving` (indices)."""
        cost, slope, curve = self._known_before(place)
        gradient, information = slope[list(moving)], np.diag(curve[list(moving)])
        scores, residuals = [], []
        for each in experiments:
            values, outputs = scan(self.filter(place, each), each.samples).values, each.measured.shape[1]
            surprise, spread = values[:, :outputs], values[:, outputs:]
            changes = np.stack([self._ahead(place, each, k) - values for k in moving]) / self.STEP
            surprised, spreading = changes[:, :, :outputs], changes[:, :, outputs:]
            score = np.sum(surprised * surprise + spreading, axis=2).T
            expected = (surprised + surprise * spreading).reshape(len(moving), -1)
            widths = spreading.reshape(len(moving), -1)
            cost += float(0.5 * np.sum(surprise**2) + np.sum(spread))
            gradient = gradient + score.sum(axis=0)
            information = information + expected @ expected.T + 2.0 * widths @ widths.T
            scores.append(score)
            residuals.append(np.where(np.isfinite(each.measured), surprise, np.nan))
        return Likelihood(cost, gradient, information, tuple(scores), tuple(residuals))

    def fit(
        self,
        experiments: Sequence[Experiment],
        start: np.ndarray | None = None,
        progress: Progress = lambda share: None,
    ) -> Estimate:
        """The maximum-likelihood estimate.

        Args:
            start: place near the maximum, from which the last part of the search starts; None for the whole search
            progress: called with the completed share, roughly
        """
        place, steps, done = self.start() if start is None else np.array(start, float), 0, 0.0
        if start is None:
            place = self._best_start(place, experiments)
            for factor in self.widened:
                place[self._count :] = self._noise_at(factor)
                place, _, more, _ = self._descend(place, experiments, range(self._count), 1.0)
                steps, done = steps + more, done + 0.7 / len(self.widened)
                progress(done)
        end = self._to_the_end(place, experiments)
        progress(1.0)
        covariance = sandwich(end.found.information, end.found.scores, np.diag(self._known_before(end.place)[2]))
        return self._estimate(end, covariance, steps + end.steps)

    def _to_the_end(self, place: np.ndarray, experiments: Sequence[Experiment]) -> End:
        """Last part of the search; without convergence it is repeated from the start and from the best place.

        From parameters fitted with a large noise, parameters and noise descend together along a narrow curved valley in
        many small steps; from the start with its small noise the way is often shorter.
        """
        whole = range(len(place))
        best = self._descend(place, experiments, whole, self.ENOUGH)
        begins, steps = [self._nearest_start(experiments)] if not best.converged else [], best.steps
        for _ in range(self.begin_again):
            if best.converged:
                break
            again = self._descend(begins.pop() if begins else best.place, experiments, whole, self.ENOUGH)
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

    def _estimate(self, end: End, covariance: np.ndarray, steps: int) -> Estimate:
        place, found = end.place, end.found
        count, inputs = self._count, len(self.input_deviation)
        values = tuple(each.value(float(x)) for each, x in zip(self.free, place[:count], strict=True))
        noise = tuple(np.exp(place[count:]).tolist())
        first = tuple(float(getattr(self.parameters, each.name)) for each in self.free)
        return Estimate(
            self.free,
            first,
            values,
            covariance[:count, :count],
            found.information,
            found.cost,
            found.residuals,
            noise[:inputs],
            noise[inputs:],
            steps,
            end.converged,
        )

    def _descend(
        self, place: np.ndarray, experiments: Sequence[Experiment], moving: Sequence[int], enough: float
    ) -> End:
        damping, now = 1e-2, self.likelihood(place, experiments, moving)
        for steps in range(1, self.most_steps + 1):
            step = self._step(place, now, moving, damping)
            step *= min(1.0, self.FARTHEST / max(float(np.max(np.abs(step))), 1e-300))
            ahead = place.copy()
            ahead[list(moving)] += step
            ahead[self._count :] = np.maximum(ahead[self._count :], self._least)
            hoped = -float(now.gradient @ step + 0.5 * step @ now.information @ step)
            gained = now.cost - self.cost(ahead, experiments)
            if gained > 0.0:
                place, now = ahead, self.likelihood(ahead, experiments, moving)
                damping = damping / 10.0 if gained > 0.5 * hoped else damping
            else:
                damping = max(10.0 * damping, 1e-4)
            if 0.0 < gained < enough or hoped < enough or damping > 1e8:
                return End(place, now, steps, self._is_near(place, now, moving))
        return End(place, now, self.most_steps, False)

    def _is_near(self, place: np.ndarray, now: Likelihood, moving: Sequence[int]) -> bool:
        return float(-0.5 * now.gradient @ self._step(place, now, moving, 0.0)) < self.NEAR

    def _step(self, place: np.ndarray, now: Likelihood, moving: Sequence[int], damping: float) -> np.ndarray:
        """A damped step of Fisher scoring; noises at their lower limit that would fall further are fixed."""
        least = np.concatenate([np.full(self._count, -np.inf), self._least])[list(moving)]
        kept = np.flatnonzero((place[list(moving)] > least + 1e-9) | (now.gradient < 0.0))
        information = now.information[np.ix_(kept, kept)]
        damped = information + damping * np.diag(np.diag(information) + 1e-12)
        step = np.zeros(len(now.gradient))
        step[kept] = -np.linalg.solve(damped, now.gradient[kept])
        return step

    def _ahead(self, place: np.ndarray, experiment: Experiment, index: int) -> np.ndarray:
        step = np.zeros(len(place))
        step[index] = self.STEP
        return scan(self.filter(place + step, experiment), experiment.samples).values

    def _known_before(self, place: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        weights = np.zeros(len(place))
        weights[: self._count] = [0.0 if each.spread is None else each.spread**-2 for each in self.free]
        away = place - self.start()
        return float(0.5 * np.sum(weights * away**2)), weights * away, weights
