"""Discrete models from stiff continuous ones, by the exponential of the Jacobian with scaling and squaring."""

from __future__ import annotations

from functools import lru_cache

from tierod.core.block import Scalar, Tree, leaves, rebuild, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.derivatives import jacobian
from tierod.core.model import Model, require_continuous
from tierod.models.linear import sampled_model

Rows = list[list[Scalar]]

_DEGREE = 6  # of the Taylor series of the smallest step; after squaring the error is 2e-7 of that step's norm at most


@lru_cache(maxsize=64)
def discretise_stiff(model: Model, squarings: int, at: Tree = None) -> Model:
    """A model discretised by the exponential of its Jacobian, with inputs constant over a sample.

    Args:
        model: continuous
        squarings: number of squarings; the series is taken over the sample divided by 2 to this power, and the row sums
            of the Jacobian times that part of a sample have to stay below 0.5
        at: state at which the Jacobian is taken; None takes it at every state. If the model is linear except for a few
            terms, a fixed Jacobian depends on tuning alone and is computed once, before all samples; those terms are
            then explicit, of first order, and must not be stiff

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]

    Raises:
        ParameterError: less than one squaring, or a model that is not continuous

    Validity: exact for a model that is linear in its state, however stiff; otherwise of second order (first with a
    fixed Jacobian). Source: exponential Rosenbrock-Euler method, x + h phi(h A) f(x); phi by the exponential of
    [[h A, h f], [0, 0]]; Hochbruck and Ostermann, Acta Numerica 19 (2010) 209, eq (2.58).
    """
    require_continuous(model)
    if squarings < 1:
        raise ParameterError(f"squarings is {squarings}; expected at least 1")

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        def slope(state: Tree) -> Tree:
            return model.derivative(state, u, p.continuous)

        part = p.sample_time / 2.0**squarings
        rows = [[part * each for each in row] for row in jacobian(slope, x if at is None else at)]
        mean = _mean_exponential(rows, squarings)
        rates = values_of(slope(x))
        moved = [p.sample_time * _total([a * b for a, b in zip(row, rates, strict=True)]) for row in mean]
        return rebuild(x, [a + b for (_, a), b in zip(leaves(x), moved, strict=True)])

    return sampled_model(model, "stiffly", transition)


def _mean_exponential(rows: Rows, squarings: int) -> Rows:
    """phi(Z 2^squarings) = (exp(Z 2^s) - 1) / (Z 2^s): the mean of the exponential over a sample.

    Every doubling of the step: phi <- (phi + exp phi) / 2, exp <- exp^2. This needs no inverse of Z, which does not
    exist for a free body.
    """
    count = len(rows)
    one: Rows = [[1.0 if i == j else 0.0 for j in range(count)] for i in range(count)]
    mean = one
    for order in range(_DEGREE, 1, -1):
        mean = _sum(one, _product(rows, mean), 1.0 / order)
    whole = _sum(one, _product(rows, mean), 1.0)
    for number in range(squarings):
        mean = [[0.5 * each for each in row] for row in _sum(mean, _product(whole, mean), 1.0)]
        if number + 1 < squarings:
            whole = _product(whole, whole)
    return mean


def _sum(left: Rows, right: Rows, factor: float) -> Rows:
    return [[a + factor * b for a, b in zip(x, y, strict=True)] for x, y in zip(left, right, strict=True)]


def _product(left: Rows, right: Rows) -> Rows:
    columns = list(zip(*right, strict=True))
    return [[_total([a * b for a, b in zip(row, column, strict=True)]) for column in columns] for row in left]


def _total(values: list[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for value in values:
        total = total + value
    return total
