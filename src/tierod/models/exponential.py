"""Discrete models from continuous ones of two states: exact where the model is linear in its state, however stiff."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from tierod.block import Tree, leaves, rebuild, skeleton
from tierod.errors import ParameterError
from tierod.graph.derivatives import jacobian
from tierod.graph.maths import absolute, cos, exp, sin, sqrt, where
from tierod.models.discretise import sampled_class

_SMALL = 1e-8  # squared half difference of the eigenvalues times the step; below, the series has all digits


@lru_cache(maxsize=64)
def discretise_pair(model: Any) -> Any:
    """A model of two states sampled by the exponential of its Jacobian, its inputs constant over a sample.

    Args:
        model: continuous, with two states

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]

    Raises:
        ParameterError: not two states, or a model that is not continuous

    Validity: exact for a model that is linear in its state and has no eigenvalue at zero; stable for any step where the
    model is. Source: x + h phi(h A) f(x), phi(Z) = (exp(Z) - 1) / Z, by the theorem of Cayley and Hamilton.
    """
    if not hasattr(model, "derivative"):
        raise ParameterError(f"{model.__name__} has no function `derivative`; only a continuous model is discretised")
    count = len(list(leaves(skeleton(model.State))))
    if count != 2:
        raise ParameterError(
            f"{model.__name__} has {count} states; this exponential is of two: take tierod.models.discretise"
        )

    def transition(x: Tree, u: Tree, p: Any) -> Tree:
        def slope(at: Tree) -> Tree:
            return model.derivative(at, u, p.continuous)

        moved = _mean_slope(jacobian(slope, x), [leaf for _, leaf in leaves(slope(x))], p.sample_time)
        return rebuild(x, [a + p.sample_time * b for (_, a), b in zip(leaves(x), moved, strict=True)])

    return sampled_class(model, "exponential", transition)


def _mean_slope(rows: list[list[Any]], slope: list[Any], step: Any) -> tuple[Any, Any]:
    """phi(step A) times the slope at the start of a sample: its mean over the sample."""
    (a, b), (c, d) = [[step * each for each in row] for row in rows]
    middle, spread = 0.5 * (a + d), 0.5 * (a - d)
    even, odd = _halves(spread * spread + b * c)
    grown = exp(middle)
    first = (
        grown * (even * slope[0] + odd * (spread * slope[0] + b * slope[1])) - slope[0],
        grown * (even * slope[1] + odd * (c * slope[0] - spread * slope[1])) - slope[1],
    )
    determinant = a * d - b * c
    apart = absolute(determinant) > 1e-14
    inverse = 1.0 / where(apart, determinant, 1.0)
    exact = (inverse * (d * first[0] - b * first[1]), inverse * (a * first[1] - c * first[0]))
    return where(apart, exact[0], slope[0]), where(apart, exact[1], slope[1])


def _halves(square: Any) -> tuple[Any, Any]:
    """cosh(root) and sinh(root) / root of a square that may be negative, where they are cosine and sine."""
    away = absolute(square) > _SMALL
    root = sqrt(where(away, absolute(square), 1.0))
    grown = exp(where(square > 0.0, root, 0.0))
    real = (0.5 * (grown + 1.0 / grown), 0.5 * (grown - 1.0 / grown) / root)
    turning = (cos(root), sin(root) / root)
    series = (1.0 + 0.5 * square, 1.0 + square / 6.0)
    return tuple(  # type: ignore[return-value]
        where(away, where(square > 0.0, p, q), s) for p, q, s in zip(real, turning, series, strict=True)
    )
