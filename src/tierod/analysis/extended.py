"""Linear systems with their unknown inputs as constant states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tierod.errors import ParameterError, nearest
from tierod.models.linear import LinearSystem


def extended(system: LinearSystem, disturbances: Sequence[str], *, discrete: bool = False) -> LinearSystem:
    """The system with some of its inputs as states that stay as they are, which noise makes random walks.

    Args:
        system: continuous, or discrete if so said
        disturbances: inputs that become states at the end, in this order, under their own names
        discrete: whether x is the next x rather than its rate

    Raises:
        ParameterError: no such input, one that is named twice, or a state of that name exists

    Source: Raffone, eq (8), where the torques of driver and disturbance become states.
    """
    for name in disturbances:
        if name not in system.inputs:
            raise ParameterError(f"the system has no input '{name}'{nearest(name, system.inputs)}")
        if name in system.states or disturbances.count(name) > 1:
            raise ParameterError(f"'{name}' would be two states; name each disturbance once")
    unknown = [system.inputs.index(name) for name in disturbances]
    known = [k for k in range(len(system.inputs)) if k not in unknown]
    n, d = len(system.A), len(unknown)
    constant = np.eye(d) if discrete else np.zeros((d, d))
    A = np.block([[system.A, system.B[:, unknown]], [np.zeros((d, n)), constant]])
    B = np.vstack([system.B[:, known], np.zeros((d, len(known)))])
    C = np.hstack([system.C, system.D[:, unknown]])
    inputs = tuple(system.inputs[k] for k in known)
    return LinearSystem(A, B, C, system.D[:, known], (*system.states, *disturbances), inputs, system.outputs)


def through(system: LinearSystem, outputs: Sequence[str]) -> LinearSystem:
    """The system with these outputs alone, in this order.

    Raises:
        ParameterError: no such output
    """
    for name in outputs:
        if name not in system.outputs:
            raise ParameterError(f"the system has no output '{name}'{nearest(name, system.outputs)}")
    rows = [system.outputs.index(name) for name in outputs]
    names = (system.states, system.inputs, tuple(outputs))
    return LinearSystem(system.A, system.B, system.C[rows], system.D[rows], *names)
