"""Linear quadratic regulators of sampled systems with integral action and computation delay, and that of a column."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import TOLERANCE, LinearSystem, Mode, describe, linearise, modes, sampled
from tierod.models.steering_column import TwoInertiaColumn, TwoInertiaParameters

_LASTING = 1.0 - 1e-9  # Modulus above which an eigenvalue counts as not decaying


@dataclass(frozen=True, eq=False)
class Regulator:
    """State feedback u = -K x that minimises the sum of x' Q x + u' R u."""

    gain: np.ndarray  # K, (inputs, n)
    cost: np.ndarray  # P, where x' P x is the cost to go, (n, n)
    eigenvalues: np.ndarray  # eigenvalues of A - B K, the slowest first
    system: LinearSystem  # system of the design

    def of(self, state: str, command: str | None = None) -> float:
        """Gain from one state to one input, the first input where none is named.

        Raises:
            ParameterError: no state or input has that name
        """
        row = 0 if command is None else _index(command, self.system.inputs, "an input")
        return float(self.gain[row, _index(state, self.system.states, "a state")])


def lqr(system: LinearSystem, state_weight: np.ndarray | Mapping[str, float], input_weight: object) -> Regulator:
    """Linear quadratic regulator of a sampled system, by SciPy's Riccati solver.

    Example: `lqr(with_integral(sampled(system, 1e-3), ("shaft",), 1e-3), {"shaft_integral": 1e3, "angle": 10.0}, [1])`.

    Args:
        state_weight: Q, (n, n), or weights by name of state or output; the weight w of an output adds w c' c, and a
            state or output that is not named has no weight
        input_weight: R, (inputs, inputs), or its diagonal, above zero

    Raises:
        ParameterError: a weight is negative, or a direction that does not decay is not controllable (its eigenvalue is
            named) or has no weight

    Source: B. D. O. Anderson, J. B. Moore, Optimal Control: Linear Quadratic Methods, 1990, section 2.4.
    """
    from scipy.linalg import solve_discrete_are

    Q = _by_name(system, state_weight) if isinstance(state_weight, Mapping) else _square(state_weight, len(system.A))
    R = _square(input_weight, system.B.shape[1])
    _require_weights(Q, "state_weight", 0.0)
    _require_weights(R, "input_weight", 1e-14 * np.abs(R).max(initial=1e-300))
    require_stabilisable(system)
    _require_weighted(system, Q)
    A, B = system.A, system.B
    try:
        cost = solve_discrete_are(A, B, Q, R)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise ParameterError(
            f"no regulator was found ({error}); give states weights of like size, and weigh one that matters more"
        ) from None
    gain = np.linalg.solve(R + B.T @ cost @ B, B.T @ cost @ A)
    eigenvalues = np.linalg.eigvals(A - B @ gain)
    eigenvalues = eigenvalues[np.argsort(-np.abs(eigenvalues))]
    if not np.abs(eigenvalues[0]) < 1.0:
        raise ParameterError(
            f"the regulated system keeps the eigenvalue {eigenvalues[0]:.6g}, which does not decay; "
            "weigh the states that it moves"
        )
    return Regulator(gain, 0.5 * (cost + cost.T), eigenvalues, system)


def with_integral(system: LinearSystem, outputs: tuple[str, ...], sample_time: float) -> LinearSystem:
    """The system extended by the integrals of some outputs as states, each named after its output with "_integral".

    Args:
        outputs: names of the outputs; the controller subtracts their references before it integrates
        sample_time: sampling interval [s]

    Raises:
        ParameterError: an output does not exist
    """
    rows = [_index(name, system.outputs, "an output") for name in outputs]
    n, more = len(system.A), len(rows)
    A = np.eye(n + more)
    A[:n, :n], A[n:, :n] = system.A, sample_time * system.C[rows]
    return replace(
        system,
        A=A,
        B=np.vstack([system.B, sample_time * system.D[rows]]),
        C=np.hstack([system.C, np.zeros((len(system.C), more))]),
        states=(*system.states, *(f"{name}_integral" for name in outputs)),
    )


def with_delay(system: LinearSystem, kept: float = 0.0) -> LinearSystem:
    """The system with inputs that act one sample later, by computation delay; they are states named "previous_...".

    Args:
        kept: pole of a first-order low-pass on the inputs, the share of the last input that remains; 0 for none

    Raises:
        ParameterError: a share outside 0 to 1
    """
    if not 0.0 <= kept < 1.0:
        raise ParameterError(f"kept is {kept}; expected a share of at least 0 and less than 1")
    n, m = system.B.shape
    A = np.zeros((n + m, n + m))
    A[:n, :n], A[:n, n:], A[n:, n:] = system.A, system.B, kept * np.eye(m)
    return replace(
        system,
        A=A,
        B=np.vstack([np.zeros((n, m)), (1.0 - kept) * np.eye(m)]),
        C=np.hstack([system.C, system.D]),
        D=np.zeros_like(system.D),
        states=(*system.states, *(f"previous_{name}" for name in system.inputs)),
    )


def require_stabilisable(system: LinearSystem) -> None:
    """Refuse a discrete system that is not stabilisable.

    Raises:
        ParameterError: a direction neither decays nor is controllable; it is named with its eigenvalue
    """
    # A mode is uncontrollable where it is unobservable in the dual system.
    for mode in _lasting(LinearSystem.of(system.A.T, system.B.T, states=system.states)):
        raise ParameterError(
            f"the inputs {', '.join(system.inputs) or '(none)'} do not move the direction "
            f"{describe(mode.direction, system.states)} (eigenvalue {mode.number}), which does not decay; "
            "no feedback can hold it: add an actuator, or take it out of the state"
        )


def _require_weighted(system: LinearSystem, Q: np.ndarray) -> None:
    values, vectors = np.linalg.eigh(Q)
    # A direction without weight is unobservable through the square root of Q.
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    for mode in _lasting(LinearSystem.of(system.A, root, states=system.states)):
        raise ParameterError(
            f"state_weight does not weigh the direction {describe(mode.direction, system.states)} "
            f"(eigenvalue {mode.number}), which does not decay, so that it would be left alone; give it a weight"
        )


def _lasting(system: LinearSystem) -> list[Mode]:
    return [mode for mode in modes(system) if mode.margin < TOLERANCE and abs(mode.eigenvalue) >= _LASTING]


def _by_name(system: LinearSystem, weights: Mapping[str, float]) -> np.ndarray:
    Q = np.zeros_like(system.A)
    for name, weight in weights.items():
        if not 0.0 <= weight < np.inf:
            raise ParameterError(f"the weight of {name} is {weight}; expected a finite number that is not negative")
        if name in system.states:
            row = np.eye(len(Q))[system.states.index(name)]
        else:
            known = (*system.states, *system.outputs)
            row = system.C[_index(name, system.outputs, "a state or an output", known)]
        Q += weight * np.outer(row, row)
    return Q


def _square(weights: object, n: int) -> np.ndarray:
    matrix = np.atleast_1d(np.asarray(weights, float))
    matrix = np.diag(matrix) if matrix.ndim == 1 else matrix
    if matrix.shape != (n, n) or not np.isfinite(matrix).all():
        raise ParameterError(
            f"weights of the shape {matrix.shape}; expected {n} finite weights, or a ({n}, {n}) matrix"
        )
    return matrix


def _require_weights(matrix: np.ndarray, what: str, least: float) -> None:
    lowest = float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min(initial=np.inf))
    if lowest < least - 1e-12 * np.abs(matrix).max(initial=0.0) or (least > 0.0 and lowest <= 0.0):
        expected = "above zero" if least > 0.0 else "not negative"
        raise ParameterError(f"{what} has the eigenvalue {lowest:.6g}; expected weights that are {expected}")


def _index(name: str, known: tuple[str, ...], what: str, offered: tuple[str, ...] = ()) -> int:
    if name not in known:
        raise ParameterError(f"'{name}' is not {what} of the system{nearest(name, offered or known)}")
    return known.index(name)


WEIGHTS: Mapping[str, float] = {"shaft": 300.0, "steering_wheel_angle": 200.0, "shaft_integral": 4.0e4}
"""Weights of the errors of shaft [1/rad^2], steering wheel [1/rad^2] and integral [1/(rad s)^2] against a motor torque
of 1 (N m)^2: three degrees of the shaft weigh as much as 1 N m. The weight of the wheel damps its oscillation on the
torsion bar. Three times the weight of the shaft would leave two thirds of the error by friction, and a tenth less
distance from instability."""

SMOOTHING = 2e-3
"""Time constant of the low-pass of the feedback [s]. It shifts the phase at the gear mode, 112 Hz in the paper's
column, so that feedback through an observer without the gear does not excite that mode."""


def regulator(
    column: TwoInertiaParameters,
    torsion_bar_stiffness: float,
    sample_time: float,
    weights: Mapping[str, float] | None = None,
    torque_weight: float = 1.0,
    smoothing: float = SMOOTHING,
) -> Regulator:
    """Regulator of a column without gear, with delay, low-pass of the feedback and integral of the shaft angle.

    Args:
        torsion_bar_stiffness: stiffness between the steering wheel and the controlled shaft [N m/rad]
        sample_time: sampling interval [s]
        weights: weights of states and of the `shaft`, as in `lqr`; `WEIGHTS` where None
        torque_weight: weight of the motor torque, 1/(N m)^2
        smoothing: time constant of the low-pass, 0 for none [s]

    Raises:
        ParameterError: as in `lqr`
    """
    system = column_system(column, torsion_bar_stiffness, sample_time)
    whole = with_integral(with_delay(system, kept_share(smoothing, sample_time)), ("shaft",), sample_time)
    return lqr(whole, WEIGHTS if weights is None else weights, [torque_weight])


def kept_share(smoothing: float, sample_time: float) -> float:
    """Pole of a sampled first-order low-pass: the share of its output that remains after one sample.

    Args:
        smoothing: time constant, 0 for none [s]
        sample_time: sampling interval [s]

    Raises:
        ParameterError: a negative time constant
    """
    if not 0.0 <= smoothing < math.inf:
        raise ParameterError(f"smoothing is {smoothing} s; expected a time that is not negative")
    return math.exp(-sample_time / smoothing) if smoothing > 0.0 else 0.0


def column_system(column: TwoInertiaParameters, torsion_bar_stiffness: float, sample_time: float) -> LinearSystem:
    """Sampled column from motor torque to the angle of the controlled `shaft`.

    Raises:
        ParameterError: a parameter is not above zero
    """
    if not torsion_bar_stiffness > 0.0:
        raise ParameterError(f"torsion_bar_stiffness is {torsion_bar_stiffness} N m/rad; expected a number above zero")
    for name in ("steering_wheel_inertia", "motor_inertia", "stiffness", "motor_ratio"):
        if not getattr(column, name) > 0.0:
            raise ParameterError(f"{name} is {getattr(column, name)}; expected a number above zero")
    whole = linearise(TwoInertiaColumn, column, (0.0,) * 4, (0.0,) * 3)
    share = column.stiffness / torsion_bar_stiffness
    row = [[0.0, 0.0, 1.0 - share, share / column.motor_ratio]]
    driven = LinearSystem.of(whole.A, row, whole.B[:, :1])
    return sampled(
        LinearSystem(driven.A, driven.B, driven.C, driven.D, whole.states, ("motor_torque",), ("shaft",)), sample_time
    )
