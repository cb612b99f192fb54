"""Jacobians by automatic differentiation, for numbers and for symbols, and sparsity patterns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tierod.core.block import Scalar, T, Tree, leaves, rebuild, values_of
from tierod.core.graph.maths import is_symbol


def jacobian(function: Callable[[T], Tree], at: T) -> list[list[Scalar]]:
    """Derivative of every leaf of `function(x)` with respect to every leaf of `x`, at one point.

    Args:
        function: maps a tree of the shape of `at` to a tree; pure, written with tierod.core.graph.maths

    Returns:
        rows by output leaf, columns by input leaf; structural zeros and constants come back as floats,
        so that products with them can be left out
    """
    import casadi

    point = values_of(at)
    symbols = casadi.SX.sym("x", len(point))
    images = values_of(function(rebuild(at, casadi.vertsplit(symbols))))
    derivative = casadi.jacobian(casadi.vertcat(*images), symbols)
    # Even at a point of numbers the function may hold symbols of a running trace, such as a parameter.
    if any(map(is_symbol, point)) or casadi.symvar(casadi.substitute(derivative, symbols, casadi.DM.zeros(len(point)))):
        derivative = casadi.substitute(derivative, symbols, casadi.vertcat(*point))
    else:
        derivative = casadi.Function("derivative", [symbols], [derivative])(casadi.vertcat(*point))
    rows, columns = derivative.shape
    sparsity = derivative.sparsity()
    return [[_entry(derivative, i, j) if sparsity.has_nz(i, j) else 0.0 for j in range(columns)] for i in range(rows)]


def dependence(function: Callable[[T], Tree], shape: T) -> list[list[bool]]:
    """Sparsity pattern: which leaves of `function(x)` depend on which leaves of `x`, whatever their values.

    Args:
        function: maps a tree of the shape of `shape` to a tree; pure, written with tierod.core.graph.maths

    Returns:
        rows by output leaf, columns by input leaf
    """
    import casadi

    symbols = casadi.SX.sym("x", len(list(leaves(shape))))
    images = values_of(function(rebuild(shape, casadi.vertsplit(symbols))))
    pattern = casadi.Function("f", [symbols], [casadi.SX(casadi.vertcat(*images))]).jac_sparsity(0, 0)
    rows, columns = pattern.shape
    return [[pattern.has_nz(i, j) for j in range(columns)] for i in range(rows)]


def _entry(matrix: Any, row: int, column: int) -> Any:
    value = matrix[row, column]
    return value if is_symbol(value) and not value.is_constant() else float(value)
