"""Balanced reduction of linear systems by singular perturbation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem

SHIFT = 1.0
"""Decay rate that is added to a column for the balancing, since its angle does not decay and has no Gramian [1/s]; 0.1
to 3 give the same result."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """A system with fewer states, and its relation to the full one."""

    system: LinearSystem  # the reduced one; its states are combinations without unit, "mode 1", "mode 2", ...
    # back, back_input: x = back z + back_input u, as far as z determines it, (n, order) and (n, inputs)
    back: np.ndarray
    back_input: np.ndarray

    def physical(self, *names: str, of: LinearSystem) -> LinearSystem:
        """The reduced system with states of the full one as additional outputs, so that an observer estimates them."""
        rows = [of.states.index(name) for name in names]
        C = np.vstack([self.system.C, self.back[rows]])
        D = np.vstack([self.system.D, self.back_input[rows]])
        return replace(self.system, C=C, D=D, outputs=(*self.system.outputs, *names))


def balanced_reduction(
    system: LinearSystem,
    order: int,
    input_size: Mapping[str, float],
    output_size: Mapping[str, float],
    feed_through: bool = True,
    shift: float = SHIFT,
) -> Reduction:
    """Balanced reduction: the states that are least controllable and observable are at their steady state.

    Args:
        order: states of the reduced system
        input_size, output_size: typical size of inputs and outputs in their unit, by name, as weights; others 1
        feed_through: whether the feed-through D from the removed states is kept; without it the steady state is wrong
        shift: decay rate that is added to all modes for the balancing [1/s]

    Source: B. C. Moore, 1981; square roots as M. S. Tombs, I. Postlethwaite, 1987; singular perturbation as Y. Liu,
    B. D. O. Anderson, 1989; Raffone, eqs (14) to (16), where (17) drops D.
    """
    from scipy.linalg import solve_continuous_lyapunov

    n = len(system.A)
    if not 1 <= order < n:
        raise ParameterError(f"order is {order}; expected 1 to {n - 1}, less than the order of the system")
    A = system.A - shift * np.eye(n)
    if np.linalg.eigvals(A).real.max() >= 0.0:
        raise ParameterError(f"a mode of the system does not decay with a shift of {shift:g} 1/s; give a larger one")
    B = system.B * [input_size.get(name, 1.0) for name in system.inputs]
    C = system.C / np.array([[output_size.get(name, 1.0)] for name in system.outputs])
    reached, shown = _root(solve_continuous_lyapunov(A, -B @ B.T)), _root(solve_continuous_lyapunov(A.T, -C.T @ C))
    left, values, right = np.linalg.svd(shown.T @ reached)
    to = left.T @ shown.T / np.sqrt(values)[:, None]
    back = reached @ right.T / np.sqrt(values)
    one, two = slice(order), slice(order, None)
    full, driven = to @ system.A @ back, to @ system.B
    slaved = -np.linalg.solve(full[two, two], full[two, one])
    slaved_input = -np.linalg.solve(full[two, two], driven[two])
    D = system.D + system.C @ back[:, two] @ slaved_input
    kept = back[:, one] + back[:, two] @ slaved
    reduced = LinearSystem(
        full[one, one] + full[one, two] @ slaved,
        driven[one] + full[one, two] @ slaved_input,
        system.C @ kept,
        D if feed_through else system.D,
        tuple(f"mode {k + 1}" for k in range(order)),
        system.inputs,
        system.outputs,
    )
    return Reduction(reduced, kept, back[:, two] @ slaved_input)


def _root(gramian: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
