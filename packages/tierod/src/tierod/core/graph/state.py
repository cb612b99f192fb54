"""A block's state before the first sample: its layout in one flat array, and its dependence on the tuning."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import Block, Ring, Tree, tuning, values_of, with_tuning
from tierod.core.graph.operations import NEXT_STATE, PUSH, Operation, Program, invariant_of, is_constant, program

GROUP = 8  # Number of lanes of a bank that are stepped together: the number of doubles in the widest vector register


class BankState(NamedTuple):
    lanes: tuple[Tree, ...]
    judge: Tree
    feedback: Tree  # feedback of the judge at the previous sample, for all lanes


def flat_memory(state: Tree) -> np.ndarray:
    """A state tree as one flat array, delay lines (filled with their initial value) at the end.

    The lanes of a bank come first, as `[group][number][lane of the group]`; the last group is padded with the first
    lane.
    """
    if not isinstance(state, BankState):
        plain, delayed = _plain_and_delayed(state)
        return np.array([*plain, *delayed], dtype=float)
    lanes = grouped(np.array([_plain_and_delayed(lane)[0] for lane in state.lanes], dtype=float))
    plain, delayed = _plain_and_delayed((state.judge, state.feedback))
    return np.concatenate([lanes, np.array([*plain, *delayed], dtype=float)])


def grouped(rows: np.ndarray) -> np.ndarray:
    """Rows, one per lane, in the layout of the memory: `[group][number][lane of the group]`, flat."""
    missing = -len(rows) % GROUP
    filled = np.concatenate([rows, np.repeat(rows[:1], missing, axis=0)])
    return filled.reshape(-1, GROUP, rows.shape[1]).transpose(0, 2, 1).ravel()


def ungrouped(flat: np.ndarray, count: int) -> np.ndarray:
    """The inverse of `grouped`: rows, one per lane."""
    groups = -(-count // GROUP)
    rows = flat.reshape(groups, -1, GROUP).transpose(0, 2, 1)
    return rows.reshape(groups * GROUP, -1)[:count]


def _plain_and_delayed(state: Tree) -> tuple[list[Any], list[Any]]:
    flat = values_of(state)
    plain = [leaf for leaf in flat if not isinstance(leaf, Ring)]
    return plain, [leaf.initial for leaf in flat if isinstance(leaf, Ring) for _ in range(leaf.size)]


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
