"""Columns with the eigenvalues of Raffone's Table 3 to all ten digits, and their reductions to four states.

The table fixes five numbers and the model has eight parameters, so that torsion bar, ratio and inertia of the wheel
are free. S1 has a typical torsion bar of 2.4 N m per degree and is shipped as `column-bench`; S3 has a softer one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.column_observation import linear_column, with_disturbance_states
from tierod.models.linear import LinearSystem, balance, modes
from tierod.models.steering_column import SPRINGS, ColumnParameters, SteeringColumn, TwoInertiaColumn, without_gear
from tierod.vehicles import load

SHIFT = 1.0
"""Decay rate that is added to a column for the balancing, since its angle does not decay and has no Gramian [1/s]; 0.1
to 3 give the same result."""


def balanced_reduction(
    system: LinearSystem,
    order: int,
    input_size: Mapping[str, float],
    output_size: Mapping[str, float],
    feed_through: bool = True,
    shift: float = SHIFT,
    shown: Sequence[str] = (),
) -> LinearSystem:
    """Balanced reduction: the states that are least controllable and observable are at their steady state.

    Args:
        order: states of the reduced system
        input_size, output_size: typical size of inputs and outputs in their unit, by name, as weights; others 1
        feed_through: whether the feed-through D from the removed states is kept; without it the steady state is wrong
        shift: decay rate that is added to all modes for the balancing [1/s]
        shown: states of the full system that are additional outputs, so that an observer estimates them

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
    reached, seen = _root(solve_continuous_lyapunov(A, -B @ B.T)), _root(solve_continuous_lyapunov(A.T, -C.T @ C))
    left, values, right = np.linalg.svd(seen.T @ reached)
    to = left.T @ seen.T / np.sqrt(values)[:, None]
    back = reached @ right.T / np.sqrt(values)
    one, two = slice(order), slice(order, None)
    full, driven = to @ system.A @ back, to @ system.B
    slaved = -np.linalg.solve(full[two, two], full[two, one])
    slaved_input = -np.linalg.solve(full[two, two], driven[two])
    # x = kept z + driven_back u, as far as the states z that are kept determine it.
    kept, driven_back = back[:, one] + back[:, two] @ slaved, back[:, two] @ slaved_input
    rows = [system.states.index(name) for name in shown]
    D = system.D + system.C @ driven_back if feed_through else system.D
    return LinearSystem(
        full[one, one] + full[one, two] @ slaved,
        driven[one] + full[one, two] @ slaved_input,
        np.vstack([system.C @ kept, kept[rows]]),
        np.vstack([D, driven_back[rows]]),
        tuple(f"mode_{k + 1}" for k in range(order)),
        system.inputs,
        (*system.outputs, *shown),
    )


def _root(gramian: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


SETS: Mapping[str, ColumnParameters] = {
    "S1": load("column-bench").parameters_for(ColumnParameters),
    "S2": ColumnParameters(
        steering_wheel_inertia=0.04,
        steering_wheel_damping=0.4215405411,
        torsion_bar_stiffness=120.0,
        motor_ratio=20.0,
        gear_stiffness=5.631209168,
        gear_inertia=5.629395913e-3,
        motor_inertia=6.915951086e-5,
        motor_damping=4.314438831e-4,
    ),
    "S3": ColumnParameters(
        steering_wheel_inertia=0.032,
        steering_wheel_damping=0.2849700635,
        torsion_bar_stiffness=80.0,
        motor_ratio=12.0,
        gear_stiffness=7.453333774,
        gear_inertia=2.635128442e-3,
        motor_inertia=1.134302023e-4,
        motor_damping=8.928757445e-4,
    ),
}
"""Parameter sets by name."""

EIGENVALUES = (
    -0.491074732452 + 706.750702094704j,
    -0.491074732452 - 706.750702094704j,
    -0.000000000001 + 0.0j,
    -8.114907494361 + 0.0j,
    -3.839922431729 + 79.657898579634j,
    -3.839922431729 - 79.657898579634j,
)
"""Eigenvalues of the column in Table 3 of the paper [1/s]."""

UNKNOWN_TORQUES = ("hand_torque", "disturbance_torque")  # Unmeasured inputs, which an observer estimates as states


def extended(system: LinearSystem, disturbances: Sequence[str] = UNKNOWN_TORQUES) -> LinearSystem:
    """The system with some of its inputs as constant states, in this order after the others.

    Source: Raffone, eq (8), where the torques of driver and disturbance become states.
    """
    return with_disturbance_states(system, dict.fromkeys(disturbances, 1))


def reduced_columns(parameters: ColumnParameters) -> Mapping[str, LinearSystem]:
    """The column with four states by every method of reduction, by name.

    A tenth of a degree of the steering wheel and a newton metre of the bar are the units for balancing: with a larger
    angle the slow coasting of the column weighs less than the resonance of the gear, and is removed first.
    """
    angle, ratio = math.radians(0.1), parameters.motor_ratio
    sizes = {"steering_wheel_angle": angle, "motor_angle_mechanical": ratio * angle, "driver_torque": 1.0}
    whole = linear_column(SteeringColumn, parameters)
    found = {f"mechanical, {each}": linear_column(TwoInertiaColumn, without_gear(parameters, each)) for each in SPRINGS}
    for name, kept in (("balanced", True), ("balanced, without D", False)):
        found[name] = balanced_reduction(whole, 4, {"hand_torque": ratio}, sizes, kept)
    return found


def vibrations(system: LinearSystem) -> list[complex]:
    """Eigenvalues in rising magnitude [1/s], of each complex pair the one with positive imaginary part."""
    values = [mode.eigenvalue for mode in modes(system)]
    return sorted((value for value in values if value.imag > -1e-9 * max(abs(value), 1.0)), key=abs)


def gain_of_bar(system: LinearSystem, frequency: np.ndarray, sample_time: float | None = None) -> np.ndarray:
    """Complex gain C (j 2 pi f - A)^-1 B + D from the motor's torque to that of the bar, at frequencies [Hz].

    Args:
        sample_time: sampling interval of a discrete system; None for a continuous one [s]
    """
    at = 2j * math.pi * frequency
    at = at if sample_time is None else np.exp(at * sample_time)
    row, column = system.outputs.index("driver_torque"), system.inputs.index("motor_torque")
    scale = balance(system.A)
    pencils = at[:, None, None] * np.eye(len(scale)) - system.A * scale / scale[:, None]
    driven = np.broadcast_to((system.B[:, column] / scale).astype(complex)[:, None], (len(at), len(scale), 1))
    inner = np.linalg.solve(pencils, driven)[:, :, 0]
    return np.asarray(inner @ (system.C[row] * scale) + system.D[row, column])
