"""The linear column of the paper: observability, reduction, frequency response and identification on the bench."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.methods.identification.bench_recording import BenchParameters
from tierod.methods.identification.column_fit import ColumnFit, Fitted, WheelMotion, wheel_side
from tierod.models.column_observation import linear_column, with_outputs
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import SteeringColumn
from tierod_lab.ground.cars.benches import Acting, BenchPorts, ColumnBench
from tierod_lab.ground.courses.bench import BenchSweep
from tierod_lab.ground.parts import NO_FAULT
from tierod_lab.methods.ranks import observability, observability_matrix, pbh_rank, scaled_rank, unscaled_rank
from tierod_lab.papers.column.benches import NOISE, STEP, bench, experiments, recorded, truth
from tierod_lab.papers.column.columns import EIGENVALUES, SETS, extended, gain_of_bar, reduced_columns, vibrations
from tierod_lab.studies.metrics import Row

WHEEL, MOTOR, BAR = "steering_wheel_angle", "motor_angle_mechanical", "driver_torque"
PRINTED = {(MOTOR,): 5, (WHEEL,): 5, (WHEEL, MOTOR): 6, (BAR,): 4, (MOTOR, BAR): 6, (WHEEL, BAR): 6}
"""Table 2 of the paper: number of observable states by set of sensors; all three together give 6."""
TOLERANCES = tuple(10.0**k for k in range(-16, -5))  # Tolerances of a rank, relative to the largest singular value


def ranks(name: str) -> list[Row]:
    """The paper counts observable states by the rank of the observability matrix in double precision.

    From a rank of 5 of 8 with both disturbance torques it concludes that the column must be reduced. Other methods do
    not depend on units: the staircase of orthonormal bases, the test of Popov, Belevitch and Hautus, the matrix of the
    scaled and of the sampled system, and rational arithmetic. A chain of inertias and springs is observable by the
    angle at either end, and by the torque of one of its springs except for its rigid-body rotation.
    """
    system = linear_column(SteeringColumn, SETS[name])
    off = np.abs(np.sort_complex(np.linalg.eigvals(system.A)) - np.sort_complex(np.array(EIGENVALUES))).max()
    rows: list[Row] = [{"column": name, "sensors": "", "method": "eigenvalues", "deviation": float(off)}]

    def add(sensors: tuple[str, ...], printed: int, found: dict[str, int]) -> None:
        shared: Row = {"column": name, "sensors": " + ".join(sensors), "number": len(sensors)}
        rows.extend(
            {**shared, "method": how, "rank": rank, "as_printed": rank == printed} for how, rank in found.items()
        )

    for choice, printed in [*PRINTED.items(), ((WHEEL, MOTOR, BAR), 6)]:
        part = with_outputs(system, choice)
        found = _ranks(part)
        if len(choice) == 1 and choice != (BAR,):
            values = np.linalg.svd(observability_matrix(part.A, part.C), compute_uv=False)
            found |= {f"tolerance {each:.0e}": int((values > each * values[0]).sum()) for each in TOLERANCES}
        add(choice, printed, found)
    larger = extended(system)
    found = _ranks(larger) | {"rational": rational_rank(larger)}
    found |= {f"sampled {1e3 * step:g} ms": unscaled_rank(sampled(larger, step)) for step in (1e-4, 1e-2)}
    add(("all, and both torques",), 5, found)
    return rows


def _ranks(system: LinearSystem) -> dict[str, int]:
    return {
        "double precision": unscaled_rank(system),
        "staircase": observability(system).rank,
        "PBH": pbh_rank(system),
        "scaled": scaled_rank(system),
        "sampled 1 ms": unscaled_rank(sampled(system, 1e-3)),
    }


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


def reductions(task: None) -> list[Row]:
    """The paper leaves out the gear: mechanically (9) to (13), or by balancing the column (14) to (16).

    Two springs one after the other are softer than either; (11) adds them. The column is balanced with a small decay
    rate added, since its free turn has no Gramian. Errors are those of the gain from the motor's torque to the bar's.
    """
    system = linear_column(SteeringColumn, SETS["S1"])
    frequency = np.geomspace(0.05, 30.0, 600)
    whole = gain_of_bar(system, frequency)
    rows: list[Row] = []
    for name, small in reduced_columns(SETS["S1"]).items():
        error = np.abs(gain_of_bar(small, frequency) - whole) / np.abs(whole)
        values, kept = np.linalg.eigvals(small.A), EIGENVALUES[2:]
        rows.append(
            {
                "reduction": name,
                "frequency_miss": 100.0 * abs(abs(vibrations(small)[2]) / abs(kept[2]) - 1.0),
                "deviation": float(max(min(abs(value - each) for value in values) for each in kept)),
                "steady_error": 100.0 * float(error[frequency <= 1.0].max()),
                "error": 100.0 * float(error.max()),
                "feed_through": float(np.abs(small.D).max()),
                "rank": min(_ranks(extended(small)).values()),
            }
        )
    return rows


LOWEST, HIGHEST = 1.0, 150.0  # Lowest and highest frequency at which the responses are compared [Hz]
PIECE, BANDS = 8.0, 48.0  # Length of the segments over which spectra are averaged [s], and bands per octave


class Excitation(NamedTuple):
    """A test on the bench: noise without friction (amplitude 0), or a sweep at the motor, with friction of 0.1 N m."""

    amplitude: float
    seconds: float
    seed: int


class Response(NamedTuple):
    """Measured complex gain at frequencies [Hz]; NaN where less than half of the output depends on the input."""

    frequency: np.ndarray
    gain: np.ndarray


@cache
def response(test: Excitation) -> Response:
    """Measured gain from motor torque to torque of the torsion bar: cross spectrum over that of the input (Welch)."""
    from scipy import signal

    plant, count = ColumnBench(), round(test.seconds / STEP)
    if test.amplitude:
        sweep = BenchSweep(amplitude=test.amplitude, settle=0.0, time=test.seconds, lowest=0.5, highest=40.0)
        random = np.random.default_rng([test.seed, 6])
        torque = sweep.torque_at(np.arange(count) * STEP)
    else:
        plant = replace(plant, friction=replace(plant.friction, level=0.0))
        random = np.random.default_rng([test.seed, 5])
        torque = random.normal(0.0, 1.0, count)
    rows = np.zeros((count, len(Acting._fields) - 1 + len(NO_FAULT)))
    rows[:, 0] = torque
    rows[:, len(Acting._fields) - 1 :] = list(BenchPorts(NO_FAULT).motor_torque)
    bar = scan(plant, rows)[BAR] + random.normal(0.0, NOISE[BAR], count)
    pairs = ((torque, torque), (torque, bar), (bar, bar))
    spectra = [signal.csd(*pair, 1.0 / STEP, nperseg=round(PIECE / STEP)) for pair in pairs]
    frequency = spectra[0][0][1:]
    bands = np.flatnonzero(np.diff(np.floor(BANDS * np.log2(frequency / frequency[0])), prepend=-1))
    middle, power, cross, other = (
        np.add.reduceat(each, bands) for each in (frequency, *(found[1:] for _, found in spectra))
    )
    coherent = (np.abs(cross) ** 2 >= 0.5 * np.abs(power * other)) & (np.abs(power) > 1e-12 * np.abs(power).max())
    middle = middle / np.diff(np.append(bands, len(frequency)))
    gain = np.where(coherent, cross, np.nan) / np.where(coherent, power, 1.0)
    kept = (middle >= LOWEST) & (middle <= HIGHEST)
    return Response(middle[kept], gain[kept])


def model_gain(frequency: np.ndarray) -> np.ndarray:
    """Complex gain of the sampled linear column from motor torque to torque of the torsion bar."""
    return gain_of_bar(sampled(linear_column(SteeringColumn, SETS["S1"]), STEP), frequency, STEP)


def decibels(gain: np.ndarray) -> np.ndarray:
    """Magnitude of a gain in decibels [dB]."""
    return np.asarray(20.0 * np.log10(np.abs(gain)))


def frequency_gains(test: Excitation) -> list[Row]:
    """The paper compares the Bode plot of the linear column with spectra of a bench that its motor sweeps (Figure 5).

    Here the bench is simulated, with friction of 0.1 N·m at the motor or, shaken by noise, without any; sensors have
    noise, the wheel is free. Spectra are averaged over pieces.
    """
    frequency, gain = response(test)
    away = decibels(gain) - decibels(model_gain(frequency))
    band = (frequency >= 3.0) & (frequency <= 6.0)
    heights = np.where(np.isfinite(gain) & (frequency <= 40.0), np.abs(gain), 0.0)
    return [
        {
            "amplitude": test.amplitude,
            "gain_3_to_6_hz": float(np.nanmean(away[band])) if np.isfinite(away[band]).any() else np.nan,
            "peak": float(frequency[np.argmax(heights)]),
        }
    ]


WHEEL_SIDE = ("steering_wheel_inertia", "steering_wheel_damping")
MOTOR_SIDE = ("motor_damping", "motor_friction", "motor_friction_stiffness")
"""Parameters found by instrumental variables (wheel) and by maximum likelihood (motor)."""
SHORT = 3.2  # Duration of the recordings for the intervals [s]


def start() -> BenchParameters:
    """Start of the search: damping 30 % too high, friction 20 % and its stiffness 25 % too low."""
    right = truth()
    factors = dict(zip(MOTOR_SIDE, (1.3, 0.8, 0.75), strict=True))
    return replace(right, **{name: factor * getattr(right, name) for name, factor in factors.items()})


def identified(task: tuple[str, int]) -> list[Row]:
    """The virtual bench makes four experiments: a sweep and many sines with the wheel free, a sweep and ramps locked.

    Noise of 0.05° on the wheel's angle, 0.2° on the motor's, 0.02 N·m on the bar's torque; 1 kHz. The wheel's side is
    found by instruments, the rest by the likelihood, with a torque at the motor that was not recorded. Errors in %. The
    deviation is the square root of the Cramér-Rao bound, from the information of the recordings.
    """
    side, seed = task
    if side == "wheel":
        motions = []
        for row in experiments(recorded(bench(), seed), truth()):
            if not row.locked:
                wheel, motor, torque = row.experiment.measured.T
                motions.append(WheelMotion(wheel, motor / truth().motor_ratio, torque, row.sample_time))
        both = wheel_side(motions)
        pairs = ((both.inertia, both.inertia_deviation), (both.damping, both.damping_deviation))
        found = {name: (*pair, 1.96 * pair[1]) for name, pair in zip(WHEEL_SIDE, pairs, strict=True)}
    else:
        again = ColumnFit(start(), (*WHEEL_SIDE, *MOTOR_SIDE)).run(
            experiments(recorded(bench(), seed, seconds=SHORT), start()), near=_first_fit()
        )
        found = {
            each.name: (each.value, each.deviation, 0.5 * (each.high - each.low))
            for each in again.found({})
            if each.name in MOTOR_SIDE
        }
    rows: list[Row] = []
    for name, (value, deviation, half) in found.items():
        true = float(getattr(truth(), name))
        error, share = 100.0 * (value / true - 1.0), 100.0 * deviation / true
        rows.append({"parameter": name, "error": error, "deviation": share, "covered": abs(value - true) < half})
    return rows


@cache
def _first_fit() -> Fitted:
    first = experiments(recorded(bench(), 1, seconds=SHORT), start())
    return ColumnFit(start(), (*WHEEL_SIDE, *MOTOR_SIDE)).run(first)
