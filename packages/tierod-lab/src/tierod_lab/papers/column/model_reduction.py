"""Balanced and modal reduction of linear systems by singular perturbation or truncation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, balance

_SLOWEST = 1e-9


def observability_gramian(system: LinearSystem, horizon: float | None = None) -> np.ndarray:
    """Integral of exp(A't) C'C exp(At), (n, n).

    Args:
        horizon: upper limit of the integral [s]; None for infinity, where it exists for stable systems only

    Raises:
        ParameterError: no horizon for a system with an eigenvalue that does not decay, or a horizon that is not
            positive and finite
    """
    from scipy.linalg import solve_continuous_lyapunov

    A, Q = system.A, system.C.T @ system.C
    if horizon is not None:
        return _over(A, Q, horizon)
    values = np.linalg.eigvals(A)
    if len(values) and values.real.max() > -_SLOWEST * np.abs(values).max():
        worst = values[np.argmax(values.real)]
        raise ParameterError(
            f"the Gramian over all time does not exist: eigenvalue {worst:.4g} 1/s does not decay; give a horizon, or "
            "shift the system left (`tierod_lab.papers.column.model_reduction`)"
        )
    return np.asarray(solve_continuous_lyapunov(A.T, -Q))


def controllability_gramian(system: LinearSystem, horizon: float | None = None) -> np.ndarray:
    """Integral of exp(At) BB' exp(A't), (n, n); arguments as `observability_gramian`."""
    dual = replace(system, A=system.A.T, C=system.B.T, B=system.C.T, D=system.D.T)
    return observability_gramian(dual, horizon)


def gramian_condition(gramian: np.ndarray) -> float:
    """Condition number of the Gramian, with each state in the unit that makes its diagonal entry 1.

    These units are within a factor n of the best ones (A. van der Sluis, 1969), so that the result depends on the
    system and not on its units. Beyond 1e14, the limit of double precision, the result is infinite.
    """
    size = np.sqrt(np.maximum(np.diag(gramian), 0.0))
    if not (size > 0.0).all():
        return float("inf")
    values = np.linalg.eigvalsh(gramian / np.outer(size, size))
    return float(values[-1] / values[0]) if values[0] > 1e-14 * values[-1] else float("inf")


def _over(A: np.ndarray, Q: np.ndarray, horizon: float) -> np.ndarray:
    from scipy.linalg import expm

    if not 0.0 < horizon < float("inf"):
        raise ParameterError(f"horizon is {horizon}; expected a time greater than zero [s]")
    n = len(A)
    doublings = max(0, math.ceil(math.log2(max(float(np.linalg.norm(A, 2)) * horizon, 1.0))))
    pair = np.block([[-A.T, Q], [np.zeros((n, n)), A]]) * (horizon / 2.0**doublings)
    whole = expm(pair)
    transition = whole[n:, n:]
    gramian = transition.T @ whole[:n, n:]
    for _ in range(doublings):
        gramian = gramian + transition.T @ gramian @ transition
        transition = transition @ transition
    return np.asarray(0.5 * (gramian + gramian.T))


DECAY = 1e-7  # Decay rate over the magnitude of the fastest eigenvalue, from which on a mode counts as decaying [-]

_MINIMAL = 1e-11


@dataclass(frozen=True, eq=False)
class Balanced:
    """A system in balanced coordinates z = to x, x = back z."""

    # in balanced coordinates; modes that do not decay first, then the others by falling Hankel values
    system: LinearSystem
    # to, back: (k, n) and (n, k); k is below n where a part of the state is not controllable or not observable
    to: np.ndarray
    back: np.ndarray
    hankel: np.ndarray  # Hankel singular values of the decaying part
    kept: int  # number of the first states, which do not decay


def balanced(system: LinearSystem, shift: float | None = None) -> Balanced:
    """Balance the decaying part by square roots of both Gramians; modes that do not decay are separated from it first.

    Args:
        system: continuous, inputs and outputs in units of their typical size
        shift: decay rate that is added to all modes to balance the whole system [1/s]; None for a separation instead

    Raises:
        ParameterError: a shift with which some mode still does not decay, no state that is both controllable and
            observable, or as `parted`

    Source: B. C. Moore, 1981; square roots as M. S. Tombs, I. Postlethwaite, 1987.
    """
    n = len(system.A)
    if shift is None:
        fastest = float(np.abs(np.linalg.eigvals(system.A)).max())
        first, back, kept = parted(system, lambda value: value.real > -DECAY * fastest)
        if kept == n:
            return Balanced(system, np.eye(n), np.eye(n), np.zeros(0), n)
    else:
        first, back, kept = np.eye(n), np.eye(n), 0
    part = replace(
        system,
        A=(first @ system.A @ back)[kept:, kept:] - (shift or 0.0) * np.eye(n - kept),
        B=(first @ system.B)[kept:],
        C=(system.C @ back)[:, kept:],
    )
    into, out, hankel = _square_roots(part)
    to = np.vstack([first[:kept], into @ first[kept:]])
    out = np.hstack([back[:, :kept], back[:, kept:] @ out])
    form = replace(
        system,
        A=to @ system.A @ out,
        B=to @ system.B,
        C=system.C @ out,
        states=tuple(f"mode {k + 1}" for k in range(len(to))),
    )
    return Balanced(form, to, out, hankel, kept)


def parted(system: LinearSystem, stays: Callable[[complex], bool]) -> tuple[np.ndarray, np.ndarray, int]:
    """Coordinates in which A is block-diagonal with two blocks.

    Args:
        system: continuous or discrete
        stays: whether an eigenvalue belongs to the first block

    Returns:
        to and back (z = to x, x = back z), and the size of the first block

    Raises:
        ParameterError: both blocks share an eigenvalue
    """
    from scipy.linalg import schur, solve_sylvester

    scale = balance(system.A)
    triangle, turn, kept = schur(
        system.A * scale / scale[:, None], output="real", sort=lambda re, im: stays(complex(re, im))
    )
    n = len(system.A)
    coupling = np.eye(n)
    if 0 < kept < n:
        try:
            coupling[:kept, kept:] = solve_sylvester(
                triangle[:kept, :kept], -triangle[kept:, kept:], -triangle[:kept, kept:]
            )
        except np.linalg.LinAlgError as error:
            raise ParameterError(f"the system cannot be split: {error}; choose another order") from None
    back = scale[:, None] * turn @ coupling
    inverse = 2.0 * np.eye(n) - coupling  # of a matrix [I, X; 0, I]: [I, -X; 0, I]
    return inverse @ turn.T / scale, back, kept


def _square_roots(part: LinearSystem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Transformations to and from balanced coordinates, and the Hankel singular values above rounding errors."""
    reached = _root(controllability_gramian(part))
    shown = _root(observability_gramian(part))
    left, values, right = np.linalg.svd(shown.T @ reached)
    count = int(np.count_nonzero(values > _MINIMAL * values[0])) if values[0] > 0.0 else 0
    if not count:
        raise ParameterError("no state is both controllable and observable; choose other inputs or outputs")
    size = np.sqrt(values[:count])
    return left[:, :count].T @ shown.T / size[:, None], reached @ right[:count].T / size, values[:count]


def _root(gramian: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


RESTS = ("steady", "left out")
"""Treatment of the removed states: at their steady state for the others and the inputs (singular perturbation, exact at
zero frequency), or zero (truncation, exact at high frequency)."""

_SINGULAR = 1e-12


@dataclass(frozen=True, eq=False)
class Reduction:
    """A system with fewer states, and its relation to the full one."""

    system: LinearSystem  # the reduced one; its states are combinations without unit, "mode 1", "mode 2", ...
    onto: np.ndarray  # z = onto x, (order, n)
    # back, back_input: x = back z + back_input u, as far as z determines it, (n, order) and (n, inputs)
    back: np.ndarray
    back_input: np.ndarray
    # Hankel singular values of the decaying part, in scaled units, largest first; empty for a modal reduction
    hankel: np.ndarray
    # bound of the largest gain of the difference over all frequencies, in scaled units: twice the sum of the removed
    # Hankel values (K. Glover, 1984); None where there is no bound
    error_bound: float | None

    def physical(self, *names: str, of: LinearSystem) -> LinearSystem:
        """The reduced system with states of the full one as additional outputs, so that an observer estimates them."""
        rows = [of.states.index(name) for name in names]
        C = np.vstack([self.system.C, self.back[rows]])
        D = np.vstack([self.system.D, self.back_input[rows]])
        return replace(self.system, C=C, D=D, outputs=(*self.system.outputs, *names))


def balanced_reduction(
    system: LinearSystem,
    order: int,
    *,
    rest: str = "steady",
    feed_through: bool = True,
    input_size: Mapping[str, float] | None = None,
    output_size: Mapping[str, float] | None = None,
    shift: float | None = None,
) -> Reduction:
    """Balanced reduction: keep the states that are most controllable and observable.

    Modes that do not decay (the free angle of a column, disturbances as states) have no Gramian. They are separated and
    kept, or with a shift the whole system is balanced as if all modes decayed faster.

    Args:
        order: states of the reduced system, those that do not decay included
        rest: one of `RESTS`
        feed_through: whether the feed-through D from the removed states is kept; without it the steady state is wrong
        input_size, output_size: typical size of each input and output in its unit, by name, as weights; 1 by default
        shift: additional decay rate for balancing instead of a separation [1/s]; then there is no error bound

    Raises:
        ParameterError: an order out of range, an unknown rest or name, a rest without steady state, or as `balanced`

    Source: B. C. Moore, 1981; Y. Liu, B. D. O. Anderson, 1989; Raffone, eqs (14) to (16), where (17) drops D.
    """
    _require(system, order, rest)
    sized = _sized(system, input_size or {}, output_size or {})
    form = balanced(sized, shift)
    fixed, total = form.kept, len(form.system.A)
    if order < fixed:
        raise ParameterError(f"{fixed} states of the system do not decay; keep at least {fixed}, not {order}")
    tail = form.hankel[order - fixed :] if order < total else np.zeros(0)
    bound = 2.0 * float(tail.sum()) if shift is None and feed_through else None
    return _reduced(system, form, min(order, total), rest, feed_through, bound)


def modal_reduction(system: LinearSystem, order: int, *, rest: str = "steady", feed_through: bool = True) -> Reduction:
    """Modal reduction: keep the slowest eigenvalues.

    Args:
        rest, feed_through: as `balanced_reduction`

    Raises:
        ParameterError: an order out of range or between the two eigenvalues of a pair, an unknown rest, or a rest
            without steady state
    """
    _require(system, order, rest)
    sizes = np.sort(np.abs(np.linalg.eigvals(system.A)))
    if order < len(sizes) and sizes[order] - sizes[order - 1] < 1e-9 * sizes[-1]:
        raise ParameterError(f"order {order} would split a pair of eigenvalues; choose {order - 1} or {order + 1}")
    limit = 0.5 * float(sizes[order - 1] + sizes[order]) if order < len(sizes) else float("inf")
    to, back, kept = parted(system, lambda value: abs(value) < limit)
    return _reduced(system, Balanced(_turned(system, to, back), to, back, np.zeros(0), kept), order, rest, feed_through)


def _require(system: LinearSystem, order: int, rest: str) -> None:
    if not 1 <= order <= len(system.A):
        raise ParameterError(f"order is {order}; expected 1 to {len(system.A)}, the order of the system")
    if rest not in RESTS:
        raise ParameterError(f"rest is '{rest}'; expected {' or '.join(map(repr, RESTS))}")


def _sized(system: LinearSystem, inputs: Mapping[str, float], outputs: Mapping[str, float]) -> LinearSystem:
    for sizes, names in ((inputs, system.inputs), (outputs, system.outputs)):
        wrong = [name for name, size in sizes.items() if name not in names or not 0.0 < size < float("inf")]
        if wrong:
            raise ParameterError(
                f"size of {', '.join(wrong)}: expected a number above zero for one of {', '.join(names)}"
            )
    b = np.array([inputs.get(name, 1.0) for name in system.inputs])
    c = np.array([[1.0 / outputs.get(name, 1.0)] for name in system.outputs])
    return replace(system, B=system.B * b, C=system.C * c, D=system.D * b * c)


def _turned(system: LinearSystem, to: np.ndarray, back: np.ndarray) -> LinearSystem:
    names = tuple(f"mode {k + 1}" for k in range(len(to)))
    return replace(system, A=to @ system.A @ back, B=to @ system.B, C=system.C @ back, states=names)


def _reduced(
    system: LinearSystem, form: Balanced, order: int, rest: str, feed_through: bool, bound: float | None = None
) -> Reduction:
    """Eqs (14) to (16): the first states are kept, the others are at their steady state or zero."""
    full = _turned(system, form.to, form.back)
    one, two = slice(order), slice(order, None)
    slaved, driven = _followers(full, order, rest)
    D = full.D + full.C[:, two] @ driven
    reduced = LinearSystem(
        full.A[one, one] + full.A[one, two] @ slaved,
        full.B[one] + full.A[one, two] @ driven,
        full.C[:, one] + full.C[:, two] @ slaved,
        D if feed_through else system.D,
        full.states[one],
        system.inputs,
        system.outputs,
    )
    back = form.back[:, one] + form.back[:, two] @ slaved
    return Reduction(reduced, form.to[one], back, form.back[:, two] @ driven, form.hankel, bound)


def _followers(full: LinearSystem, order: int, rest: str) -> tuple[np.ndarray, np.ndarray]:
    gone, inputs = len(full.A) - order, full.B.shape[1]
    if rest == "left out" or not gone:
        return np.zeros((gone, order)), np.zeros((gone, inputs))
    A22 = full.A[order:, order:]
    values = np.linalg.svd(A22, compute_uv=False)
    if values[-1] <= _SINGULAR * values[0]:
        raise ParameterError(
            f"the {gone} states that would be removed have no steady state (A22 is singular); keep more than {order}, "
            "or leave them out (rest='left out')"
        )
    return -np.linalg.solve(A22, full.A[order:, :order]), -np.linalg.solve(A22, full.B[order:])
