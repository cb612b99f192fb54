"""Maximum likelihood estimation of parameters and noises of a model, from the innovations of a Kalman filter."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tierod.core.block import Tree
from tierod.core.graph import scan
from tierod.core.model import Model
from tierod.methods.identification.experiment import Estimate, Experiment, Free, with_values
from tierod.methods.identification.map_search import End, MapSearch
from tierod.methods.identification.regression import sandwich
from tierod.methods.identification.simulation import Innovations

Progress = Callable[[float], None]
"""Called with the completed share."""


@dataclass(frozen=True, eq=False)
class MaximumLikelihood:
    """Parameters of a discrete model, and the noise of its inputs and outputs, from experiments.

    Noise of an input (an unrecorded torque) drives the model. A simulation without it drifts, which least squares of
    simulated outputs would attribute to wrong parameters. For an exact input the estimated noise is zero, and the
    estimate that of least squares (`OutputError`).

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
    LEAST_NOISE = 1e-2
    """Lower limit of the noises, over those at the start [-]."""

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

        Args:
            start: place near the maximum, from which the last part of the search starts; None for the whole search
            progress: called with the completed share, roughly
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
