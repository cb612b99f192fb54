"""Simulation of a model with sensitivities, and a filter for the likelihood of every sample of a recording."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from tierod.core.block import Scalar, Tree, rebuild, skeleton, values_of
from tierod.core.graph.derivatives import jacobian
from tierod.core.graph.maths import log, present, select, sqrt, where
from tierod.core.model import Model
from tierod.methods.estimators.kernels import correct_in_turn, predict_covariance, usable
from tierod.methods.estimators.linear_algebra import Vector, dot, from_diagonal, plus
from tierod.methods.estimators.shapes import Belief, leaf_values, sample_class

Rows = tuple[tuple[Scalar, ...], ...]


class Moving(NamedTuple):
    """State of a simulation, and its derivatives by the free parameters and states, one row per state."""

    mean: Tree
    derivatives: Rows


class Simulated(NamedTuple):
    """Outputs of a sample, and their derivatives by the free parameters and states, one row per output."""

    output: Tree
    derivatives: Rows


@dataclass(frozen=True)
class Simulation:
    """Simulation of a discrete model with recorded inputs, and its sensitivities.

    The sensitivities follow from the chain rule with the automatic Jacobians of one step: they are exact, and need one
    scan for all. A missing input holds the state.

    Args:
        parameters: of the model; its floats are tuning
        free: names of the parameters of the derivatives
        free_states: indices of the entries of the initial state whose derivatives follow those of the parameters
    """

    model: Model
    parameters: Tree
    initial: Tree
    free: tuple[str, ...] = ()
    free_states: tuple[int, ...] = ()

    @property
    def Sample(self) -> type:
        """NamedTuple class of the model's inputs."""
        kind: type = self.model.Input
        return kind

    def init(self) -> Moving:
        values = values_of(self.initial)
        none = (0.0,) * len(self.free)
        rows = tuple((*none, *(float(k == entry) for entry in self.free_states)) for k in range(len(values)))
        return Moving(rebuild(skeleton(self.model.State), values), rows)

    def step(self, state: Moving, sample: Tree) -> tuple[Moving, Simulated]:
        output = self.model.output(state.mean, sample, self.parameters)
        ahead = self.model.transition(state.mean, sample, self.parameters)
        sensitivities = self._derived(self.model.output, state, sample)
        moved = self._derived(self.model.transition, state, sample)
        whole = usable(values_of(sample))
        if whole is True:
            return Moving(ahead, moved), Simulated(output, sensitivities)
        return select(whole, Moving(ahead, moved), state), Simulated(output, sensitivities)

    def _derived(self, function: Callable[[Tree, Tree, Tree], Tree], state: Moving, sample: Tree) -> Rows:
        at = (state.mean, tuple(getattr(self.parameters, name) for name in self.free))

        def of(point: Tree) -> Tree:
            values = dict(zip(self.free, point[1], strict=True))
            return function(point[0], sample, dataclasses.replace(self.parameters, **values))

        count, through = len(state.derivatives), list(zip(*state.derivatives, strict=True))
        rows = []
        for row in jacobian(of, at):
            direct = [*row[count:], *[0.0] * len(self.free_states)]
            rows.append(tuple(plus(dot(row[:count], way), own) for way, own in zip(through, direct, strict=True)))
        return tuple(rows)


class Surprise(NamedTuple):
    """Standardised innovations of a sample.

    Args:
        standardised: innovation given the past and the outputs before it, over its standard deviation
        logarithm: natural logarithm of that standard deviation; 0 where the output is missing
    """

    standardised: Tree
    logarithm: Tree


@dataclass(frozen=True)
class Innovations:
    """Extended Kalman filter that gives the terms of the likelihood of a recording.

    The likelihood of a sample is the product over its outputs, each given those before it. It is valid for correlated
    outputs, and a missing one (NaN) adds no factor. A missing input holds the state.

    Args:
        parameters: of the model; its floats are tuning
        initial_mean, initial_variance: of the state before the first sample
        input_variance: of the unrecorded part of every input, per sample
        tangent: model for the Jacobians of the covariance; the model itself by default. One with smoothed kinks makes
            the likelihood a smooth function of the parameters

    Source: F. C. Schweppe, IEEE TIT 11 (1965) 61; L. Ljung, System Identification (1999), section 7.4.
    """

    model: Model
    parameters: Tree
    initial_mean: Tree
    initial_variance: Tree
    input_variance: Tree
    measurement_variance: Tree
    tangent: Model | None = None

    @property
    def Sample(self) -> type:
        """NamedTuple class with `input` and `measured`."""
        return sample_class(self.model, ())

    def init(self) -> Belief:
        mean = rebuild(skeleton(self.model.State), leaf_values(self.initial_mean))
        return Belief(mean, from_diagonal(leaf_values(self.initial_variance)))

    def step(self, state: Belief, sample: Tree) -> tuple[Belief, Surprise]:
        mean, covariance, surprise = self._corrected(state, sample)
        tangent = self.tangent or self.model
        rows = jacobian(lambda x: tangent.transition(x, sample.input, self.parameters), mean)
        gain = jacobian(lambda u: self.model.transition(mean, u, self.parameters), sample.input)
        none = (0.0,) * len(leaf_values(mean))
        ahead = predict_covariance(rows, covariance, none, gain, leaf_values(self.input_variance))
        moved, whole = self.model.transition(mean, sample.input, self.parameters), usable(leaf_values(sample.input))
        held = tuple(where(whole, a, b) for a, b in zip(leaf_values(moved), leaf_values(mean), strict=True))
        spread = tuple(where(whole, a, b) for a, b in zip(ahead, covariance, strict=True))
        return Belief(rebuild(mean, held), spread), surprise

    def _corrected(self, state: Belief, sample: Tree) -> tuple[Tree, Vector, Surprise]:
        def output(x: Tree) -> Tree:
            return self.model.output(x, sample.input, self.parameters)

        rows, expected = jacobian(output, state.mean), leaf_values(output(state.mean))
        innovations = [value - mean for value, mean in zip(leaf_values(sample.measured), expected, strict=True)]
        done = correct_in_turn(state.covariance, rows, innovations, leaf_values(self.measurement_variance))
        (shift, covariance, _, _), residuals, spreads = done
        standardised, logarithms = [], []
        for residual, spread in zip(residuals, spreads, strict=True):
            there = present(residual)
            standardised.append(where(there, residual, 0.0) / sqrt(spread))
            logarithms.append(where(there, 0.5 * log(spread), 0.0))
        mean = rebuild(state.mean, [plus(a, b) for a, b in zip(leaf_values(state.mean), shift, strict=True)])
        outputs = skeleton(self.model.Output)
        return mean, covariance, Surprise(rebuild(outputs, standardised), rebuild(outputs, logarithms))
