"""Discrete models from continuous ones of two states: exact where the model is linear in its state, however stiff."""

from __future__ import annotations

from functools import lru_cache

from tierod.core.block import Scalar, Tree, leaves, rebuild, skeleton, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.derivatives import jacobian
from tierod.core.graph.maths import absolute, cos, exp, sin, sqrt, where
from tierod.core.model import Model, require_continuous
from tierod.models.linear import sampled_model

_SMALL = 1e-8  # squared half difference of the eigenvalues times the step; below, the series is exact to rounding
_SINGULAR = 1e-8  # product of the eigenvalues times the squared step; below, one counts as zero: error 2e-9 at most
_SHORT = 1e-2  # eigenvalue times the step; below, four terms of the series have an error of 2e-11


@lru_cache(maxsize=64)
def discretise_pair(model: Model) -> Model:
    """A model of two states discretised by the exponential of its Jacobian, with inputs constant over a sample.

    Args:
        model: continuous, with two states

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]

    Raises:
        ParameterError: not two states, or a model that is not continuous

    Validity: exact for a model that is linear in its state, including one or two integrators; stable for any step if
    the model is. Source: x + h phi(h A) f(x), phi(Z) = (exp(Z) - 1) / Z, by the Cayley-Hamilton theorem.
    """
    require_continuous(model)
    count = len(list(leaves(skeleton(model.State))))
    if count != 2:
        raise ParameterError(
            f"{model.__name__} has {count} states; this exponential is of two: take tierod.models.linear"
        )

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        def slope(at: Tree) -> Tree:
            return model.derivative(at, u, p.continuous)

        moved = _mean_slope(jacobian(slope, x), values_of(slope(x)), p.sample_time)
        return rebuild(x, [a + p.sample_time * b for (_, a), b in zip(leaves(x), moved, strict=True)])

    return sampled_model(model, "exponential", transition)


def _mean_slope(rows: list[list[Scalar]], slope: list[Scalar], step: Scalar) -> tuple[Scalar, Scalar]:
    (a, b), (c, d) = [[step * each for each in row] for row in rows]
    middle, spread = 0.5 * (a + d), 0.5 * (a - d)
    even, odd = _halves(middle, spread * spread + b * c)
    first = (
        even * slope[0] + odd * (spread * slope[0] + b * slope[1]) - slope[0],
        even * slope[1] + odd * (c * slope[0] - spread * slope[1]) - slope[1],
    )
    determinant = a * d - b * c
    apart = absolute(determinant) > _SINGULAR
    inverse = 1.0 / where(apart, determinant, 1.0)
    whole = (inverse * (d * first[0] - b * first[1]), inverse * (a * first[1] - c * first[0]))
    share = _of_one_eigenvalue(2.0 * middle)
    single = (slope[0] + share * (a * slope[0] + b * slope[1]), slope[1] + share * (c * slope[0] + d * slope[1]))
    return where(apart, whole[0], single[0]), where(apart, whole[1], single[1])


def _of_one_eigenvalue(value: Scalar) -> Scalar:
    away = absolute(value) > _SHORT
    safe = where(away, value, 1.0)
    series = 0.5 + value * (1.0 / 6.0 + value * (1.0 / 24.0 + value / 120.0))
    return where(away, (exp(safe) - 1.0 - safe) / (safe * safe), series)


def _halves(middle: Scalar, square: Scalar) -> tuple[Scalar, Scalar]:
    """exp(middle) times cosh(root) and sinh(root) / root, where the square of the root may be negative.

    Each eigenvalue has its own exponential, since the hyperbolic functions of a stiff pair would overflow.
    """
    away = absolute(square) > _SMALL
    root = sqrt(where(away, absolute(square), 1.0))
    apart = where(square > 0.0, root, 0.0)
    slow, fast, grown = exp(middle + apart), exp(middle - apart), exp(middle)
    real = (0.5 * (slow + fast), 0.5 * (slow - fast) / root)
    turning = (grown * cos(root), grown * sin(root) / root)
    series = (grown * (1.0 + 0.5 * square), grown * (1.0 + square / 6.0))
    return tuple(  # type: ignore[return-value]
        where(away, where(square > 0.0, p, q), s) for p, q, s in zip(real, turning, series, strict=True)
    )
