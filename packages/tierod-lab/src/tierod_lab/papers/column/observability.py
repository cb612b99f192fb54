"""Observability of a column by its sensors: Tables 2 and 3 of the paper, and the rank with disturbance torques."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from tierod.core.claims import Claim, at_most, exactly
from tierod.core.content import Heading, Item, Table
from tierod.methods.analysis.observability import (
    observability,
    observability_matrix,
    pbh_rank,
    scaled_rank,
    unscaled_rank,
)
from tierod.models.column_observation import linear_column, with_outputs
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import SteeringColumn
from tierod_lab.papers.column.analysis import SAMPLING, UNKNOWN_TORQUES, vibrations
from tierod_lab.papers.column.output_subsets import Shown, extended, output_subsets
from tierod_lab.papers.column.parameter_sets import EIGENVALUES, SETS, member
from tierod_lab.studies.effort import Effort

WHEEL, MOTOR, BAR = "steering_wheel_angle", "motor_angle_mechanical", "driver_torque"
PRINTED = {
    (MOTOR,): 5,
    (WHEEL,): 5,
    (WHEEL, MOTOR): 6,
    (BAR,): 4,
    (MOTOR, BAR): 6,
    (WHEEL, BAR): 6,
    (WHEEL, MOTOR, BAR): 6,
}
"""Table 2 of the paper: number of observable states by set of sensors."""

EXACT = {choice: 5 if choice == (BAR,) else 6 for choice in PRINTED}
"""Number of observable states by mechanics.

A chain of inertias and springs is observable by the angle at either end, and by the torque of one of its springs except
for its rigid-body rotation.
"""

_SHORT = {WHEEL: "wheel angle", MOTOR: "motor angle", BAR: "bar torque"}
_STEPS = (1e-4, 1e-3, 1e-2)
"""Sampling intervals of the sampled observability matrices [s]."""
_TOLERANCES = tuple(10.0**k for k in range(-16, -5))
"""Tolerances of a rank, relative to the largest singular value."""


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Observability by the sensors",
        (
            "The paper counts observable states by the rank of the observability matrix in double precision, and from "
            "a rank of 5 of 8 with both disturbance torques concludes that the column must be reduced. The rank is "
            "taken here by MATLAB's default tolerance, as the paper's figures suggest, and beside it by methods that "
            "do not depend on units: the staircase of orthonormal bases, the test of Popov, Belevitch and Hautus, the "
            "matrix of the scaled and of the sampled system, and rational arithmetic.",
        ),
    )
    sets = {name: linear_column(SteeringColumn, parameters) for name, parameters in SETS.items()}
    family = _family(effort)
    yield from _eigenvalues(sets, len(family))
    yield from _table_2(sets)
    yield from _single([*sets.values(), *family])
    yield from _with_disturbances(sets, family)
    yield _bounds(sets["S1"])


def _family(effort: Effort) -> list[LinearSystem]:
    stiffnesses = (1500.0, 4500.0) if effort.quick else (600.0, 1200.0, 1800.0, 2400.0, 3000.0, 3800.0, 4600.0, 5600.0)
    ratios = (18.0,) if effort.quick else (6.0, 10.0, 14.0, 18.0, 24.0)
    inertias = (0.035,) if effort.quick else (0.025, 0.035, 0.05)
    columns = [member(p, ratio, inertia) for p in stiffnesses for ratio in ratios for inertia in inertias]
    return [linear_column(SteeringColumn, parameters) for parameters in columns]


def _eigenvalues(sets: dict[str, LinearSystem], others: int) -> Iterator[Item]:
    expected = np.sort_complex(np.array(EIGENVALUES))
    printed = sorted((value for value in EIGENVALUES if value.imag >= 0.0), key=abs)
    found = {name: vibrations(system) for name, system in sets.items()}
    rows = tuple(
        (_number(value), f"{abs(value) / math.tau:.1f}", *(_number(found[name][k]) for name in SETS))
        for k, value in enumerate(printed)
    )
    yield Table(
        "Eigenvalues of the column (1/s)", ("printed", "Hz", *SETS), rows, "Of each pair the one above the axis."
    )
    off = [np.abs(np.sort_complex(np.linalg.eigvals(system.A)) - expected).max() for system in sets.values()]
    yield Claim(
        "observability.eigenvalues",
        "The column's model has the eigenvalues of Table 3.",
        "Raffone, Table 3",
        "-0.4911 ± 706.75i, 0, -8.115, -3.840 ± 79.658i",
        float(max(off)),
        at_most(1e-6),
        "1/s",
        f"Largest deviation over the sets {', '.join(SETS)}, with (2), (3) and the third row of A corrected; as "
        "printed the column repels its motor, and the row leaves no eigenvalue at zero. The table fixes five of eight "
        f"parameters: {others} other columns tried here have the same eigenvalues.",
    )


def _table_2(systems: dict[str, LinearSystem]) -> Iterator[Item]:
    rows = []
    for choice, printed in PRINTED.items():
        parts = {name: with_outputs(system, choice) for name, system in systems.items()}
        unscaled = tuple(str(unscaled_rank(part).rank) for part in parts.values())
        rows.append((_label(choice), str(printed), str(EXACT[choice]), *unscaled))
    yield Table(
        "Observability by sensors, of 6 states",
        ("sensors", "printed", "exact", *(f"{name}, double precision" for name in SETS)),
        tuple(rows),
        "Exact by mechanics, and so found by staircase, PBH test, scaled and sampled matrix for all three sets.",
    )
    yield Claim(
        "observability.exact",
        "Staircase, PBH test, scaled and sampled matrix give the orders that mechanics demands.",
        "tierod",
        None,
        float(sum(_wrong(system) for system in systems.values())),
        exactly(0.0),
        "",
        f"Wrong ranks of {4 * len(PRINTED) * len(SETS)}.",
    )
    soft = systems["S3"]
    yield Claim(
        "observability.bar-alone",
        "By the torque of the bar alone the order is 4.",
        "Raffone, Table 2",
        4.0,
        float(unscaled_rank(with_outputs(soft, (BAR,))).rank),
        exactly(4.0),
        "",
        "Set S3, default tolerance. The exact order is 5: only the free turn of the whole column is hidden.",
    )
    chance = {name: unscaled_rank(with_outputs(systems[name], (WHEEL, BAR))).margin for name in ("S1", "S3")}
    pairs = [choice for choice in PRINTED if len(choice) > 1]
    yield Claim(
        "observability.pairs",
        "Any two sensors, and all three, show the whole state.",
        "Raffone, Table 2",
        "6 for each",
        float(sum(unscaled_rank(with_outputs(soft, choice)).rank == 6 for choice in pairs)),
        exactly(4.0),
        "",
        "Choices of two or three sensors with order 6, set S3, default tolerance. For wheel angle and bar torque "
        f"rounding decides: a singular value lies at {chance['S3']:.1f} times the tolerance, "
        f"at {chance['S1']:.1f} times it for S1.",
    )


def single_angle_ranks(systems: list[LinearSystem]) -> dict[str, Counter[int]]:
    """Count of each rank that results from one angle alone, by method; every tolerance counts separately.

    Args:
        systems: the columns
    """
    found: dict[str, Counter[int]] = {}
    for system in systems:
        for choice in ((WHEEL,), (MOTOR,)):
            part = with_outputs(system, choice)
            values = np.linalg.svd(observability_matrix(part.A, part.C), compute_uv=False)
            ranks = {
                "double precision, default tolerance": [unscaled_rank(part).rank],
                "relative tolerances of 1e-16 to 1e-6": [int((values > t * values[0]).sum()) for t in _TOLERANCES],
                "staircase": [observability(part).rank],
                "scaled matrix": [scaled_rank(part).rank],
                "sampled every millisecond": [unscaled_rank(sampled(part, 1e-3)).rank],
            }
            for method, several in ranks.items():
                found.setdefault(method, Counter()).update(several)
    return found


def _single(systems: list[LinearSystem]) -> Iterator[Item]:
    found = single_angle_ranks(systems)
    ranks = sorted({rank for counts in found.values() for rank in counts})
    yield Table(
        "Order by one angle alone: how often each comes out",
        ("method", *(str(rank) for rank in ranks)),
        tuple((method, *(str(counts[rank]) for rank in ranks)) for method, counts in found.items()),
        f"{len(systems)} columns that Table 3 allows, wheel angle and motor angle each. Printed: 5.",
    )
    default = found["double precision, default tolerance"]
    five, tried = (sum(counts[rank] for counts in found.values() for rank in which) for which in ([5], ranks))
    yield Claim(
        "observability.single-angle",
        "By one angle alone the order is 5: the order that comes out most often in double precision.",
        "Raffone, Table 2",
        5.0,
        float(default.most_common(1)[0][0]),
        exactly(5.0),
        "",
        f"Not reproducible: {five} of {tried} ranks are 5, over columns, angles, methods and tolerances. The two "
        "smallest singular values are all but equal, so that the rank goes from 6 to 4. By mechanics an angle at an "
        "end of the chain shows the whole state.",
        cause="The figure contradicts the paper's own equations: an angle at an end of a chain of inertias and springs "
        f"shows the whole state. The paper prints neither parameters nor tolerance; over {len(systems)} columns that "
        f"its Table 3 allows, {five} of {tried} ranks are 5, by any method and tolerance.",
        irreproducible=True,
    )


def _with_disturbances(sets: dict[str, LinearSystem], family: list[LinearSystem]) -> Iterator[Item]:
    columns = {**sets, **{str(k): system for k, system in enumerate(family)}}
    larger = {name: extended(system, UNKNOWN_TORQUES) for name, system in columns.items()}
    unscaled = [unscaled_rank(system).rank for system in larger.values()]
    others = {name: _other_ranks(system) for name, system in larger.items()}
    methods = ("unscaled matrix", *next(iter(others.values())), "rational arithmetic")
    rational = {name: rational_rank(larger[name]) for name in sets}
    rows = tuple(
        (name, str(unscaled_rank(larger[name]).rank), *map(str, others[name].values()), str(rational[name]))
        for name in sets
    )
    spread = unscaled_rank(larger["S1"]).singular_values
    yield Table(
        "Rank with the torques of driver and disturbance as states, of 8",
        ("set", *methods),
        rows,
        "Singular values of the unscaled matrix of S1 over the largest: "
        + ", ".join(f"{value / spread[0]:.2g}" for value in spread)
        + ". Rational arithmetic takes the numbers as they are and rounds nothing.",
    )
    yield from _rank_claims(unscaled, others, rational)


def _rank_claims(unscaled: list[int], others: dict[str, dict[str, int]], rational: dict[str, int]) -> Iterator[Item]:
    """Claims on the ranks with both torques: unscaled, by every other method and column, in rational arithmetic."""
    yield Claim(
        "observability.with-disturbances",
        "With the torques of driver and disturbance as states the rank of the observability matrix is 5 of 8.",
        "Raffone, section 3.3",
        5.0,
        float(max(unscaled)) if len(set(unscaled)) == 1 else math.nan,
        exactly(5.0),
        "",
        f"The same for each of {len(unscaled)} columns with the eigenvalues of Table 3, unscaled, default tolerance.",
    )
    yield Claim(
        "observability.artefact",
        "That is double precision, not the column: every other method says 8.",
        "tierod",
        5.0,
        float(min(min(ranks.values()) for ranks in others.values())),
        exactly(8.0),
        "",
        "Least rank by staircase, PBH test, scaled matrix and matrix of the system sampled every 0.1, 1 and 10 ms, "
        f"over {len(others)} columns; so no reduction is needed for the sake of observability.",
    )
    yield Claim(
        "observability.rational",
        "In rational arithmetic the same matrix of the same numbers has full rank.",
        "tierod",
        5.0,
        float(min(rational.values())),
        exactly(8.0),
        "",
        f"Least over the sets {', '.join(SETS)}.",
    )


def _wrong(system: LinearSystem) -> int:
    """Number of ranks that differ from the exact ones, over all sets of sensors and four methods."""
    wrong = 0
    for choice, exact in EXACT.items():
        part = with_outputs(system, choice)
        matrices = scaled_rank(part).rank, unscaled_rank(sampled(part, 1e-3)).rank
        ranks = (observability(part).rank, pbh_rank(part), *matrices)
        wrong += sum(rank != exact for rank in ranks)
    return wrong


def _other_ranks(system: LinearSystem) -> dict[str, int]:
    ranks = {"staircase": observability(system).rank, "PBH": pbh_rank(system), "scaled": scaled_rank(system).rank}
    return ranks | {f"sampled {1e3 * step:g} ms": unscaled_rank(sampled(system, step)).rank for step in _STEPS}


def _bounds(system: LinearSystem) -> Table:
    rows = output_subsets(extended(system, UNKNOWN_TORQUES), SAMPLING)
    return Table(
        "Least standard deviation after one second, and condition of the Gramian, by sensors",
        ("sensors", "states", "condition", "wheel rate (°/s)", "hand torque (N·m)", "disturbance torque (N·m)"),
        tuple(_bound_cells(row) for row in rows),
        "Cramer and Rao, set S1: constant torques, a right model, noise of 0.05°, 0.2° and 0.02 N·m, 1 kHz. Either "
        "angle with the torque of the bar does nearly as well as all three sensors; the two angles alone do not.",
    )


def _bound_cells(row: Shown) -> tuple[str, ...]:
    figures = (
        row.condition,
        math.degrees(row.bound["steering_wheel_rate"]),
        row.bound["hand_torque"],
        row.bound["disturbance_torque"],
    )
    return (_label(row.outputs), str(row.exact.rank), *("∞" if math.isinf(x) else f"{x:.2g}" for x in figures))


def _label(choice: tuple[str, ...]) -> str:
    return " + ".join(_SHORT[name] for name in choice)


def _number(value: complex) -> str:
    if abs(value) < 1e-9:
        return f"{value.real:.0e}"
    real = abs(value.imag) < 1e-9 * abs(value)
    return f"{value.real:.9f}" + ("" if real else f" + {value.imag:.9f}i")


def rational_rank(system: LinearSystem) -> int:
    """Rank of the observability matrix by Gaussian elimination in rational arithmetic, without rounding."""
    A = [[Fraction(float(value)) for value in row] for row in system.A]
    block = [[Fraction(float(value)) for value in row] for row in system.C]
    n = len(A)
    rows = list(block)
    for _ in range(n - 1):
        block = [[sum((row[k] * A[k][j] for k in range(n)), Fraction(0)) for j in range(n)] for row in block]
        rows += block
    rank = 0
    for column in range(n):
        pivot = next((k for k in range(rank, len(rows)) if rows[k][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for k in range(rank + 1, len(rows)):
            if rows[k][column]:
                factor = rows[k][column] / rows[rank][column]
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[rank], strict=True)]
        rank += 1
    return rank
