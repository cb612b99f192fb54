"""Reduction of the column to four states: mechanical and balanced, Figure 7 of the paper, and their errors."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, at_most, between, exactly
from tierod.core.content import Heading, Item, Table
from tierod.models.linear import LinearSystem
from tierod_lab.papers.column.analysis import (
    HEARD,
    SAMPLING,
    ColumnAnalysis,
    ReducedColumn,
    analyse_column,
    balanced_column,
    balancing_sizes,
    damping_ratio,
    vibrations,
)
from tierod_lab.papers.column.bode import DRAWN, reduced_chart
from tierod_lab.papers.column.frequency_response import largest_difference
from tierod_lab.papers.column.model_reduction import balanced_reduction
from tierod_lab.papers.column.parameter_sets import EIGENVALUES, SETS
from tierod_lab.studies.effort import Effort

KEPT = EIGENVALUES[2:]
"""Eigenvalues of the column without the mode of its gear [1/s]."""

_FREQUENCY = np.geomspace(1e-2, 1e3, 2000)


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Four states instead of six",
        (
            "The paper leaves out the gear: mechanically, by letting it turn with the motor (9) to (13), or by "
            "balancing the column and letting its weakest states follow the others (14) to (16). Two springs one after "
            "the other are softer than either; (11) adds them. The free turn of the column has no Gramian and is "
            "parted from the rest before balancing; inputs and outputs are scaled, torques alike wherever they act.",
        ),
    )
    found = analyse_column(SETS["S1"])
    yield _table(found)
    yield reduced_chart(
        "column-figure-7",
        "Reduced columns compared (Figure 7)",
        {"whole column": found.system} | {row.name: row.system for row in found.reductions if row.name in DRAWN},
    )
    yield from _mechanical(found)
    yield from _balanced(found)
    yield _ranks(found)
    yield _weights(found.system)


def _table(found: ColumnAnalysis) -> Table:
    header = (
        "reduction",
        "eigenvalues (1/s)",
        "damping",
        *(f"error to {limit:g} Hz (%)" for limit in HEARD),
        "largest D",
        "rank with torques",
    )
    return Table(
        "Columns of four states, set S1",
        header,
        tuple(_cells(row) for row in found.reductions),
        "Error of the gain from the motor's torque to that of the bar. D in units of inputs and outputs. Rank of the "
        "observability matrix, unscaled, of six states with the torques of driver and disturbance.",
    )


def _cells(row: ReducedColumn) -> tuple[str, ...]:
    free, slow, pair = vibrations(row.system)
    return (
        row.name,
        f"{abs(free):.0f}, {slow.real:.4f}, {pair.real:.4f} ± {pair.imag:.4f}i",
        f"{damping_ratio(pair):.4f}",
        *(f"{100.0 * error:.2g}" for error in row.errors),
        f"{abs(row.system.D).max():.4f}",
        str(row.extended.unscaled.rank),
    )


def _mechanical(found: ColumnAnalysis) -> Iterator[Item]:
    exact = abs(KEPT[2])
    pairs = {row.name: abs(vibrations(row.system)[2]) for row in found.reductions}
    for spring, goal, what in (
        ("series", at_most(1.0), "bar and gear in series"),
        ("torsion bar", at_most(3.0), "the bar alone, which (9) demands"),
        ("printed", at_most(3.0), "their sum, as (11) prints"),
    ):
        yield Claim(
            f"reduction.frequency-{spring.replace(' ', '-')}",
            f"Without its gear the column rings as fast as with it, the spring being {what}.",
            "Raffone, section 4.1" if spring == "printed" else "tierod",
            None,
            100.0 * abs(pairs[f"mechanical, {spring}"] / exact - 1.0),
            goal,
            "%",
            f"{pairs[f'mechanical, {spring}'] / math.tau:.3f} Hz against {exact / math.tau:.3f} Hz. "
            + (
                "The sum is harmless only because the stiffness of the gear is given at the motor's shaft, where it is "
                "small; referred to the column it would double the frequency."
                if spring == "printed"
                else ""
            ),
        )


def _balanced(found: ColumnAnalysis) -> Iterator[Item]:
    reduced = balanced_column(SETS["S1"])
    off = _deviation(reduced.system)
    yield Claim(
        "reduction.balanced-eigenvalues",
        "Balanced singular perturbation keeps the slow eigenvalues.",
        "Raffone, section 4.2",
        None,
        off,
        at_most(1e-4),
        "1/s",
        "Largest deviation from 0, -8.1149 and -3.8399 ± 79.658i.",
    )
    yield Claim(
        "reduction.feed-through",
        "What is left out leaves a direct way D from torques to outputs, which (17) drops.",
        "Raffone, eqs (16) and (17)",
        None,
        float(np.abs(reduced.system.D).max()),
        between(0.092, 0.094),
        "",
        "Largest entry: torque of the bar over torque of the motor.",
    )
    yield from _balanced_errors(found)


def _balanced_errors(found: ColumnAnalysis) -> Iterator[Item]:
    errors = {row.name: row.errors for row in found.reductions}
    yield Claim(
        "reduction.steady-state",
        "The steady state of the balanced reduction is free of error.",
        "Raffone, section 4.2",
        0.0,
        100.0 * errors["balanced"][0],
        at_most(1e-3),
        "%",
        f"Largest error of the gain from motor to bar to {HEARD[0]:g} Hz. Without D, as (17) has it, "
        f"{100.0 * errors['balanced, without D'][0]:.2g} %.",
    )
    yield Claim(
        "reduction.best-to-30-hz",
        "To 30 Hz the balanced reduction follows the column better than the best mechanical one.",
        "tierod",
        None,
        errors["balanced"][-1] / min(errors[name][-1] for name in errors if name.startswith("mechanical")),
        at_most(0.1),
        "",
        f"Its largest error over theirs: {100.0 * errors['balanced'][-1]:.2g} % against "
        f"{100.0 * errors['mechanical, series'][-1]:.2g} % with the springs in series.",
    )
    yield Claim(
        "reduction.error-bound",
        "The error stays below twice the Hankel singular values left out.",
        "Glover, 1984",
        None,
        _error_over_bound(found.system),
        at_most(1.0),
        "",
        "Largest singular value of the difference over 0.01 to 1000 Hz, over the bound, in scaled units.",
        derived=1.0,
    )


def _ranks(found: ColumnAnalysis) -> Claim:
    ranks = [min(row.extended.ranks.values()) for row in found.reductions]
    return Claim(
        "reduction.rank-with-disturbances",
        "With either reduction the observability matrix has full rank also with both disturbance torques.",
        "Raffone, section 5",
        6.0,
        float(min(ranks)),
        exactly(6.0),
        "",
        f"Least over {len(ranks)} reductions and five methods, the unscaled matrix with default tolerance among them. "
        "The whole column has full rank as well, see above.",
    )


def _weights(system: LinearSystem) -> Table:
    ratio, degree = SETS["S1"].motor_ratio, math.radians(1.0)
    torques, usual = balancing_sizes(ratio)
    rows = []
    for name, inputs, outputs in (
        ("0.1°, 1 N·m (default)", torques, usual),
        ("1°, 2.4 N·m (1° of the bar)", *balancing_sizes(ratio, degree, SETS["S1"].torsion_bar_stiffness * degree)),
        ("noise of the sensors", torques, SAMPLING.noise),
        ("1 rad, 1 N·m (unscaled)", {}, {}),
    ):
        cells = []
        for shift in (None, 0.1, 1.0, 3.0):
            small = balanced_reduction(system, 4, input_size=inputs, output_size=outputs, shift=shift).system
            cells.append(f"{_deviation(small):.1g}")
        rows.append((name, *cells))
    return Table(
        "Balanced reduction: largest deviation of a slow eigenvalue (1/s), by what counts as one and how the free turn "
        "is treated",
        ("angle and torque that count as one", "parted", *(f"shifted by {shift:g}/s" for shift in (0.1, 1.0, 3.0))),
        tuple(rows),
        "The ringing of the gear has so little damping that it weighs as much as the slow coasting of the column where "
        "angles count for little: unscaled, the balanced reduction keeps the wrong states.",
    )


def _deviation(system: LinearSystem) -> float:
    """Largest distance from an eigenvalue of `KEPT` to the nearest eigenvalue of the system [1/s]."""
    values = np.linalg.eigvals(system.A)
    return float(max(min(abs(value - kept) for value in values) for kept in KEPT))


def _error_over_bound(system: LinearSystem) -> float:
    inputs, outputs = balancing_sizes(SETS["S1"].motor_ratio)
    reduction = balanced_column(SETS["S1"])
    assert reduction.error_bound is not None
    scaled = [_in_units(each, inputs, outputs) for each in (system, reduction.system)]
    return largest_difference(scaled[0], scaled[1], _FREQUENCY) / reduction.error_bound


def _in_units(system: LinearSystem, inputs: dict[str, float], outputs: dict[str, float]) -> LinearSystem:
    b = np.array([inputs.get(name, 1.0) for name in system.inputs])
    c = np.array([[1.0 / outputs[name]] for name in system.outputs])
    names = (system.states, system.inputs, system.outputs)
    return LinearSystem(system.A, system.B * b, system.C * c, system.D * b * c, *names)
