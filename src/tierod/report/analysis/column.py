"""Analysis of a steering column in tables and charts."""

from __future__ import annotations

import math
from typing import Any

from tierod.core.content import Chart, Heading, Table
from tierod.core.recording import Recording
from tierod.core.shown import shown
from tierod.methods.analysis.bode import DRAWN, measured_chart, reduced_chart
from tierod.methods.analysis.column import (
    HEARD,
    SAMPLING,
    UNKNOWN_TORQUES,
    ColumnAnalysis,
    ReducedColumn,
    analyse_column,
    damping_ratio,
    vibrations,
)
from tierod.methods.analysis.output_subsets import Shown, disagreements
from tierod.models.steering_column import ColumnParameters
from tierod.report.analysis.analysis import Analysis
from tierod.report.analysis.column_measured import Measured, measured_column
from tierod.report.display import number, words
from tierod.vehicles import Vehicle

_SHORT = {
    "steering_wheel_angle": "wheel angle",
    "motor_angle_mechanical": "motor angle",
    "driver_torque": "bar torque",
}
_METHODS = ("staircase", "PBH", "scaled matrix", "sampled matrix", "unscaled matrix")


def analyse(vehicle: Vehicle, recording: Recording | None) -> Analysis:
    """Modes, observability, reductions and frequency response of the column of a vehicle.

    Args:
        vehicle: with the parameters of a column, see `ColumnParameters`
        recording: of the column on a test bench, hands off, with motor torque and sensors; None for none

    Raises:
        ParameterError: parameters are missing or describe an unstable column
        InputError: the recording lacks a signal, or the motor torque is constant
    """
    parameters = vehicle.parameters_for(ColumnParameters)
    found = analyse_column(parameters, f"the column of '{vehicle.name}'")
    measured = None if recording is None else measured_column(recording, found.system)
    items = [*_modes(found), *_observability(found), *_reductions(found, measured)]
    items += _measured_items(measured) if measured else []
    return Analysis(
        f"Steering column of {vehicle.name}",
        _summary(found),
        items,
        _document(found, measured),
        measured.remarks if measured else (),
        measured is None or measured.fits,
    )


def _summary(found: ColumnAnalysis) -> tuple[str, ...]:
    pairs = [value for value in vibrations(found.system) if abs(value.imag) > 1e-6 * abs(value)]
    rings = " and ".join(f"{abs(value) / math.tau:.3g} Hz" for value in pairs)
    hidden = [_outputs(row.outputs) for row in found.subsets if not row.exact.complete]
    both = found.extended_subsets[-1]
    return (
        f"The column rings at {rings}. "
        + (
            f"Its state is not observable with {'; '.join(hidden)} alone. "
            if hidden
            else "Its state is observable with any one sensor. "
        )
        + f"With the torques of hands and disturbance as states, all sensors together observe {both.exact.rank} of "
        f"{len(found.extended.states)} states"
        + (
            f"; the rank of the unscaled observability matrix is {both.unscaled.rank}, an artefact of double precision."
            if both.unscaled.rank != both.exact.rank
            else "."
        ),
    )


def _modes(found: ColumnAnalysis) -> list[Heading | Table | Chart]:
    rows = []
    for value in vibrations(found.system):
        ringing = abs(value.imag) > 1e-9 * max(abs(value), 1.0)
        rows.append(
            (
                _eigenvalue(value),
                number(abs(value) / math.tau, 4) if ringing else "",
                number(damping_ratio(value), 3) if ringing else "",
                number(-1.0 / value.real, 3) if value.real < -1e-6 else "",
            )
        )
    note = "Without friction, hands off. An eigenvalue at zero is the free turn of the whole column."
    return [
        Heading("Modes"),
        Table(
            "Eigenvalues of the linear column",
            ("eigenvalue (1/s)", "frequency (Hz)", "damping ratio", "decay (s)"),
            tuple(rows),
            note,
        ),
    ]


def _observability(found: ColumnAnalysis) -> list[Heading | Table | Chart]:
    text = (
        "Number of states that are observable with each choice of sensors. The staircase (tolerance 1e-9) and the "
        "test of Popov, Belevitch "
        "and Hautus (1e-7) work on the scaled system; the rank of the observability matrix is taken to the default "
        "tolerance of MATLAB, of the scaled system, of the system sampled every "
        f"{1e3 * SAMPLING.sample_time:g} ms, and unscaled. Condition of the Gramian over {SAMPLING.duration:g} s, each "
        "state in its best unit.",
        "The last columns are the least standard deviation with which any unbiased estimator can estimate the "
        f"present state after {SAMPLING.duration:g} s (Cramer and Rao), if the model is right, without disturbances, "
        "and with white sensor noise of " + _noises() + " (assumed).",
    )
    return [
        Heading("Observability", text),
        _table(
            "States observable with a choice of sensors",
            found.subsets,
            len(found.system.states),
            ("steering_wheel_rate",),
        ),
        _table(
            "The same with the torques of hands and disturbance as states",
            found.extended_subsets,
            len(found.extended.states),
            ("steering_wheel_rate", *UNKNOWN_TORQUES),
        ),
    ]


def _table(title: str, rows: tuple[Shown, ...], count: int, bounds: tuple[str, ...]) -> Table:
    units = {"steering_wheel_rate": "rad/s", "hand_torque": "N*m", "disturbance_torque": "N*m"}
    labels = tuple(f"{words(name).lower()} ({shown(units[name])[1]})" for name in bounds)
    cells = tuple(
        (
            _outputs(row.outputs),
            *(str(row.ranks[method]) for method in _METHODS),
            _large(row.condition),
            *(_large(row.bound[name] * shown(units[name])[0]) for name in bounds),
        )
        for row in rows
    )
    header = ("sensors", *(method.removesuffix(" matrix") for method in _METHODS), "Gramian", *labels)
    return Table(f"{title}, of {count}", header, cells, _note(rows))


def _note(rows: tuple[Shown, ...]) -> str:
    """Disagreements between the methods with their causes, and the hidden states, with short sensor names."""
    parts = disagreements(rows, _outputs) or ["All methods agree."]
    hidden = [row for row in rows if not row.exact.complete]
    parts += [f"{_outputs(row.outputs).capitalize()} alone: {row.exact.sentence()}." for row in hidden]
    return " ".join(parts).replace("_", " ")


def _reductions(found: ColumnAnalysis, measured: Measured | None) -> list[Heading | Table | Chart]:
    text = (
        "Four states instead of six. Mechanical: the gear turns with the motor, and one spring is left: bar and "
        "gear in series, the bar alone, or as printed. Balanced: the least controllable and observable states follow "
        "the others at once; D is the direct feedthrough from torques to sensors that results. Modal: the slowest "
        "eigenvalues are kept.",
    )
    header = (
        "reduction",
        "frequency (Hz)",
        "damping ratio",
        "coasting (1/s)",
        *(f"error to {limit:g}\N{NO-BREAK SPACE}Hz\N{NO-BREAK SPACE}(%)" for limit in HEARD),
        "largest D",
        "rank with torques",
        "Gramian",
    )
    note = "Error of the gain from the motor's torque to that of the bar. Rank of the six states with both torques."
    cells = tuple(_reduced_cells(row) for row in found.reductions)
    return [
        Heading("Reductions", text),
        Table("Columns of four states", header, cells, note),
        reduced_chart(
            "bode-reduced",
            "The column and its reductions",
            {"whole column": found.system} | {row.name: row.system for row in found.reductions if row.name in DRAWN},
            measured.responses.get("driver_torque") if measured else None,
        ),
    ]


def _measured_items(measured: Measured) -> list[Heading | Table | Chart]:
    """Measured and computed response of every sensor, with coherence, and their differences."""
    charts = [
        measured_chart(
            f"measured-{name.replace('_', '-')}", name, response.frequency, measured.model[name], {"measured": response}
        )
        for name, response in measured.responses.items()
    ]
    return [Heading("Measured and computed"), measured.table(), *charts]


def _reduced_cells(row: ReducedColumn) -> tuple[str, ...]:
    values = vibrations(row.system)
    pair = max(values, key=lambda value: abs(value.imag))
    slow = [value.real for value in values if abs(value.imag) < 1e-9 * abs(pair) and value.real < -1e-6 * abs(pair)]
    ranks = row.extended.ranks
    return (
        row.name,
        f"{abs(pair) / math.tau:.4f}",
        f"{damping_ratio(pair):.4f}",
        ", ".join(f"{value:.4f}" for value in slow),
        *(f"{100.0 * error:.2g}" for error in row.errors),
        number(float(abs(row.system.D).max()), 3),
        f"{ranks['staircase']}" + ("" if len(set(ranks.values())) == 1 else f" (unscaled {ranks['unscaled matrix']})"),
        _large(row.extended.condition),
    )


def _document(found: ColumnAnalysis, measured: Measured | None) -> dict[str, Any]:
    document: dict[str, Any] = {
        "eigenvalues": [_mode(value) for value in vibrations(found.system)],
        "sampling": {"noise": dict(SAMPLING.noise), "sample_time": SAMPLING.sample_time, "duration": SAMPLING.duration},
        "disagreements": disagreements(found.subsets),
        "disagreements_with_torques": disagreements(found.extended_subsets),
        "observability": [_row(row) for row in found.subsets],
        "observability_with_torques": [_row(row) for row in found.extended_subsets],
        "reductions": [
            {
                "name": row.name,
                "eigenvalues": [_mode(value) for value in vibrations(row.system)],
                "errors": {f"{limit:g}": error for limit, error in zip(HEARD, row.errors, strict=True)},
                "feed_through": row.system.D.tolist(),
                "hankel_values": row.reduction.hankel.tolist() if row.reduction else [],
                "error_bound": row.reduction.error_bound if row.reduction else None,
                "ranks_with_torques": row.extended.ranks,
            }
            for row in found.reductions
        ],
    }
    return document | ({"measured": measured.document()} if measured else {})


def _mode(value: complex) -> dict[str, float]:
    ringing = abs(value.imag) > 1e-9 * max(abs(value), 1.0)
    return {
        "real": value.real,
        "imaginary": value.imag if ringing else 0.0,
        "frequency": abs(value) / math.tau if ringing else 0.0,
        "damping_ratio": damping_ratio(value),
    }


def _row(row: Shown) -> dict[str, Any]:
    return {
        "outputs": list(row.outputs),
        "states": list(row.exact.states),
        "ranks": row.ranks,
        "tolerance": row.exact.tolerance,
        "hidden": "" if row.exact.complete else row.exact.sentence(),
        "unscaled_tolerance": row.unscaled.tolerance,
        "unscaled_singular_values": row.unscaled.singular_values.tolist(),
        "gramian_condition": row.condition,
        "bounds": {name: float(value) for name, value in zip(row.bound.names, row.bound.end, strict=True)},
    }


def _outputs(names: tuple[str, ...]) -> str:
    return " + ".join(_SHORT[name] for name in names)


def _noises() -> str:
    units = {"driver_torque": "N*m"}
    parts = []
    for name, noise in SAMPLING.noise.items():
        factor, label = shown(units.get(name, "rad"))
        parts.append(f"{noise * factor:.2g}\N{NO-BREAK SPACE}{label} ({_outputs((name,))})")
    return ", ".join(parts)


def _large(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:.2g}"


def _eigenvalue(value: complex) -> str:
    if abs(value) < 1e-6:
        return "0"
    real = abs(value.imag) < 1e-9 * abs(value)
    return f"{value.real:.6g}" + ("" if real else f" ± {value.imag:.6g}i")
