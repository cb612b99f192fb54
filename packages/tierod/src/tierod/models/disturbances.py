"""Unknown inputs of a linear system as states: random walks of any order, and offsets of sensors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import LinearSystem

DERIVATIVES = ("", "_rate", "_acceleration")
"""Suffixes of the state names of an input and its derivatives."""


def with_disturbance_states(system: LinearSystem, orders: Mapping[str, int]) -> LinearSystem:
    """The system with some of its inputs as chains of integrators, of which the last state is constant.

    Args:
        orders: number of states of each input: 1 for a random walk, 2 for a random walk of its rate, at most 3

    Raises:
        ParameterError: no such input, or an order out of range

    Source: Raffone, eqs (8) and (18), for order 1; the feed-through of such an input is kept.
    """
    for name, order in orders.items():
        if name not in system.inputs:
            raise ParameterError(f"the system has no input '{name}'{nearest(name, system.inputs)}")
        if not 1 <= order <= len(DERIVATIVES):
            raise ParameterError(f"order of '{name}' is {order}; expected 1 to {len(DERIVATIVES)}")
    n, extra = len(system.A), sum(orders.values())
    A = np.zeros((n + extra, n + extra))
    C = np.hstack([system.C, np.zeros((len(system.C), extra))])
    A[:n, :n] = system.A
    names, at = list(system.states), n
    for name, order in orders.items():
        column = system.inputs.index(name)
        A[:n, at], C[:, at] = system.B[:, column], system.D[:, column]
        for k in range(1, order):
            A[at + k - 1, at + k] = 1.0
        names += [name + DERIVATIVES[k] for k in range(order)]
        at += order
    kept = [k for k, name in enumerate(system.inputs) if name not in orders]
    B = np.vstack([system.B[:, kept], np.zeros((extra, len(kept)))])
    inputs = tuple(system.inputs[k] for k in kept)
    return LinearSystem(A, B, C, system.D[:, kept], tuple(names), inputs, system.outputs)


def with_offset_state(system: LinearSystem, output: str, name: str) -> LinearSystem:
    """The system with a constant added to one of its outputs, as its last state.

    Raises:
        ParameterError: no such output
    """
    if output not in system.outputs:
        raise ParameterError(f"the system has no output '{output}'{nearest(output, system.outputs)}")
    n = len(system.A)
    A = np.zeros((n + 1, n + 1))
    A[:n, :n] = system.A
    column = np.array([[float(each == output)] for each in system.outputs])
    B = np.vstack([system.B, np.zeros((1, system.B.shape[1]))])
    states = (*system.states, name)
    return LinearSystem(A, B, np.hstack([system.C, column]), system.D, states, system.inputs, system.outputs)


def with_outputs(system: LinearSystem, outputs: tuple[str, ...]) -> LinearSystem:
    """The system with a selection of its outputs, in the given order.

    Raises:
        ParameterError: no such output
    """
    for name in outputs:
        if name not in system.outputs:
            raise ParameterError(f"the system has no output '{name}'{nearest(name, system.outputs)}")
    rows = [system.outputs.index(name) for name in outputs]
    return LinearSystem(
        system.A, system.B, system.C[rows], system.D[rows], system.states, system.inputs, tuple(outputs)
    )
