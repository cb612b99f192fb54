"""The linear column of the paper: observability, reduction, frequency response and identification on the bench."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.methods.analysis.observability import observability
from tierod.methods.identification.column_fit import ColumnFit, Fitted, WheelMotion, wheel_side
from tierod.methods.identification.sampled_column import BenchParameters, SampledColumn
from tierod.models.column_observation import linear_column, with_outputs
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import SteeringColumn
from tierod_lab.ground.cars.benches import Acting, BenchPorts, ColumnBench
from tierod_lab.ground.courses.bench import BenchSweep
from tierod_lab.ground.parts import NO_FAULT
from tierod_lab.methods.ranks import observability_matrix, pbh_rank, scaled_rank, unscaled_rank
from tierod_lab.papers.column.columns import EIGENVALUES, SETS, extended, member, reduced_columns, vibrations
from tierod_lab.papers.column.frequency_response import (
    MeasuredResponse,
    decibels,
    frequency_response,
    measured_response,
)
from tierod_lab.papers.column.identified_bench import LAWS, bench, experiments, recorded, truth
from tierod_lab.papers.column.model_reduction import Reduction
from tierod_lab.papers.column.output_error import OutputError
from tierod_lab.papers.column.swept_bench import NOISE
from tierod_lab.studies.metrics import Row

WHEEL, MOTOR, BAR = "steering_wheel_angle", "motor_angle_mechanical", "driver_torque"
PRINTED = {(MOTOR,): 5, (WHEEL,): 5, (WHEEL, MOTOR): 6, (BAR,): 4, (MOTOR, BAR): 6, (WHEEL, BAR): 6}
"""Table 2 of the paper: number of observable states by set of sensors; all three together give 6."""
TOLERANCES = tuple(10.0**k for k in range(-16, -5))  # Tolerances of a rank, relative to the largest singular value


class Member(NamedTuple):
    """A column: one of the sets by name, or stiffness [1/s^2], ratio and wheel inertia [kg m^2] of `member`."""

    name: str
    stiffness: float = 0.0
    ratio: float = 0.0
    inertia: float = 0.0


def ranks(which: Member) -> list[Row]:
    """The paper counts observable states by the rank of the observability matrix in double precision.

    From a rank of 5 of 8 with both disturbance torques it concludes that the column must be reduced. Other methods do
    not depend on units: the staircase of orthonormal bases, the test of Popov, Belevitch and Hautus, the matrix of the
    scaled and of the sampled system, and rational arithmetic. A chain of inertias and springs is observable by the
    angle at either end, and by the torque of one of its springs except for its rigid-body rotation.
    """
    p = SETS[which.name] if which.name in SETS else member(which.stiffness, which.ratio, which.inertia)
    system = linear_column(SteeringColumn, p)
    off = np.abs(np.sort_complex(np.linalg.eigvals(system.A)) - np.sort_complex(np.array(EIGENVALUES))).max()
    rows: list[Row] = [{"column": which.name, "sensors": "", "method": "eigenvalues", "deviation": float(off)}]
    for choice, printed in [*PRINTED.items(), ((WHEEL, MOTOR, BAR), 6)]:
        part = with_outputs(system, choice)
        exact = 5 if choice == (BAR,) else 6
        for method, rank in _ranks(part).items():
            rows.append(_rank_row(which.name, choice, method, rank, exact, printed))
        if len(choice) == 1 and choice != (BAR,):
            values = np.linalg.svd(observability_matrix(part.A, part.C), compute_uv=False)
            for tolerance in TOLERANCES:
                rank = int((values > tolerance * values[0]).sum())
                rows.append(_rank_row(which.name, choice, f"tolerance {tolerance:.0e}", rank, exact, printed))
    larger = extended(system)
    with_torques = _ranks(larger) | {
        f"sampled {1e3 * step:g} ms": unscaled_rank(sampled(larger, step)).rank for step in (1e-4, 1e-2)
    }
    if which.name in SETS:
        with_torques["rational"] = rational_rank(larger)
    for method, rank in with_torques.items():
        rows.append(_rank_row(which.name, ("all, and both torques",), method, rank, 8, 5))
    return rows


def _ranks(system: LinearSystem) -> dict[str, int]:
    return {
        "double precision": unscaled_rank(system).rank,
        "staircase": observability(system).rank,
        "PBH": pbh_rank(system),
        "scaled": scaled_rank(system).rank,
        "sampled 1 ms": unscaled_rank(sampled(system, 1e-3)).rank,
    }


def _rank_row(column: str, sensors: tuple[str, ...], method: str, rank: int, exact: int, printed: int) -> Row:
    return {
        "column": column,
        "sensors": " + ".join(sensors),
        "number": len(sensors),
        "method": method,
        "rank": rank,
        "wrong": float(rank != exact),
        "as_printed": float(rank == printed),
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

    Two springs one after the other are softer than either; (11) adds them. The free turn of the column has no Gramian
    and is parted from the rest before balancing. Errors are those of the gain from the motor's torque to the bar's.
    """
    system = linear_column(SteeringColumn, SETS["S1"])
    frequency = np.geomspace(0.05, 30.0, 600)
    whole = frequency_response(system, frequency).of(BAR, "motor_torque")
    rows: list[Row] = []
    for name, way in reduced_columns(SETS["S1"]).items():
        small = way.system if isinstance(way, Reduction) else way
        error = np.abs(frequency_response(small, frequency).of(BAR, "motor_torque") - whole) / np.abs(whole)
        values = np.linalg.eigvals(small.A)
        kept = EIGENVALUES[2:]
        rows.append(
            {
                "reduction": name,
                "kind": name.partition(",")[0],
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
STEP, PIECE = 1e-3, 8.0  # Sampling interval, and length of the segments over which spectra are averaged [s]


@dataclass(frozen=True)
class Excitation:
    """A test on the bench: noise without friction (amplitude 0), or a sweep at the motor, with friction of 0.1 N m."""

    amplitude: float
    seconds: float
    seed: int


@cache
def response(test: Excitation) -> MeasuredResponse:
    """Measured frequency response from motor torque to torque of the torsion bar."""
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
    return measured_response(torque, bar, 1.0 / STEP, PIECE).between(LOWEST, HIGHEST)


def model_gain(frequency: np.ndarray) -> np.ndarray:
    """Complex gain of the sampled linear column from motor torque to torque of the torsion bar."""
    column = sampled(linear_column(SteeringColumn, SETS["S1"]), STEP)
    return frequency_response(column, frequency, STEP).of(BAR, "motor_torque")


def frequency_gains(test: Excitation) -> list[Row]:
    """The paper compares the Bode plot of the linear column with spectra of a bench that its motor sweeps (Figure 5).

    Here the bench is simulated, with friction of 0.1 N·m at the motor or, shaken by noise, without any; sensors have
    noise, the wheel is free. Spectra are averaged over pieces; the ringing of the gear lasts as long as a piece, which
    blurs it, so that it is left out.
    """
    found = response(test)
    true = model_gain(found.frequency)
    gear = abs(EIGENVALUES[0]) / (2.0 * np.pi)
    quiet = found.usable() & (np.abs(found.frequency / gear - 1.0) >= 0.1)
    low, high = found.band()
    inside = (low <= np.abs(true)) & (np.abs(true) <= high)
    away = decibels(found.gain) - decibels(true)
    slow = found.frequency <= 40.0
    band = (found.frequency >= 3.0) & (found.frequency <= 6.0)
    return [
        {
            "amplitude": test.amplitude,
            "within_band": float(np.mean(inside[quiet])),
            "gain_error": float(np.sqrt(np.mean(away[quiet] ** 2))),
            "gain_3_to_6_hz": float(np.mean(away[band])),
            "coherence": float(np.median(found.coherence[band])),
            "peak": float(found.frequency[np.argmax(np.where(found.usable() & slow, np.abs(found.gain), 0.0))]),
        }
    ]


WHEEL_SIDE = ("steering_wheel_inertia", "steering_wheel_damping")
MOTOR_SIDE = ("motor_damping", "motor_friction", "motor_friction_stiffness")
"""Parameters found by instrumental variables (wheel) and by maximum likelihood (motor)."""
SHORT = 3.2  # Duration of the recordings for the intervals [s]


def start() -> BenchParameters:
    """Start of the search: damping 30 % too high, friction 20 % and its stiffness 25 % too low."""
    right = truth()
    return replace(
        right,
        motor_damping=1.3 * right.motor_damping,
        motor_friction=0.8 * right.motor_friction,
        motor_friction_stiffness=0.75 * right.motor_friction_stiffness,
    )


def _off(name: str, value: float) -> float:
    return 100.0 * (value / float(getattr(truth(), name)) - 1.0)


def identified(task: tuple[str, int]) -> list[Row]:
    """The virtual bench makes four experiments: a sweep and many sines with the wheel free, a sweep and ramps locked.

    Noise of 0.05° on the wheel's angle, 0.2° on the motor's, 0.02 N·m on the bar's torque; 1 kHz. The wheel's side is
    found by instruments, the rest by the likelihood, with a torque at the motor that was not recorded. Errors in %.
    """
    side, seed = task
    if side == "wheel":
        motions = []
        for row in experiments(recorded(bench(), seed), truth()):
            if not row.locked:
                wheel, motor, torque = row.experiment.measured.T
                motions.append(WheelMotion(wheel, motor / truth().motor_ratio, torque, row.sample_time))
        found = wheel_side(motions)
        pairs = ((found.inertia, found.inertia_deviation), (found.damping, found.damping_deviation))
        intervals = {
            name: (value, value - 1.96 * sigma, value + 1.96 * sigma)
            for name, (value, sigma) in zip(WHEEL_SIDE, pairs, strict=True)
        }
    else:
        again = ColumnFit(start(), (*WHEEL_SIDE, *MOTOR_SIDE)).run(
            experiments(recorded(bench(), seed, seconds=SHORT), start()), near=_first_fit()
        )
        intervals = {
            each.name: (each.value, each.low, each.high) for each in again.found({}) if each.name in MOTOR_SIDE
        }
    return [
        {
            "parameter": name,
            "error": _off(name, value),
            "size": abs(_off(name, value)),
            "covered": float(low < getattr(truth(), name) < high),
        }
        for name, (value, low, high) in intervals.items()
    ]


@cache
def _first_fit() -> Fitted:
    first = experiments(recorded(bench(), 1, seconds=SHORT), start())
    return ColumnFit(start(), (*WHEEL_SIDE, *MOTOR_SIDE)).run(first)


BENCHES = {
    "exact": (bench(), {}),
    "motor torque noise 0.01 N·m": (bench(), {"torque_noise": 0.01}),
    "torque constant +2 %": (bench(), {"torque_gain": 1.02}),
    "cogging 0.01 N·m": (bench(cogging=0.01), {}),
    "cogging 0.01 N·m, ripple 1 %": (bench(cogging=0.01, ripple=0.01), {}),
    **{name: (bench(law), {}) for name, law in LAWS.items()},
}
"""Benches that the model of the identification does not know in all, and unrecorded torque of the motor, by name."""


def unknown_benches(task: tuple[str, int, float | None]) -> list[Row]:
    """One recording of each bench that deviates from the model; errors in %.

    Under another law of friction level and stiffness are those of the curve of Dahl that is nearest to it over the
    strokes driven, and the damping takes a part: no interval covers that bias. Least squares of simulated against
    measured output, as in the paper, stands beside the likelihood.
    """
    name, seed, seconds = task
    plant, motor = BENCHES[name]
    recordings = experiments(recorded(plant, seed, **motor, seconds=seconds), start())
    fitted = ColumnFit(start(), (*WHEEL_SIDE, *MOTOR_SIDE)).run(recordings)
    found = {"likelihood": {each.name: each.value for each in fitted.found({})}}
    if name in ("exact", "cogging 0.01 N·m"):
        wheel = {key: value for key, (value, _) in fitted.wheel.items()}
        free = tuple(each for each in fitted.estimate.free if each.name not in WHEEL_SIDE)
        states, noise = ("steering_wheel_angle", "motor_angle"), tuple(NOISE.values())
        search = OutputError(SampledColumn, replace(start(), **wheel), free, noise, states, most_steps=10)
        simulated = search.fit([row.experiment for row in recordings])
        found["output error"] = {each: simulated[each] for each in MOTOR_SIDE}
    return [
        {
            "bench": name,
            "method": method,
            "parameter": parameter,
            "error": _off(parameter, values[parameter]),
            "size": abs(_off(parameter, values[parameter])),
        }
        for method, values in found.items()
        for parameter in MOTOR_SIDE
    ]
