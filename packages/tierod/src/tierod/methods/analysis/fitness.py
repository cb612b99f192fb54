"""Checks that a model with its parameters can be estimated: stable, observable, and slow enough for its sample rate."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.methods.analysis.observability import observability
from tierod.models.linear import METHODS, TOLERANCE, LinearSystem, balance

SPLIT = 1e-4
"""Eigenvalues below this share of the fastest count as zero [-]: rounding splits a multiple eigenvalue at zero, such as
that of an angle under a constant torque, by as much."""

_ZERO = 1e-10

EXACT = "exact"
"""Discretisation by the matrix exponential (`zero_order_hold`), which keeps every stable eigenvalue stable."""


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

    Args:
        system: continuous; for a nonlinear model the `linearise`d one at each relevant operating point
        what: name of the model in messages, such as "the column of 'eps.toml'"
        stable: True: every eigenvalue in the open left half plane; "marginal": none in the right half plane, so that
            angles without a spring and constant disturbances pass; False: not checked
        sample_time: step of the integration; None: not checked [s]
        method: of integration: "euler", "midpoint", "rk4", which must not make a decaying mode grow, or "exact", for
            which a vibration must stay below half the sample rate, to avoid aliasing

    Raises:
        ParameterError: a model that fails a check, with the eigenvalue or the unobservable direction, and what to do
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
