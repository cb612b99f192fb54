"""Modes of a linear system, and how far each is from being unobservable."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.models.linear import LinearSystem

TOLERANCE = 1e-9  # of the scaled system; double precision loses a few digits beyond 1e-16 in eigenvalues


class Mode(NamedTuple):
    """One eigenvalue of a system and how well its direction is seen.

    Args:
        eigenvalue: of A
        direction: state direction that is seen least at it, in the states' own units, largest entry 1, (n,)
        margin: smallest singular value of [A - eigenvalue I; C], both scaled to size 1: 0 is unobservable
    """

    eigenvalue: complex
    direction: np.ndarray
    margin: float

    @property
    def number(self) -> str:
        """The eigenvalue in short."""
        real = abs(self.eigenvalue.imag) < 1e-9 * max(abs(self.eigenvalue), 1.0)
        return f"{self.eigenvalue.real:.6g}" if real else f"{self.eigenvalue:.6g}"


class Scaled(NamedTuple):
    """A and C of a system in scaled states, the state scale, and the size by which A was divided."""

    A: np.ndarray
    C: np.ndarray
    scale: np.ndarray
    size: float


def scaled(system: LinearSystem, state_scale: np.ndarray | None = None) -> Scaled:
    """A and C in scaled states, each output of size 1, A without its mean eigenvalue and of size 1.

    Shifting and scaling A does not change what is observable, but it separates the modes of a finely sampled system,
    whose A is nearly the identity.
    """
    n = len(system.A)
    shifted = system.A - np.trace(system.A) / n * np.eye(n)
    scale = balance(shifted) if state_scale is None else np.asarray(state_scale, float)
    A = shifted * scale / scale[:, None]
    size = float(np.linalg.norm(A, 2))
    size = size if size > 1e-12 * np.linalg.norm(system.A, 2) else 1.0
    C = system.C * scale
    rows = np.linalg.norm(C, axis=1, keepdims=True)
    return Scaled(A / size, C / np.where(rows > 0.0, rows, 1.0), scale, size)


def balance(matrix: np.ndarray) -> np.ndarray:
    """State scale (powers of two) that makes rows and columns of a matrix alike in size."""
    from scipy.linalg import matrix_balance

    _, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
    return np.asarray(scale)


def modes(system: LinearSystem, state_scale: np.ndarray | None = None) -> list[Mode]:
    """Every eigenvalue with its margin (Popov-Belevitch-Hautus test), the least visible first."""
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
    """The vector divided by its largest entry; real where it can be."""
    turned: np.ndarray = vector / vector[np.argmax(np.abs(vector))]
    return turned.real if (np.abs(turned.imag) <= 1e-9).all() else turned


def describe(direction: np.ndarray, names: tuple[str, ...]) -> str:
    """A direction in words, largest part first: "0.99 friction - 0.11 angle"."""
    real = np.asarray(direction).real
    strongest = np.abs(real).max()
    order = [k for k in np.argsort(-np.abs(real)) if abs(real[k]) > 0.02 * strongest]
    parts = [f"{'-' if real[k] < 0.0 else '+'} {abs(real[k]):.2g} {names[k]}" for k in order]
    return " ".join(parts).removeprefix("+ ")
