"""Observer gains by placement of the poles of the estimation error, for systems with one output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.estimators.observers import Gain
from tierod.models.linear import TOLERANCE, LinearSystem, describe, modes, scaled


def discrete_poles(poles: Sequence[complex], sample_time: float) -> tuple[complex, ...]:
    """Poles of a sampled system, exp(s T), from continuous ones s [1/s]."""
    return tuple(complex(pole) for pole in np.exp(np.asarray(poles, complex) * sample_time))


def observer_gain(system: LinearSystem, poles: Sequence[complex]) -> Gain:
    """Gain L of the full-order observer x <- x- + L (y - C x-), x- = A x + B u, as `Luenberger` takes it.

    Args:
        poles: wanted eigenvalues of the error, (I - L C) A, one per state, complex ones in pairs; equal ones allowed
    """
    return tuple((float(row[0]),) for row in place(replace(system, C=system.C @ system.A), poles))


def place(system: LinearSystem, poles: Sequence[complex]) -> np.ndarray:
    """Gain L that places the eigenvalues of A - L C at the poles, (n, 1), by Ackermann's formula phi(A) O^-1 e_n.

    Raises:
        ParameterError: wrong number of poles or no conjugate pairs, or a direction (named) that is not observable
    """
    wanted = np.atleast_1d(np.asarray(poles, complex))
    n = len(system.A)
    if wanted.shape != (n,):
        raise ParameterError(f"{len(wanted)} poles for {n} states ({', '.join(system.states)}); expected one each")
    if not np.isfinite(wanted).all():
        raise ParameterError(f"the poles {wanted.tolist()} are not all finite")
    if not np.allclose(np.sort_complex(wanted), np.sort_complex(wanted.conj()), rtol=1e-9, atol=1e-12):
        raise ParameterError(f"the poles {wanted.tolist()} are not in complex pairs; give the conjugate of each")
    weakest = modes(system)[0]
    if weakest.margin <= TOLERANCE:
        raise ParameterError(
            f"through {', '.join(system.outputs)} the direction {describe(weakest.direction, system.states)} "
            f"(eigenvalue {weakest.number}) is not observable, so its pole cannot be placed; "
            "measure it, or take it out of the state"
        )
    A, C, scale, size = scaled(system)
    rows = [C[0]]
    for _ in range(n - 1):
        rows.append(rows[-1] @ A)
    column = np.linalg.solve(np.array(rows), np.eye(n)[-1]).astype(complex)
    for pole in (wanted - np.trace(system.A) / n) / size:
        column = A @ column - pole * column
    placed: np.ndarray = (scale * column.real * size / np.linalg.norm(system.C * scale))[:, None]
    return placed
