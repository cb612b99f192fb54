"""Observer with a fixed gain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from tierod.core.block import Tree, Truth, named_tuple, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import present, where
from tierod.core.model import Model, require_discrete
from tierod.methods.estimators.kernels import usable
from tierod.methods.estimators.linear_algebra import Vector, add, product
from tierod.methods.estimators.pole_placement import Gain
from tierod.methods.estimators.shapes import check_mean, filled, leaf_names, leaf_values, sample_class


class Step(NamedTuple):
    """One step of an observer, flat: corrected mean, innovations, and whether all inputs are present (True if none)."""

    mean: Vector
    innovation: Vector
    whole: Truth


def observe(model: Model, parameters: Tree, gain: Gain, state: Tree, sample: Tree) -> Step:
    """Step x- = f(x, u), x = x- + L (y - h(x-)); missing outputs correct nothing, a missing input holds the state."""
    predicted = model.transition(state, sample.input, parameters)
    expected = leaf_values(model.output(predicted, sample.input, parameters))
    innovation = tuple(y - z for y, z in zip(leaf_values(sample.measured), expected, strict=True))
    used = [where(present(value), value, 0.0) for value in innovation]
    mean: Vector = add(leaf_values(predicted), product(gain, used))
    whole = usable(leaf_values(sample.input))
    if whole is not True:
        mean = tuple(where(whole, new, old) for new, old in zip(mean, leaf_values(state), strict=True))
    return Step(mean, innovation, whole)


def check_gain(model: Model, gain: Gain, initial_mean: Tree) -> None:
    """Check the shapes of a gain and an initial mean.

    Raises:
        ParameterError: a gain without one row per state and one entry per output, or as `check_mean`
    """
    states, outputs = leaf_names(model.State), leaf_names(model.Output)
    if len(gain) != len(states) or any(len(row) != len(outputs) for row in gain):
        raise ParameterError(
            f"the gain has {len(gain)} rows of {sorted({len(row) for row in gain})} entries; expected {len(states)} "
            f"({', '.join(states)}) of {len(outputs)} ({', '.join(outputs)})"
        )
    check_mean(initial_mean, states)


@dataclass(frozen=True)
class Luenberger:
    """Observer x- = f(x, u), x = x- + L (y - h(x-)) with a fixed gain, for any discrete model.

    Args:
        parameters: of the model; its floats are tuning
        initial_mean: state before the first sample, one float per state
        gain: L, rows by state, columns by output, from `observer_gain`; faster poles follow changes sooner and pass
            more noise

    A sample is `input` and `measured`; a missing output (NaN) corrects nothing, a missing input holds the state. The
    output is `mean` and `innovation` (measured minus expected; NaN where missing).

    Source: D. G. Luenberger, 1971, doi 10.1109/TAC.1971.1099826.
    """

    model: Model
    parameters: Tree
    initial_mean: Tree
    gain: Gain

    def __post_init__(self) -> None:
        require_discrete(self.model)
        check_gain(self.model, self.gain, self.initial_mean)

    @property
    def Sample(self) -> type:
        """NamedTuple class with `input` and `measured`."""
        return sample_class(self.model, ())

    def init(self) -> Tree:
        return rebuild(skeleton(self.model.State), leaf_values(self.initial_mean))

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Tree]:
        done = observe(self.model, self.parameters, self.gain, state, sample)
        return rebuild(state, done.mean), filled(_estimate_class(self.model), done.mean, done.innovation)


@lru_cache(maxsize=256)
def _estimate_class(model: Model) -> type:
    return named_tuple("Estimate", [("mean", model.State), ("innovation", model.Output)])
