"""A model simulated together with its sensitivities: derivatives of every output by parameters and first state."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, NamedTuple

from tierod.core.block import Tree, leaves, rebuild, skeleton
from tierod.core.graph.derivatives import jacobian
from tierod.core.graph.maths import where
from tierod.methods.estimators.kernels import usable
from tierod.methods.estimators.linear_algebra import dot, plus

Rows = tuple[tuple[Any, ...], ...]


class Moving(NamedTuple):
    """A simulation between two samples: the state, and its derivatives by what is free, one row per state."""

    mean: Tree
    derivatives: Rows


class Simulated(NamedTuple):
    """Outputs of a sample, and their derivatives by what is free, one row per output."""

    output: Tree
    derivatives: Rows


@dataclass(frozen=True)
class Simulation:
    """A discrete model driven by recorded inputs alone, with its sensitivities.

    The sensitivities follow the chain rule through the automatic Jacobians of one step: they are exact, and cost one
    scan for all of them. A missing input holds the state.

    Args:
        model: discrete model
        parameters: of the model; its floats are tuning
        initial: first state
        free: names of parameters by which is derived
        free_states: places of entries of the first state by which is derived, after the parameters
    """

    model: Any
    parameters: Any
    initial: Tree
    free: tuple[str, ...] = ()
    free_states: tuple[int, ...] = ()

    @property
    def Sample(self) -> type:
        """NamedTuple class of the model's inputs."""
        return self.model.Input

    def init(self) -> Moving:
        """The first state."""
        values = [leaf for _, leaf in leaves(self.initial)]
        none = (0.0,) * len(self.free)
        rows = tuple((*none, *(float(k == entry) for entry in self.free_states)) for k in range(len(values)))
        return Moving(rebuild(skeleton(self.model.State), values), rows)

    def step(self, state: Moving, sample: Any) -> tuple[Moving, Simulated]:
        """One sample on; the output belongs to the instant of the sample."""
        output = self.model.output(state.mean, sample, self.parameters)
        ahead = self.model.transition(state.mean, sample, self.parameters)
        told = self._derived(self.model.output, state, sample)
        moved = self._derived(self.model.transition, state, sample)
        whole = usable([leaf for _, leaf in leaves(sample)])
        if whole is True:
            return Moving(ahead, moved), Simulated(output, told)
        after = Moving(ahead, moved)
        held = [where(whole, a, b) for (_, a), (_, b) in zip(leaves(after), leaves(state), strict=True)]
        return rebuild(state, held), Simulated(output, told)

    def _derived(self, function: Any, state: Moving, sample: Any) -> Rows:
        """Derivatives of a function of state and parameters by what is free."""
        at = (state.mean, tuple(getattr(self.parameters, name) for name in self.free))

        def of(point: Any) -> Tree:
            values = dict(zip(self.free, point[1], strict=True))
            return function(point[0], sample, dataclasses.replace(self.parameters, **values))

        count, through = len(state.derivatives), list(zip(*state.derivatives, strict=True))
        rows = []
        for row in jacobian(of, at):
            direct = [*row[count:], *[0.0] * len(self.free_states)]
            rows.append(tuple(plus(dot(row[:count], way), own) for way, own in zip(through, direct, strict=True)))
        return tuple(rows)
