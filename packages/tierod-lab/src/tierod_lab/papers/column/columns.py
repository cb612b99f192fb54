"""Columns with the eigenvalues of Raffone's Table 3 to all ten digits, and their reductions to four states.

The table fixes five numbers and the model has eight parameters, so that torsion bar, ratio and inertia of the wheel
are free. S1 has a typical torsion bar of 2.4 N m per degree and is shipped as `column-bench`; S3 has a softer one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from tierod.models.column_observation import linear_column, with_disturbance_states
from tierod.models.linear import LinearSystem, modes
from tierod.models.steering_column import SPRINGS, ColumnParameters, SteeringColumn, TwoInertiaColumn, without_gear
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import ColumnBench
from tierod_lab.papers.column.model_reduction import Reduction, balanced_reduction, modal_reduction

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


def member(stiffness: float, motor_ratio: float, steering_wheel_inertia: float) -> ColumnParameters:
    """Another column with the eigenvalues of Table 3, which fixes five ratios of its parameters.

    Args:
        stiffness: stiffness of the torsion bar over inertia of the steering wheel, 500 to 3150 or 3650 to 6000; in
            between a damping would be negative [1/s^2]
        motor_ratio: turns of the motor per turn of the shaft
        steering_wheel_inertia: inertia of the steering wheel [kg m^2]
    """
    wheel_damping, motor_damping, motor_stiffness, gear_bar, gear_motor = _fixed_by_the_table(stiffness)
    bar = stiffness * steering_wheel_inertia
    gear_inertia = bar / gear_bar
    gear_stiffness = gear_motor * gear_inertia / motor_ratio**2
    motor_inertia = gear_stiffness / motor_stiffness
    return ColumnParameters(
        steering_wheel_inertia,
        wheel_damping * steering_wheel_inertia,
        bar,
        motor_ratio,
        gear_stiffness,
        gear_inertia,
        motor_inertia,
        motor_damping * motor_inertia,
    )


@cache
def _fixed_by_the_table(stiffness: float) -> tuple[float, ...]:
    from scipy.optimize import root

    # Steps of at most 50/s^2 keep the start of the root finder close to the next solution.
    first, *found = _ratios(SETS["S3"] if stiffness < 3400.0 else SETS["S1"])
    for step in np.linspace(first, stiffness, 2 + int(abs(stiffness - first) / 50.0)):
        found = root(_mismatch, found, args=(step,), tol=1e-14).x
    return tuple(map(float, found))


def _ratios(p: ColumnParameters) -> np.ndarray:
    return np.array(
        [
            p.torsion_bar_stiffness / p.steering_wheel_inertia,
            p.steering_wheel_damping / p.steering_wheel_inertia,
            p.motor_damping / p.motor_inertia,
            p.gear_stiffness / p.motor_inertia,
            p.torsion_bar_stiffness / p.gear_inertia,
            p.gear_stiffness * p.motor_ratio**2 / p.gear_inertia,
        ]
    )


def _mismatch(ratios: np.ndarray, stiffness: float) -> np.ndarray:
    """Relative deviation of a column's characteristic polynomial from that of the table, motor angle at the shaft."""
    wheel_damping, motor_damping, motor, bar, gear = ratios
    A = np.zeros((6, 6))
    A[3:, :3] = np.eye(3)
    A[0, [0, 3, 5]] = -wheel_damping, -stiffness, stiffness
    A[1, [1, 4, 5]] = -motor_damping, -motor, motor
    A[2, 3:] = bar, gear, -(bar + gear)
    # The last coefficient is left out: it is zero by the eigenvalue at zero.
    return np.poly(A)[1:6].real / np.poly(np.array(EIGENVALUES))[1:6].real - 1.0


SCATTERED = (
    "wheel_inertia",
    "wheel_damping",
    "bar_stiffness",
    "gear_stiffness",
    "gear_inertia",
    "motor_inertia",
    "motor_damping",
)
"""Parameters of the bench that are made wrong for the observer of the hands, with the gain of its torque sensor."""


def bench_of(p: ColumnParameters) -> ColumnBench:
    """The bench with the parameters of a column."""
    return ColumnBench(
        wheel_inertia=p.steering_wheel_inertia,
        wheel_damping=p.steering_wheel_damping,
        bar_stiffness=p.torsion_bar_stiffness,
        gear_ratio=p.motor_ratio,
        gear_stiffness=p.gear_stiffness,
        gear_inertia=p.gear_inertia,
        motor_inertia=p.motor_inertia,
        motor_damping=p.motor_damping,
    )


UNKNOWN_TORQUES = ("hand_torque", "disturbance_torque")  # Unmeasured inputs, which an observer estimates as states
ANGLE, TORQUE = math.radians(0.1), 1.0
"""Units for balancing a column: a tenth of a degree of the steering wheel [rad], a newton metre of the bar [N*m].

With a larger angle the slow coasting of the column weighs less than the resonance of the gear, and is removed first."""


def extended(system: LinearSystem, disturbances: Sequence[str] = UNKNOWN_TORQUES) -> LinearSystem:
    """The system with some of its inputs as constant states, in this order after the others.

    Source: Raffone, eq (8), where the torques of driver and disturbance become states.
    """
    return with_disturbance_states(system, dict.fromkeys(disturbances, 1))


def balanced_column(parameters: ColumnParameters, order: int = 4, *, feed_through: bool = True) -> Reduction:
    """The column with fewer states by balanced singular perturbation; torques have equal weight wherever they act.

    Args:
        feed_through: whether the feed-through D from torques to outputs is kept; Raffone, (17) drops it

    Source: Raffone, eqs (14) to (16); the free angle, which has no Gramian, is separated from the rest.
    """
    inputs, outputs = balancing_sizes(parameters.motor_ratio)
    column = linear_column(SteeringColumn, parameters)
    return balanced_reduction(column, order, feed_through=feed_through, input_size=inputs, output_size=outputs)


def balancing_sizes(
    ratio: float, angle: float = ANGLE, torque: float = TORQUE
) -> tuple[dict[str, float], dict[str, float]]:
    """Typical sizes of inputs and outputs of a column for its balanced reduction.

    Args:
        ratio: turns of the motor per turn of the shaft [-]
        angle: at the steering wheel [rad]
        torque: of the bar [N*m]

    Returns:
        sizes of the inputs (1 where not given), and of the outputs, by name
    """
    outputs = {"steering_wheel_angle": angle, "motor_angle_mechanical": ratio * angle, "driver_torque": torque}
    return {"hand_torque": ratio}, outputs


def reduced_columns(parameters: ColumnParameters) -> Mapping[str, LinearSystem | Reduction]:
    """The column with four states by every method of reduction, by name."""
    mechanical = {
        f"mechanical, {spring}": linear_column(TwoInertiaColumn, without_gear(parameters, spring)) for spring in SPRINGS
    }
    return mechanical | {
        "balanced": balanced_column(parameters),
        "balanced, without D": balanced_column(parameters, feed_through=False),
        "modal": modal_reduction(linear_column(SteeringColumn, parameters), 4),
    }


def vibrations(system: LinearSystem) -> list[complex]:
    """Eigenvalues in rising magnitude [1/s], of each complex pair the one with positive imaginary part."""
    values = [mode.eigenvalue for mode in modes(system)]
    return sorted((value for value in values if value.imag > -1e-9 * max(abs(value), 1.0)), key=abs)


def damping_ratio(eigenvalue: complex) -> float:
    """Damping ratio of a mode [-]; NaN for an eigenvalue at zero."""
    return -eigenvalue.real / abs(eigenvalue) if abs(eigenvalue) > 1e-6 else float("nan")
