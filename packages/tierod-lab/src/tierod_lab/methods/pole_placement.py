"""Observer gains by placement of the poles of the estimation error."""

from __future__ import annotations

import warnings
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
    """Gain L of the full-order observer x <- x- + L (y - C x-), x- = A x + B u.

    Args:
        poles: wanted eigenvalues of the error, (I - L C) A, one per state, complex ones in pairs; equal ones allowed

    Returns:
        rows by state, columns by output

    Raises:
        ParameterError: wrong number of poles or no conjugate pairs, poles that are not reached, or a direction (named)
            that is not observable

    This is the gain of `Luenberger`. The gain of the predictor form, A - L C, is A times this one.
    """
    return _rows(place(replace(system, C=system.C @ system.A), poles))


def place(system: LinearSystem, poles: Sequence[complex]) -> np.ndarray:
    """Gain L that places the eigenvalues of A - L C at the poles, (n, outputs).

    Raises:
        ParameterError: as `observer_gain`
    """
    wanted = _checked(system, poles)
    _require_observable(system)
    A, C, scale, size = scaled(system)
    shift = np.trace(system.A) / len(A)
    moved = (wanted - shift) / size
    gain = _gain(A, C, moved)
    if not _reached(A - gain @ C, moved):
        raise ParameterError(
            f"the poles {_listed(wanted)} are not reached to 1e-6; spread them, or move them closer to the "
            f"eigenvalues of the system, {_listed(np.linalg.eigvals(system.A))}"
        )
    rows = np.linalg.norm(system.C * scale, axis=1)
    # An output that does not depend on the state gets a gain of zero, whatever the placement gave its column.
    per_row = np.divide(size, rows, out=np.zeros_like(rows), where=rows > 0.0)
    placed: np.ndarray = scale[:, None] * gain * per_row
    return placed


def _gain(A: np.ndarray, C: np.ndarray, poles: np.ndarray) -> np.ndarray:
    n, rank = len(A), np.linalg.matrix_rank(C)
    repeated = max(np.sum(np.isclose(poles, pole, rtol=1e-9, atol=1e-12)) for pole in poles)
    if rank > 1 and repeated <= rank:
        from scipy.signal import place_poles

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            left = np.linalg.svd(C)[0][:, :rank]
            return np.asarray(place_poles(A.T, (left.T @ C).T, poles).gain_matrix.T @ left.T)
    if len(C) == 1:
        return _ackermann(A, C, poles)
    # Repeated poles with several outputs: a small output injection makes A cyclic, then one output mixture suffices.
    generator = np.random.default_rng(0)
    injection = 0.1 * generator.standard_normal((n, len(C)))
    mixture = generator.standard_normal((1, len(C)))
    return injection + _ackermann(A - injection @ C, mixture @ C, poles) @ mixture


def _ackermann(A: np.ndarray, C: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Ackermann's formula phi(A) O^-1 e_n for one output, with the observability matrix O."""
    n = len(A)
    rows = [C[0]]
    for _ in range(n - 1):
        rows.append(rows[-1] @ A)
    last = np.zeros(n)
    last[-1] = 1.0
    column = np.linalg.solve(np.array(rows), last).astype(complex)
    for pole in poles:
        column = A @ column - pole * column
    return column.real[:, None]


def _checked(system: LinearSystem, poles: Sequence[complex]) -> np.ndarray:
    wanted = np.atleast_1d(np.asarray(poles, complex))
    n = len(system.A)
    if wanted.shape != (n,):
        raise ParameterError(f"{len(wanted)} poles for {n} states ({', '.join(system.states)}); expected one each")
    if not np.isfinite(wanted).all():
        raise ParameterError(f"the poles {_listed(wanted)} are not all finite")
    if not np.allclose(np.sort_complex(wanted), np.sort_complex(wanted.conj()), rtol=1e-9, atol=1e-12):
        raise ParameterError(f"the poles {_listed(wanted)} are not in complex pairs; give the conjugate of each")
    return wanted


def _require_observable(system: LinearSystem) -> None:
    weakest = modes(system)[0]
    if weakest.margin > TOLERANCE:
        return
    raise ParameterError(
        f"through {', '.join(system.outputs)} the direction {describe(weakest.direction, system.states)} "
        f"(eigenvalue {weakest.number}) is not observable, so its pole cannot be placed; "
        "measure it, or take it out of the state"
    )


def _reached(closed: np.ndarray, poles: np.ndarray) -> bool:
    have, want = np.poly(closed), np.poly(poles).real
    return bool(np.allclose(have, want, rtol=1e-6, atol=1e-6 * np.abs(want).max()))


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{value.real:.6g}" if value.imag == 0.0 else f"{value:.6g}" for value in values)


def _rows(matrix: np.ndarray) -> Gain:
    return tuple(tuple(float(value) for value in row) for row in matrix)
