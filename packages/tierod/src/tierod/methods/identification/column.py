"""Identification of a column from recordings of a bench, and common mistakes in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.methods.identification.bench_recording import (
    OUTPUTS,
    BenchParameters,
    BenchRecording,
    SampledColumn,
    bench_recording,
)
from tierod.methods.identification.column_fit import (
    CURES,
    DEFAULT_FREE,
    DESIGN,
    FRICTION,
    WHEEL_SIDE,
    ColumnFit,
    Fitted,
    is_unexplained,
    known_free,
    search_of,
)
from tierod.methods.identification.column_misfit import refuse_slips
from tierod.methods.identification.experiment import Estimate, Found, Whiteness, normalised_error, whiteness
from tierod.methods.identification.maximum_likelihood import Simulation
from tierod.physics.friction import dahl_update


@dataclass(frozen=True)
class LeftOut:
    """Cross-validation by an experiment that is left out of the fit."""

    name: str
    values: Mapping[str, float]  # of the parameters from all other experiments, by name
    # of the simulated outputs of the experiment, over the standard deviations of the measured ones, by name
    errors: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Shown:
    """An experiment with its simulation, for charts."""

    name: str
    locked: bool
    time: np.ndarray  # [s]
    motor_torque: np.ndarray  # [N m]
    measured: np.ndarray  # measured, simulated: outputs, (n, outputs)
    simulated: np.ndarray
    residuals: np.ndarray  # standardised innovations, (n, outputs)
    friction: np.ndarray  # simulated friction at the motor [N m]
    errors: Mapping[str, float]  # of the simulated outputs, over the standard deviations of the measured ones, by name


@dataclass(frozen=True, eq=False)
class ColumnIdentification:
    found: tuple[Found, ...]  # identified parameters, in the order of the vehicle file
    estimate: Estimate  # maximum-likelihood estimate of the free parameters and the nuisance parameters of the bench
    left_out: tuple[LeftOut, ...]  # cross-validation, one entry per experiment
    shown: tuple[Shown, ...]
    whiteness: Mapping[str, Whiteness]
    remarks: tuple[str, ...]  # sentences on defects of recordings and fit
    explained: bool = True  # whether the model explains the recordings

    @property
    def doubt(self) -> str:
        """Reason why the values should not be used; empty if they may be used."""
        if not self.explained:
            return "the model does not explain these recordings"
        return "" if self.estimate.converged else "the search did not converge"


_PARTS = 3  # Number of parts of a single recording, each of which is left out once
Progress = Callable[[float], None]


def identify_column(
    parameters: BenchParameters,
    recordings: Mapping[str, Recording],
    free: Sequence[str] = (),
    deviations: Mapping[str, float | None] | None = None,
    progress: Progress = lambda share: None,
) -> ColumnIdentification:
    """Parameters of a column from recordings of a bench.

    Parameters of the steering wheel come from a regression with instrumental variables, which needs no model of motor
    and friction; all others from maximum likelihood with an unrecorded torque at the motor.

    Args: free: parameters to be identified; damping and friction by default.
    """
    wanted = tuple(free) or DEFAULT_FREE
    _refuse_unknown(wanted)
    whole_rows = [bench_recording(name, each, parameters) for name, each in recordings.items()]
    for each in whole_rows:
        refuse_slips(each, search_of(parameters, FRICTION, [each], widened=True))
    rows, remarks = _parted(whole_rows, parameters), [remark for each in whole_rows for remark in each.remarks]
    unidentified = [name for name in wanted if name in WHEEL_SIDE] if all(each.locked for each in rows) else []
    if unidentified and free:
        raise InputError(
            f"with the wheel locked {' and '.join(unidentified)} is not identifiable; record {CURES[unidentified[0]]}"
        )
    if unidentified:
        remarks.append(
            f"{' and '.join(unidentified)} keeps its value: the wheel was locked; record {CURES[unidentified[0]]}"
        )
        wanted = _unlocked(wanted)
    progress(0.05)
    fit = ColumnFit(parameters, wanted)
    whole = fit.run(rows, lambda share: progress(0.05 + 0.5 * share))
    left_out = []
    for number, row in enumerate(rows):
        others = [each for each in rows if each is not row]
        if others:
            left_out.append(_without(fit, whole, others, row))
        progress(0.55 + 0.45 * (number + 1) / len(rows))
    shown = tuple(_shown(row, whole.parameters, r) for row, r in zip(rows, whole.estimate.residuals, strict=True))
    return ColumnIdentification(
        tuple(whole.found(deviations or {})),
        whole.estimate,
        tuple(left_out),
        shown,
        {name: whiteness([r[:, k] for r in whole.estimate.residuals]) for k, name in enumerate(OUTPUTS)},
        (*remarks, *whole.remarks),
        not is_unexplained(whole.estimate, [row.experiment for row in rows]),
    )


def _refuse_unknown(wanted: Sequence[str]) -> None:
    for name in wanted:
        if name not in known_free():
            hint = f"{name} is counted, not measured" if name in DESIGN else nearest(name, known_free()).lstrip("; ")
            raise ParameterError(f"'{name}' cannot be identified: {hint}")


def _parted(rows: list[BenchRecording], parameters: BenchParameters) -> list[BenchRecording]:
    """A single recording cut into parts, for the cross-validation; several recordings unchanged."""
    if len(rows) > 1:
        return rows
    row, count = rows[0], len(rows[0].time)
    edges = np.linspace(0, count, _PARTS + 1).astype(int)
    return [
        row.part(f"{row.experiment.name}, {row.time[a]:.3g} to {row.time[b - 1]:.3g} s", a, b, parameters)
        for a, b in pairwise(edges)
    ]


def _without(fit: ColumnFit, whole: Fitted, others: Sequence[BenchRecording], row: BenchRecording) -> LeftOut:
    """Cross-validation: fit of the other experiments, compared with the one that is left out."""
    only = fit if any(not each.locked for each in others) else ColumnFit(fit.parameters, _unlocked(fit.wanted))
    again = only.run(others, near=whole)
    values = {each.name: each.value for each in again.found({})}
    return LeftOut(row.experiment.name, values, _shown(row, again.parameters).errors)


def _unlocked(wanted: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in wanted if name not in WHEEL_SIDE)


def _shown(row: BenchRecording, parameters: BenchParameters, residuals: np.ndarray | None = None) -> Shown:
    experiment = row.experiment
    block = Simulation(SampledColumn, replace(parameters, **experiment.setting), experiment.initial_mean)
    simulated = scan(block, experiment.inputs).values[:, : len(OUTPUTS)]
    errors = {
        name: normalised_error(simulated[:, k], experiment.measured[:, k])
        for k, name in enumerate(OUTPUTS)
        if not (row.locked and name == "steering_wheel_angle")
    }
    friction = _friction(simulated[:, 1], parameters)
    left = np.full_like(simulated, np.nan) if residuals is None else residuals
    torque = experiment.inputs[:, 0]
    return Shown(experiment.name, row.locked, row.time, torque, experiment.measured, simulated, left, friction, errors)


def _friction(angle: np.ndarray, parameters: BenchParameters) -> np.ndarray:
    """Dahl friction [N m] along a sequence of motor angles [rad]."""
    share, out = 0.0, np.zeros(len(angle))
    reach = parameters.motor_friction / parameters.motor_friction_stiffness
    for k, turned in enumerate(np.diff(angle).tolist()):
        share = dahl_update(share, turned, reach)
        out[k + 1] = share
    return parameters.motor_friction * out
