"""The state before the first sample as a program of the tuning, so that generated C follows a changed parameter."""

from __future__ import annotations

from typing import Any

import numpy as np

from tierod.core.block import Block, Ring, Tree, leaves, tuning, with_tuning
from tierod.core.graph.operations import NEXT_STATE, PUSH, Operation, Program, program


def initial_program(block: Block) -> Program:
    """Program of `init` over the floats of a block: next states, and the value that fills each delay line.

    Where `init` cannot be followed with symbols, or gives other numbers with them, the numbers themselves.

    Args:
        block: whose graph is a straight line
    """
    if hasattr(block, "traced"):
        raise TypeError("lanes and judge of a bank begin each by itself")
    values = [value for _, value in tuning(block)]
    plain, rings = _parted(block.init())
    fixed = _constants(plain, rings)
    try:
        import casadi

        tuned = [casadi.SX.sym(path) for path, _ in tuning(block)]
        groups = _parted(with_tuning(block, tuned).init())
        columns = [casadi.vertcat(*map(casadi.SX, group)) for group in groups]
        function = casadi.Function("initial", [casadi.vertcat(*tuned)], columns)
        found = [np.asarray(each, dtype=float).ravel() for each in function.call([casadi.DM(values)])]
    except (RuntimeError, TypeError, NotImplementedError):
        return fixed
    pairs = list(zip(found, (np.array(plain, dtype=float), np.array(rings, dtype=float)), strict=True))
    return program(function) if all(_alike(*pair) for pair in pairs) else fixed


def _alike(found: np.ndarray, wanted: np.ndarray) -> bool:
    """Whether numbers differ by their rounding alone; zeros with their signs."""
    signs = (np.signbit(found) == np.signbit(wanted)) | np.isnan(wanted)
    return bool(np.allclose(found, wanted, 1e-12, 0.0, equal_nan=True) and signs.all())


def _parted(state: Tree) -> tuple[list[Any], list[Any]]:
    """Plain numbers of a state, and the first values of its delay lines."""
    flat = [leaf for _, leaf in leaves(state)]
    return [each for each in flat if not isinstance(each, Ring)], [
        each.initial for each in flat if isinstance(each, Ring)
    ]


def _constants(plain: list[float], rings: list[float]) -> Program:
    """A program that gives these numbers whatever the tuning."""
    operations = tuple(Operation("constant", (), float(value)) for value in (*plain, *rings))
    outputs = {(NEXT_STATE, k): k for k in range(len(plain))}
    outputs |= {(PUSH, k): len(plain) + k for k in range(len(rings))}
    return Program(operations, outputs, frozenset(range(len(operations))))
