"""Observability of a linear system, and whether a model suits the estimator or simulation that uses it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import METHODS, TOLERANCE, LinearSystem, Mode, balance, describe, modes, scaled


@dataclass(frozen=True, eq=False)
class Observability:
    """Observability of a state through the outputs."""

    states: tuple[str, ...]
    rank: int  # dimension of the observable subspace, to the tolerance
    tolerance: float  # relative size below which a direction counts as unobservable
    # of the orthonormal observability staircase, largest first, scaled (n,); the gap at the tolerance is the margin of
    # the rank
    singular_values: np.ndarray
    hidden: np.ndarray  # unobservable directions in the states' own units, columns with largest entry 1, (n, n - rank)
    modes: tuple[Mode, ...]  # eigenvalues with their margin (PBH test), the least observable first

    @property
    def complete(self) -> bool:
        """Whether every state is observable."""
        return self.rank == len(self.states)

    def sentence(self) -> str:
        """The result in words, with the unobservable directions."""
        n = len(self.states)
        if self.complete:
            return f"rank {self.rank} of {n}: every state is observable"
        directions = "; ".join(describe(column, self.states) for column in self.hidden.T)
        return f"rank {self.rank} of {n} (tolerance {self.tolerance:g}): not observable: {directions}"


def observability(
    system: LinearSystem, tolerance: float = TOLERANCE, state_scale: ArrayLike | None = None
) -> Observability:
    """Observability of (A, C): rank, singular values, unobservable directions and PBH margins.

    A is shifted by its mean eigenvalue and scaled to norm 1, states are balanced, outputs are scaled to norm 1. This
    does not change the observable subspace, and protects the rank from rounding errors. The rank comes from the
    staircase of orthonormal bases, not from powers of A.

    Source: staircase, P. Van Dooren, 1981, doi 10.1109/TAC.1981.1102559; PBH test, M. L. J. Hautus, 1969.

    Args: tolerance: relative size below which a direction counts as unobservable; 1e-9 leaves six digits for rounding.
    A model with parameters of three digits needs 1e-3: the rank that holds in spite of their errors; state_scale:
    typical size of each state [its unit], (n,); balanced from A where None.
    """
    if not 0.0 < tolerance < 1.0:
        raise ParameterError(f"tolerance is {tolerance}; expected a number between 0 and 1")
    n = len(system.A)
    if state_scale is not None:
        state_scale = np.asarray(state_scale, float)
        if state_scale.shape != (n,) or not (np.isfinite(state_scale) & (state_scale > 0.0)).all():
            raise ParameterError(f"state_scale needs a number above zero for each of {', '.join(system.states)}")
    form = scaled(system, state_scale)
    seen, values = _staircase(form.A, form.C, tolerance)
    hidden = np.linalg.svd(seen)[2][len(seen) :].T if len(seen) else np.eye(n)
    return Observability(
        system.states,
        len(seen),
        tolerance,
        values,
        _readable(hidden, form.scale),
        tuple(modes(system, state_scale)),
    )


def _readable(basis: np.ndarray, scale: np.ndarray) -> np.ndarray:
    from scipy.linalg import qr

    count = basis.shape[1]
    if not count:
        return basis
    pivots = np.sort(qr(basis.T, pivoting=True)[2][:count])
    columns = basis @ np.linalg.inv(basis[pivots])
    columns = np.where(np.abs(columns) > TOLERANCE, columns, 0.0) * scale[:, None]
    return np.asarray(columns / np.abs(columns).max(axis=0))


def _staircase(A: np.ndarray, C: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    n = len(A)
    seen = np.zeros((0, n))
    values: list[float] = []
    new = C
    while len(new) and len(seen) < n:
        rest = new - (new @ seen.T) @ seen
        rest = rest - (rest @ seen.T) @ seen  # a second time, since rounding spoils the first for nearly known rows
        _, sizes, rows = np.linalg.svd(rest, full_matrices=False)
        keep = sizes > tolerance
        values += sizes.tolist()
        seen = np.vstack([seen, rows[keep]])
        new = rows[keep] @ A
    padded = np.sort(np.array(values))[::-1][:n]
    return seen[:n], np.pad(padded, (0, n - len(padded)))


# Eigenvalues below this share of the fastest count as zero [-]: rounding splits a multiple eigenvalue at zero, such as
# that of an angle under a constant torque, by as much
SPLIT = 1e-4
_ZERO = 1e-10
# Discretisation by the matrix exponential (`zero_order_hold`), which keeps every stable eigenvalue stable
EXACT = "exact"


def require_fit(
    system: LinearSystem,
    what: str,
    *,
    stable: bool | Literal["marginal"],
    observable: bool,
    sample_time: float | None = None,
    method: str = EXACT,
    tolerance: float = TOLERANCE,
) -> None:
    """Check that a model is stable, observable and slow enough for its sample rate.

    Example: `require_fit(linearise(SteeringColumn, p, state, inputs), "the column", stable="marginal",
    observable=True, sample_time=1e-3)`.

    Args: system: continuous; for a nonlinear model the `linearise`d one at each relevant operating point; stable: True:
    every eigenvalue in the open left half plane; "marginal": none in the right half plane, so that angles without a
    spring and constant disturbances pass; False: not checked; sample_time: step of the integration; None: not checked
    [s].
    """
    values, vectors = _eigen(system)
    if stable:
        _require_stable(values, vectors, system, what, marginal=stable == "marginal")
    if sample_time is not None:
        _require_slow(values, vectors, system, what, sample_time, method)
    if observable:
        shown = observability(system, tolerance)
        if not shown.complete:
            raise ParameterError(
                f"{what} cannot be observed through {', '.join(system.outputs) or 'no output'}: {shown.sentence()}; "
                "add an output by which it is observable, or leave that state out"
            )


def _eigen(system: LinearSystem) -> tuple[np.ndarray, np.ndarray]:
    scale = balance(system.A)
    return np.linalg.eig(system.A * scale / scale[:, None])


def _require_stable(
    values: np.ndarray, vectors: np.ndarray, system: LinearSystem, what: str, *, marginal: bool
) -> None:
    if not len(values):
        return
    fastest = float(np.abs(values).max())
    worst = int(np.argmax(np.where(np.abs(values) < SPLIT * fastest, np.minimum(values.real, 0.0), values.real)))
    growth = float(values[worst].real)
    mode = f"eigenvalue {_number(values[worst])} 1/s in {_where(vectors[:, worst], system)}"
    if growth > _ZERO * fastest and abs(values[worst]) >= SPLIT * fastest:
        raise ParameterError(
            f"{what} is unstable: {mode}; check the signs of its stiffnesses and dampings, and that no inertia is "
            "zero or below"
        )
    if not marginal and growth >= -_ZERO * fastest:
        raise ParameterError(f"{what} does not come to rest: {mode}; give it damping or a spring to the housing there")


def _require_slow(
    values: np.ndarray, vectors: np.ndarray, system: LinearSystem, what: str, sample_time: float, method: str
) -> None:
    if not 0.0 < sample_time < math.inf:
        raise ParameterError(f"sample_time is {sample_time}; expected a time greater than zero [s]")
    if method != EXACT and method not in METHODS:
        raise ParameterError(f"'{method}' is not a method of integration{nearest(method, [EXACT, *METHODS])}")
    for k in np.argsort(-np.abs(values)):
        value = complex(values[k])
        if method != EXACT and value.real < 0.0 and _growth(method, value * sample_time) > 1.0:
            trouble, longest = f"steps of {sample_time:g} s by {method} make it grow", _longest(method, value)
        elif method == EXACT and abs(value.imag) * sample_time >= math.pi:
            trouble, longest = f"samples every {sample_time:g} s alias it to a slower one", math.pi / abs(value.imag)
        else:
            continue
        raise ParameterError(
            f"{what} is too fast for its rate: eigenvalue {_number(value)} 1/s ({abs(value) / math.tau:.3g} Hz) in "
            f"{_where(vectors[:, k], system)}; {trouble}. Step it at most {longest:.2g} s"
            f" ({math.ceil(1.0 / longest)} Hz or faster)"
            + ("" if method == EXACT else ", sample it exactly (zero_order_hold)")
            + ", or leave that mode out"
        )


def _growth(method: str, step: complex) -> float:
    return float(abs(METHODS[method](lambda x: step * x, 1.0 + 0.0j, 1.0)))


def _longest(method: str, value: complex) -> float:
    """The longest step at which a mode decays [s], by bisection."""
    low, high = 0.0, 10.0 / abs(value)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _growth(method, value * middle) <= 1.0 else (low, middle)
    return low


def _where(vector: np.ndarray, system: LinearSystem) -> str:
    sizes = np.abs(vector)
    order = [int(k) for k in np.argsort(-sizes) if sizes[k] > 0.3 * sizes.max()]
    return ", ".join(system.states[k] for k in order)


def _number(value: complex) -> str:
    real = abs(value.imag) < 1e-9 * max(abs(value), 1.0)
    return f"{value.real:.4g}" if real else f"{value.real:.4g} {'+' if value.imag > 0 else '-'} {abs(value.imag):.4g}i"
