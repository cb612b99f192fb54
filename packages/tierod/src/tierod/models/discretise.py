"""Discrete models from continuous ones by explicit one-step methods, as parts of the graph."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import lru_cache
from typing import Annotated

from tierod.core.block import Scalar, Tree, leaves, rebuild
from tierod.core.errors import ParameterError, nearest
from tierod.core.model import Model, model_like, require_continuous

Derivative = Callable[[Tree], Tree]


def _ahead(x: Tree, step: Scalar, slope: Tree) -> Tree:
    """x + step slope, leaf by leaf; a structural slope of 0.0 adds no operation to the graph."""
    pairs = zip(leaves(x), leaves(slope), strict=True)
    moved = [a if isinstance(b, float) and b == 0.0 else a + step * b for (_, a), (_, b) in pairs]
    return rebuild(x, moved)


def _euler(slope: Derivative, x: Tree, step: Scalar) -> Tree:
    return _ahead(x, step, slope(x))


def _midpoint(slope: Derivative, x: Tree, step: Scalar) -> Tree:
    return _ahead(x, step, slope(_ahead(x, 0.5 * step, slope(x))))


def _rk4(slope: Derivative, x: Tree, step: Scalar) -> Tree:
    first = slope(x)
    second = slope(_ahead(x, 0.5 * step, first))
    third = slope(_ahead(x, 0.5 * step, second))
    fourth = slope(_ahead(x, step, third))
    inner = _ahead(_ahead(first, 2.0, second), 2.0, third)
    return _ahead(x, step / 6.0, _ahead(inner, 1.0, fourth))


METHODS: dict[str, Callable[[Derivative, Tree, Scalar], Tree]] = {"euler": _euler, "midpoint": _midpoint, "rk4": _rk4}
"""One-step methods by name: order 1, 2 and 4."""


@lru_cache(maxsize=256)
def discretise(model: Model, method: str, steps: int = 1) -> Model:
    """The model discretised by an explicit method, with inputs constant over a sample.

    Args:
        method: "euler", "midpoint" or "rk4" (order 1, 2, 4). Stable while the magnitude of the fastest eigenvalue times
            the step stays below about 2 (euler, midpoint) or 2.8 (rk4); a stiff linear model needs
            `tierod.models.linear.zero_order_hold`
        steps: number of steps of the method within one sample

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]

    Raises:
        ParameterError: unknown method, no step, or a model that is not continuous
    """
    if method not in METHODS:
        raise ParameterError(f"'{method}' is not a method of discretisation{nearest(method, METHODS)}")
    if steps < 1:
        raise ParameterError(f"steps is {steps}; expected at least 1")
    require_continuous(model)
    one_step = METHODS[method]

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        for _ in range(steps):
            x = one_step(lambda at: model.derivative(at, u, p.continuous), x, p.sample_time / float(steps))
        return x

    return sampled_model(model, method, transition)


def sampled_model(model: Model, method: str, transition: Callable[[Tree, Tree, Tree], Tree]) -> Model:
    """The discrete model with a given transition and the shapes and output of a continuous one.

    Args:
        transition: over one sample, with parameters that are `continuous` and `sample_time`
    """

    def output(x: Tree, u: Tree, p: Tree) -> Tree:
        return model.output(x, u, p.continuous)

    fields = [("continuous", model.Parameters), ("sample_time", Annotated[float, "s"])]
    name = model.__name__
    return model_like(
        model,
        f"{name}{method.capitalize()}",
        f"{name}, sampled by {method}.",
        Parameters=dataclasses.make_dataclass("Parameters", fields, frozen=True),
        transition=transition,
        output=output,
    )
