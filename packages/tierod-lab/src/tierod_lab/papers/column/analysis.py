"""Analysis of a steering column: its modes, its observability by its sensors, and its reduction to fewer states."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.methods.analysis.fitness import require_fit
from tierod.models.column_observation import linear_column
from tierod.models.linear import LinearSystem
from tierod.models.modes import modes
from tierod.models.steering_column import SPRINGS, ColumnParameters, SteeringColumn, TwoInertiaColumn, without_gear
from tierod_lab.papers.column.frequency_response import frequency_response
from tierod_lab.papers.column.model_reduction import Reduction, balanced_reduction, modal_reduction
from tierod_lab.papers.column.output_subsets import Sampling, Shown, extended, output_subsets, shown_by

UNKNOWN_TORQUES = ("hand_torque", "disturbance_torque")
"""Unmeasured inputs, which an observer estimates as states."""

SAMPLING = Sampling(
    {"steering_wheel_angle": math.radians(0.05), "motor_angle_mechanical": math.radians(0.2), "driver_torque": 0.02},
    sample_time=1e-3,
    duration=1.0,
)
"""Assumed noise of typical sensors of a column, over one second at the rate of its control unit."""

ANGLE, TORQUE = math.radians(0.1), 1.0
"""Units for balancing a column: a tenth of a degree of the steering wheel [rad], a newton metre of the bar [N*m].
With a larger angle the slow coasting of the column weighs less than the resonance of the gear, and is removed first."""

HEARD = (1.0, 10.0, 30.0)
"""Frequencies up to which a reduced column is compared with the full one [Hz]: hands, position control, resonance."""


@dataclass(frozen=True, eq=False)
class ReducedColumn:
    """A column reduced to four states.

    Args:
        name: of the method of reduction
        system: with the inputs and outputs of the full column
        errors: largest relative error of the gain from the motor to the bar up to each frequency of `HEARD`
        extended: observability of its states and of the unknown torques
        reduction: Hankel values and error bound; None for a mechanical reduction
    """

    name: str
    system: LinearSystem
    errors: tuple[float, ...]
    extended: Shown
    reduction: Reduction | None = None


@dataclass(frozen=True, eq=False)
class ColumnAnalysis:
    """Results of the analysis of a column from its parameters alone.

    Args:
        system: linear, without friction
        extended: with the unknown torques as states
        subsets: observability of the state by every choice of outputs
        extended_subsets: observability of the state and the unknown torques by every choice of outputs
        reductions: to four states
    """

    system: LinearSystem
    extended: LinearSystem
    subsets: tuple[Shown, ...]
    extended_subsets: tuple[Shown, ...]
    reductions: tuple[ReducedColumn, ...]


def analyse_column(
    parameters: ColumnParameters, what: str = "the column", sampling: Sampling = SAMPLING
) -> ColumnAnalysis:
    """Modes, observability and reductions of a column.

    Args:
        parameters: of the column
        what: name of the column in messages
        sampling: noise of the outputs, sample time, duration

    Raises:
        ParameterError: parameters of an unstable column
    """
    system = linear_column(SteeringColumn, parameters)
    require_fit(system, what, stable="marginal", observable=False)
    larger = extended(system, UNKNOWN_TORQUES)
    return ColumnAnalysis(
        system,
        larger,
        tuple(output_subsets(system, sampling)),
        tuple(output_subsets(larger, sampling)),
        tuple(_compared(system, parameters, sampling)),
    )


def balanced_column(parameters: ColumnParameters, order: int = 4, *, feed_through: bool = True) -> Reduction:
    """The column with fewer states by balanced singular perturbation; torques have equal weight wherever they act.

    Args:
        parameters: of the column
        order: number of states of the reduced column
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


def _compared(system: LinearSystem, parameters: ColumnParameters, sampling: Sampling) -> list[ReducedColumn]:
    compared = []
    for name, way in reduced_columns(parameters).items():
        small, reduction = (way.system, way) if isinstance(way, Reduction) else (way, None)
        shown = shown_by(extended(small, UNKNOWN_TORQUES), small.outputs, sampling)
        compared.append(ReducedColumn(name, small, _errors(system, small), shown, reduction))
    return compared


def _errors(system: LinearSystem, small: LinearSystem) -> tuple[float, ...]:
    frequency = np.geomspace(0.05, HEARD[-1], 600)
    bar = [_from_motor(each, frequency) for each in (system, small)]
    error = np.abs(bar[1] - bar[0]) / np.abs(bar[0])
    return tuple(float(error[frequency <= 1.0001 * limit].max()) for limit in HEARD)


def _from_motor(system: LinearSystem, frequency: np.ndarray) -> np.ndarray:
    motor = replace(system, B=system.B[:, :1], D=system.D[:, :1], inputs=system.inputs[:1])
    return frequency_response(motor, frequency).of("driver_torque", system.inputs[0])
