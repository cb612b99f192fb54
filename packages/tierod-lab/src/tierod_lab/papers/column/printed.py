"""The observers of the paper: stationary Kalman filters of the full and the reduced column with random-walk torques."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.maths import present, where
from tierod.methods.estimators.kernels import pack, plus, product, times
from tierod.methods.estimators.observers import stationary_gain
from tierod.methods.estimators.shapes import leaf_values
from tierod.models.column_observation import (
    MotorTorque,
    linear_column,
    observed_column,
    require_fit,
    with_disturbance_states,
)
from tierod.models.linear import LinearSystem
from tierod.models.steering_column import ColumnOutput, ColumnParameters, TwoInertiaColumn, without_gear
from tierod.monitors.driver_torque.design import ColumnTuning, linear_of
from tierod.monitors.driver_torque.observer import ColumnSample
from tierod_lab.methods.stationary import StationaryFilter
from tierod_lab.papers.column.columns import balanced_reduction

COLUMNS = ("full", "series spring", "torsion bar", "printed spring", "balanced", "balanced without feed-through")
"""Columns that an observer of the paper can be built on: the full one, the mechanical reduction with one of its springs
(`without_gear`), or the balanced reduction with the feed-through kept or, as in eq (17), dropped."""

NOISES = replace(ColumnTuning(), hand_torque_walk=2.7, disturbance_torque_walk=1.0)
"""Noises, for which the paper gives no values. These let the torque of the hands follow within some 25 ms, and leave a
false torque of 0.1 N·m where there are no hands, about as much as figure 10 shows."""

_SIZES = {"motor_torque": 1.0, "hand_torque": 2.0, "disturbance_torque": 0.1}
"""Typical inputs for the balancing [N m]: the motor's torque, 2 N·m of hands, the friction of the bench."""


_MEASURED = {"steering_wheel_angle": 1.0, "motor_angle_mechanical": 18.0, "driver_torque": 10.0}
"""Typical outputs for the balancing: a radian of the wheel, as much of the motor, the torque of a turn."""


class PrintedEstimate(NamedTuple):
    """Estimate of the column by an observer of the paper."""

    hand_torque: Annotated[Scalar, "N*m"]
    disturbance_torque: Annotated[Scalar, "N*m"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]
    motor_speed: Annotated[Scalar, "rad/s"]


_SHOWN = (
    "hand_torque",
    "disturbance_torque",
    "steering_wheel_angle",
    "motor_angle",
    "steering_wheel_rate",
    "motor_speed",
)
"""States behind `PrintedEstimate`, by their names in the column models."""


class PrintedState(NamedTuple):
    """Mean of the filter, and the last motor torque."""

    mean: Tree
    motor_torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class PrintedObserver:
    """Torques of hands and disturbance as random walks, from a stationary Kalman filter, as in the paper.

    Args:
        filter: filter of the column, full or reduced
        shown: matrix from the filter's state to the estimate, rows as in `PrintedEstimate`

    It starts at rest with zero angle; missing samples are treated as in `StationaryFilter`.

    Source: Raffone, eqs (8), (12) to (18).
    """

    filter: StationaryFilter
    shown: tuple[tuple[float, ...], ...]
    fed: tuple[float, ...]

    Sample = ColumnSample

    @classmethod
    def of_column(cls, parameters: ColumnParameters, column: str, sample_time: float = 1e-3) -> PrintedObserver:
        """An observer of a column with gear.

        Args:
            column: one of `COLUMNS`
            sample_time: sampling interval [s]
        """
        system = reduced(parameters, column)
        observed = observed_column(system, sample_time, 1, 1)
        require_fit(observed.continuous, f"the column ({column})", sample_time)
        walks = {
            "hand_torque": NOISES.hand_torque_walk**2 * sample_time,
            "disturbance_torque": NOISES.disturbance_torque_walk**2 * sample_time,
        }
        process = [walks.get(name, 0.0) for name in observed.discrete.states]
        found = stationary_gain(observed.discrete, process, NOISES.variances())
        gain = tuple(tuple(map(float, row)) for row in found.filter)
        n = len(process)
        filter_ = StationaryFilter(
            observed.model,
            observed.parameters,
            (0.0,) * n,
            gain,
            pack(found.covariance.tolist()),
            pack(found.innovation_covariance.tolist()),
        )
        rows, fed = _shown(system)
        return cls(filter_, rows, fed)

    def init(self) -> PrintedState:
        return PrintedState(self.filter.init(), 0.0)

    def step(self, state: PrintedState, sample: ColumnSample) -> tuple[PrintedState, PrintedEstimate]:
        measured = self.filter.model.Output(*(getattr(sample, name) for name in ColumnOutput._fields))
        mean, estimate = self.filter.step(state.mean, self.filter.Sample(MotorTorque(state.motor_torque), measured))
        motor = where(present(sample.motor_torque), sample.motor_torque, state.motor_torque)
        values = product(self.shown, leaf_values(estimate.mean))
        shown = [plus(value, times(share, motor)) for value, share in zip(values, self.fed, strict=True)]
        return PrintedState(mean, motor), PrintedEstimate(*shown)


def reduced(parameters: ColumnParameters, column: str) -> LinearSystem:
    """The continuous column of an observer of the paper, with states of wheel and motor as additional outputs."""
    if column not in COLUMNS:
        raise ParameterError(f"there is no column '{column}'{nearest(column, COLUMNS)}; expected {', '.join(COLUMNS)}")
    full = linear_of(parameters)
    if column == "full":
        return _with_states(full)
    if column.startswith("balanced"):
        fed = column == "balanced"
        return balanced_reduction(full, 4, _SIZES, _MEASURED, feed_through=fed, shown=_SHOWN[2:])
    spring = {"series spring": "series", "printed spring": "printed"}.get(column, column)
    return _with_states(linear_column(TwoInertiaColumn, without_gear(parameters, spring)))


def _with_states(system: LinearSystem) -> LinearSystem:
    states = _SHOWN[2:]
    picked = np.array([[float(name == state) for name in system.states] for state in states])
    D = np.vstack([system.D, np.zeros((len(states), system.D.shape[1]))])
    return replace(system, C=np.vstack([system.C, picked]), D=D, outputs=(*system.outputs, *states))


def _shown(system: LinearSystem) -> tuple[tuple[tuple[float, ...], ...], tuple[float, ...]]:
    """Rows that give the reported quantities from the states of the filter and from the motor's torque."""
    extended = with_disturbance_states(system, {"hand_torque": 1, "disturbance_torque": 1})
    rows, fed = [], []
    for name in _SHOWN:
        state = name in extended.states
        at = extended.states.index(name) if state else len(ColumnOutput._fields) + _SHOWN[2:].index(name)
        rows.append(tuple(map(float, np.eye(len(extended.A))[at] if state else extended.C[at])))
        fed.append(0.0 if state else float(extended.D[at, 0]))
    return tuple(rows), tuple(fed)
