"""Kalman filter with its stationary gain."""

from __future__ import annotations

from dataclasses import dataclass

from tierod.core.block import Model, Tree, rebuild, require_discrete
from tierod.core.graph.maths import where
from tierod.methods.estimators.kernels import diagonal, order, pack
from tierod.methods.estimators.observers import Luenberger, observe, stationary_gain
from tierod.methods.estimators.shapes import check_variances, estimate_class, filled, leaf_names
from tierod.models.linear import linearise
from tierod_lab.methods.unscented import correct_jointly


@dataclass(frozen=True)
class StationaryFilter(Luenberger):
    """Kalman filter with its stationary gain: a few multiplications per sample, and the outputs of `KalmanFilter`.

    The gain is that of complete samples: a missing output (NaN) corrects nothing and
    changes neither the rest of the gain nor the variance of the estimate; a missing input holds the state.
    """

    covariance: tuple[float, ...]
    innovation_covariance: tuple[float, ...]

    @classmethod
    def design(
        cls,
        model: Model,
        parameters: Tree,
        process_noise: Tree,
        measurement_noise: Tree,
        state: Tree,
        inputs: Tree,
        input_noise: Tree = None,
    ) -> StationaryFilter:
        """The filter for a model linearised at a state and inputs; the state is also the initial mean."""
        require_discrete(model)
        check_variances("process_noise", process_noise, leaf_names(model.State))
        check_variances("measurement_noise", measurement_noise, leaf_names(model.Output), positive=True)
        system = linearise(model, parameters, state, inputs)
        found = stationary_gain(system, process_noise, measurement_noise, input_noise)
        gain = tuple(tuple(map(float, row)) for row in found.filter)
        return cls(
            model,
            parameters,
            state,
            gain,
            *(pack(each.tolist()) for each in (found.covariance, found.innovation_covariance)),
        )

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Tree]:
        done = observe(self.model, self.parameters, self.gain, state, sample)
        count = order(self.innovation_covariance)
        # A joint correction of no states gives NIS and number of those outputs that are present.
        figures = correct_jointly((), [()] * count, self.innovation_covariance, done.innovation)
        nis, number = figures.nis, figures.present
        if done.whole is not True:
            nis, number = where(done.whole, nis, 0.0), where(done.whole, number, 0.0)
        estimate = filled(
            estimate_class(self.model, False),
            done.mean,
            diagonal(self.covariance),
            done.innovation,
            diagonal(self.innovation_covariance),
            (nis, number),
        )
        return rebuild(state, done.mean), estimate
