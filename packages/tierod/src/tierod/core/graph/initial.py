"""The state before the first sample as a function of the tuning, so that generated C follows a changed parameter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tierod.core.block import Block, Ring, Tree, tuning, values_of, with_tuning
from tierod.core.graph.operations import NEXT_STATE, PUSH, Operation, Program, invariant_of, is_constant, program


def initial_program(block: Block) -> Program:
    """Program of `init` over the floats of a block: next states, and the value that fills each delay line.

    Where `init` cannot be traced with symbols, or gives other numbers with them, it holds the numbers as constants.
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
    same = all(np.allclose(a, b, 1e-12, 0.0, equal_nan=True) for a, b in zip(found, (plain, rings), strict=True))
    return _with_signs(program(function), {NEXT_STATE: plain, PUSH: rings}) if same else fixed


def _with_signs(followed: Program, numbers: dict[int, list[float]]) -> Program:
    """The program with the signs of its constant zeros restored: CasADi has no negative zero."""
    operations, outputs = list(followed.operations), dict(followed.outputs)
    for (group, position), value in followed.outputs.items():
        if is_constant(operations[value], 0.0) and math.copysign(1.0, numbers[group][position]) < 0.0:
            outputs[group, position] = len(operations)
            operations.append(Operation("constant", (), -0.0))
    return Program(tuple(operations), outputs, invariant_of(operations))


def _parted(state: Tree) -> tuple[list[Any], list[Any]]:
    flat = values_of(state)
    return [each for each in flat if not isinstance(each, Ring)], [
        each.initial for each in flat if isinstance(each, Ring)
    ]


def _constants(plain: list[float], rings: list[float]) -> Program:
    operations = tuple(Operation("constant", (), float(value)) for value in (*plain, *rings))
    outputs = {(NEXT_STATE, k): k for k in range(len(plain))}
    outputs |= {(PUSH, k): len(plain) + k for k in range(len(rings))}
    return Program(operations, outputs, frozenset(range(len(operations))))
