"""Modes of a linear system, and the distance of each from being unobservable."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.models.linear import LinearSystem

TOLERANCE = 1e-9  # for the scaled system; eigenvalues lose several of the 16 digits of double precision


class Mode(NamedTuple):
    """One eigenvalue of a system, with the observability of its direction.

    Args:
        direction: least observable state direction at this eigenvalue, in the states' own units, largest entry 1, (n,)
        margin: smallest singular value of [A - eigenvalue I; C], both scaled to norm 1: 0 is unobservable
    """

    eigenvalue: complex
    direction: np.ndarray
    margin: float

    @property
    def number(self) -> str:
        """The eigenvalue as text."""
        real = abs(self.eigenvalue.imag) < 1e-9 * max(abs(self.eigenvalue), 1.0)
        return f"{self.eigenvalue.real:.6g}" if real else f"{self.eigenvalue:.6g}"


class Scaled(NamedTuple):
    """A and C of a system in scaled states, the state scale, and the norm by which A was divided."""

    A: np.ndarray
    C: np.ndarray
    scale: np.ndarray
    size: float


def scaled(system: LinearSystem, state_scale: np.ndarray | None = None) -> Scaled:
    """A and C in scaled states, with outputs of norm 1 and A shifted by its mean eigenvalue and divided by its norm.

    Shifting and scaling A does not change the observable subspace, but separates the modes of a finely sampled system,
    whose A is nearly the identity.
    """
    n = len(system.A)
    shifted = system.A - np.trace(system.A) / n * np.eye(n)
    scale = balance(shifted) if state_scale is None else np.asarray(state_scale, float)
    A = shifted * scale / scale[:, None]
    size = float(np.linalg.norm(A, 2))
    # A multiple of the identity leaves only rounding errors after the shift, which must not be scaled to 1.
    size = size if size > 1e-12 * np.linalg.norm(system.A, 2) else 1.0
    C = system.C * scale
    rows = np.linalg.norm(C, axis=1, keepdims=True)
    return Scaled(A / size, C / np.where(rows > 0.0, rows, 1.0), scale, size)


def balance(matrix: np.ndarray) -> np.ndarray:
    """State scale (powers of two) that balances the norms of rows and columns of a matrix."""
    from scipy.linalg import matrix_balance

    _, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
    return np.asarray(scale)


def modes(system: LinearSystem, state_scale: np.ndarray | None = None) -> list[Mode]:
    """Every eigenvalue with its margin (Popov-Belevitch-Hautus test), the least observable first."""
    A, C, scale, size = scaled(system, state_scale)
    shift = np.trace(system.A) / len(A)
    eigenvalues = np.linalg.eigvals(A)
    shifted = A - eigenvalues[:, None, None] * np.eye(len(A))
    _, values, rows = np.linalg.svd(np.concatenate([shifted, np.broadcast_to(C, (len(A), *C.shape))], axis=1))
    found = [
        Mode(complex(eigenvalue * size + shift), _phased(scale * direction.conj()), float(margin))
        for eigenvalue, direction, margin in zip(eigenvalues, rows[:, -1], values[:, len(A) - 1], strict=True)
    ]
    return sorted(found, key=lambda mode: mode.margin)


def _phased(vector: np.ndarray) -> np.ndarray:
    """The vector divided by its largest entry; real if all entries then are."""
    turned: np.ndarray = vector / vector[np.argmax(np.abs(vector))]
    return turned.real if (np.abs(turned.imag) <= 1e-9).all() else turned


def describe(direction: np.ndarray, names: tuple[str, ...]) -> str:
    """A direction as text, largest component first: "0.99 friction - 0.11 angle"."""
    real = np.asarray(direction).real
    strongest = np.abs(real).max()
    order = [k for k in np.argsort(-np.abs(real)) if abs(real[k]) > 0.02 * strongest]
    parts = [f"{'-' if real[k] < 0.0 else '+'} {abs(real[k]):.2g} {names[k]}" for k in order]
    return " ".join(parts).removeprefix("+ ")
