"""Output error method: least squares of simulated against measured outputs, over several experiments at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

from tierod.core.block import Model, Tree, rebuild, skeleton
from tierod.core.graph import scan
from tierod.methods.identification.experiment import Estimate, Experiment, Free, with_values
from tierod.methods.identification.maximum_likelihood import Simulation
from tierod.methods.identification.regression import sandwich

_FAR = 1e6  # Residual of a diverged simulation, in standard deviations


@dataclass(frozen=True, eq=False)
class OutputError:
    """Identification of the free parameters of a discrete model by simulation.

    It is the best method where the recorded inputs alone drive the plant. An unrecorded torque makes the simulation
    drift and biases the estimate; `MaximumLikelihood` models such a torque.

    Args:
        parameters: parameters of the model: values of those that are not free, and start of the search
        output_deviation: standard deviation of the noise of every output, which weights the residuals
        free_states: names of the entries of the initial state that are estimated in every experiment; the others are
            taken from the experiment
        bounds: bounds of a positive parameter, as factors on its start

    Source: Raffone, eqs (5) and (6), weighted by the noise of the outputs.
    """

    model: Model
    parameters: Tree
    free: tuple[Free, ...]
    output_deviation: tuple[float, ...]
    free_states: tuple[str, ...] = ()
    bounds: tuple[float, float] = (1e-3, 1e3)
    most_steps: int = 30

    @property
    def _states(self) -> tuple[int, ...]:
        names = self.model.State._fields
        return tuple(names.index(name) for name in self.free_states)

    def simulation(self, place: np.ndarray, experiment: Experiment, number: int) -> Simulation:
        """Simulation of an experiment at a point of the search.

        Args:
            place: coordinates of the free parameters, then the free initial states of one experiment after the other
        """
        count = len(self.free)
        initial = list(experiment.initial_mean)
        for k, entry in enumerate(self._states):
            initial[entry] = float(place[count + number * len(self._states) + k])
        parameters = with_values(self.parameters, self.free, place[:count], experiment.setting)
        names = tuple(each.name for each in self.free)
        return Simulation(self.model, parameters, rebuild(skeleton(self.model.State), initial), names, self._states)

    def start(self, experiments: Sequence[Experiment]) -> np.ndarray:
        values = [each.coordinate(getattr(self.parameters, each.name)) for each in self.free]
        return np.array([*values, *(each.initial_mean[entry] for each in experiments for entry in self._states)])

    def residuals(self, place: np.ndarray, experiments: Sequence[Experiment]) -> tuple[np.ndarray, np.ndarray]:
        """Weighted residuals of all experiments, (n, outputs), and their derivatives, (n, outputs, coordinates)."""
        count, own, weights = len(self.free), len(self._states), 1.0 / np.array(self.output_deviation)
        slopes = [each.slope(each.value(float(x))) for each, x in zip(self.free, place[:count], strict=True)]
        parts, rows = [], []
        for number, each in enumerate(experiments):
            values = scan(self.simulation(place, each, number), each.inputs).values
            outputs = each.measured.shape[1]
            derived = values[:, outputs:].reshape(len(values), outputs, count + own) * weights[:, None]
            # A positive parameter is searched by its logarithm: the chain rule converts the sensitivities.
            derived[:, :, :count] *= slopes
            whole = np.zeros((len(values), outputs, len(place)))
            whole[:, :, :count] = derived[:, :, :count]
            first = count + number * own
            whole[:, :, first : first + own] = derived[:, :, count:]
            known = np.isfinite(each.measured)
            parts.append(np.where(known, (values[:, :outputs] - each.measured) * weights, 0.0))
            rows.append(np.where(known[:, :, None], whole, 0.0))
        # A diverged simulation gives NaN or infinity; a large finite residual lets the search step back.
        left = np.nan_to_num(np.concatenate(parts), nan=_FAR, posinf=_FAR, neginf=-_FAR)
        return np.clip(left, -_FAR, _FAR), np.nan_to_num(np.concatenate(rows), posinf=0.0, neginf=0.0)

    def fit(self, experiments: Sequence[Experiment]) -> Estimate:
        """Fit the free parameters to the experiments."""
        from scipy.optimize import least_squares

        # SciPy asks for residuals and Jacobian separately at the same point; one simulation gives both.
        def both(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            if not kept or not np.array_equal(kept[0], place):
                kept[:] = [place.copy(), *self.residuals(place, experiments)]
            return kept[1], kept[2]

        kept: list[np.ndarray] = []
        start = self.start(experiments)
        found = least_squares(
            lambda place: both(place)[0].ravel(),
            start,
            jac=lambda place: both(place)[1].reshape(-1, len(start)),
            bounds=self._limits(start),
            x_scale="jac",
            max_nfev=self.most_steps,
        )
        left, rows = self.residuals(found.x, experiments)
        scores = np.einsum("kop,ko->kp", rows, left)
        ends = np.cumsum([len(each.inputs) for each in experiments])[:-1]
        information = np.einsum("kop,koq->pq", rows, rows)
        covariance = sandwich(information, np.split(scores, ends))
        return self._estimate(found, np.split(left, ends), information, covariance, experiments)

    def _limits(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        low, high = np.full(len(start), -np.inf), np.full(len(start), np.inf)
        for k, each in enumerate(self.free):
            if each.positive:
                low[k], high[k] = start[k] + np.log(self.bounds)
        return low, high

    def _estimate(
        self,
        found: OptimizeResult,
        left: Sequence[np.ndarray],
        information: np.ndarray,
        covariance: np.ndarray,
        experiments: Sequence[Experiment],
    ) -> Estimate:
        count = len(self.free)
        return Estimate(
            self.free,
            tuple(float(getattr(self.parameters, each.name)) for each in self.free),
            tuple(each.value(float(x)) for each, x in zip(self.free, found.x[:count], strict=True)),
            covariance[:count, :count],
            information,
            float(found.cost),
            tuple(np.where(np.isfinite(e.measured), part, np.nan) for part, e in zip(left, experiments, strict=True)),
            (),
            self.output_deviation,
            int(found.nfev),
            bool(found.success),
        )
