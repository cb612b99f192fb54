"""Identification of the column on the bench: errors, intervals, and what an imperfect bench costs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tierod.core.claims import Claim, Goal, at_least, at_most
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.experiments.effort import Effort
from tierod.methods.identification.bench_recording import BenchRecording
from tierod.methods.identification.column import identify_column
from tierod.methods.identification.column_fit import ColumnFit, Fitted
from tierod.methods.identification.sampled_column import SampledColumn
from tierod.methods.identification.wheel_side import WheelMotion, wheel_side
from tierod.papers.column.identified_bench import LAWS, bench, experiments, recorded, truth
from tierod.papers.column.output_error import OutputError
from tierod.papers.column.swept_bench import NOISE

GOAL = "goal of tierod"
WHEEL = ("steering_wheel_inertia", "steering_wheel_damping")
MOTOR = ("motor_damping", "motor_friction", "motor_friction_stiffness")
LIMITS = dict.fromkeys((*WHEEL,), 0.5) | {"motor_damping": 2.0, "motor_friction": 2.0, "motor_friction_stiffness": 5.0}
"""Errors [%] that the identification should not exceed."""
SEEDS, COVERING, SHORT = 50, 45, 3.2
"""Recordings for the intervals, how many of them the intervals should hold, and their duration [s]."""
_STATES = ("steering_wheel_angle", "motor_angle")

TEXT = (
    "The virtual bench makes four experiments of 6 s: a sweep and many sines with the wheel free, a sweep and slow "
    "ramps with the wheel locked. Noise of 0.05° on the wheel's angle, 0.2° on the motor's, 0.02 N·m on the bar's "
    "torque; 1 kHz. The search starts from damping 30 % too high, friction 20 % and its stiffness 25 % too low; for "
    "the intervals it starts where it ended on another recording. The bench has a code of its own and shares no model "
    "with the identification.",
    "The wheel's side is found by instruments, the rest by the likelihood of the recordings with a torque at the motor "
    "that nobody recorded. Least squares of simulated against measured output, as in the paper, stands beside it.",
)


@dataclass(frozen=True)
class Case:
    """A bench that is not as the model has it.

    Args:
        name: in the table
        plant: the bench
        motor: what its motor does unrecorded, as `recorded` takes it
        compared: whether least squares of the output is shown beside
        judged: whether the errors should keep to the limits; the bias that a wrong model makes is only told
    """

    name: str
    plant: Any
    motor: Mapping[str, float]
    compared: bool = True
    judged: bool = True


def items(effort: Effort) -> Iterator[Item]:
    """Intervals first, then what the model does not know."""
    yield Heading("Identification on the bench", TEXT)
    yield from _wheel(effort)
    yield from _intervals(effort)
    yield from _unknown(effort)
    if not effort.quick:
        yield from _left_out()


def _start() -> Any:
    right = truth()
    return replace(
        right,
        motor_damping=1.3 * right.motor_damping,
        motor_friction=0.8 * right.motor_friction,
        motor_friction_stiffness=0.75 * right.motor_friction_stiffness,
    )


def _error(name: str, value: float) -> float:
    """Relative, of a parameter [%]."""
    return 100.0 * (value / getattr(truth(), name) - 1.0)


def _count(effort: Effort) -> int:
    return 2 if effort.quick else SEEDS


def _wheel(effort: Effort) -> Iterator[Item]:
    ratio, errors, held = truth().motor_ratio, [], []
    for seed in range(_count(effort)):
        rows = [row for row in experiments(recorded(bench(), 1000 + seed), truth()) if not row.locked]
        found = wheel_side([_motion(row, ratio) for row in rows])
        pairs = ((found.inertia, found.inertia_deviation), (found.damping, found.damping_deviation))
        errors.append([_error(name, value) for name, (value, _) in zip(WHEEL, pairs, strict=True)])
        held.append([abs(v - getattr(truth(), n)) < 1.96 * s for n, (v, s) in zip(WHEEL, pairs, strict=True)])
    yield _table("Wheel's side by instruments", WHEEL, np.array(errors), np.array(held))
    yield from _claims(WHEEL, np.array(errors), np.array(held), effort)


def _motion(row: BenchRecording, ratio: float) -> WheelMotion:
    wheel, motor, torque = row.experiment.measured.T
    return WheelMotion(wheel, motor / ratio, torque, row.sample_time)


def _intervals(effort: Effort) -> Iterator[Item]:
    fit = ColumnFit(_start(), (*WHEEL, *MOTOR))
    first = fit.run(experiments(recorded(bench(), 1, seconds=SHORT), _start()))
    errors, held = [], []
    for seed in range(_count(effort)):
        again = fit.run(experiments(recorded(bench(), 2000 + seed, seconds=SHORT), _start()), near=first)
        found = [each for each in again.found({}) if each.name in MOTOR]
        errors.append([_error(each.name, each.value) for each in found])
        held.append([each.low < getattr(truth(), each.name) < each.high for each in found])
    yield _table(f"Motor and friction by likelihood, {SHORT:g} s each", MOTOR, np.array(errors), np.array(held))
    yield from _claims(MOTOR, np.array(errors), np.array(held), effort)


def _table(title: str, names: tuple[str, ...], errors: np.ndarray, held: np.ndarray) -> Table:
    rows = tuple(
        (name, f"{np.mean(e):+.3f}", f"{np.std(e):.3f}", f"{np.max(np.abs(e)):.3f}", f"{np.sum(h)}")
        for name, e, h in zip(names, errors.T, held.T, strict=True)
    )
    header = ("parameter", "bias (%)", "standard deviation (%)", "largest error (%)", "intervals that hold")
    return Table(f"{title}, {len(errors)} recordings", header, rows)


def _claims(names: tuple[str, ...], errors: np.ndarray, held: np.ndarray, effort: Effort) -> Iterator[Claim]:
    for name, error, hold in zip(names, errors.T, held.T, strict=True):
        slug, words = name.replace("_", "-"), name.replace("_", " ")
        yield Claim(
            f"identification.{slug}",
            f"The {words} is found on an exact bench.",
            GOAL,
            None,
            float(np.max(np.abs(error))),
            at_most(LIMITS[name]),
            "%",
            f"Largest error of {len(errors)} recordings.",
        )
        goal: Goal = at_least(float(round(COVERING / SEEDS * _count(effort))))
        yield Claim(
            f"identification.{slug}-interval",
            f"The 95 % interval of the {words} holds the truth.",
            GOAL,
            None,
            float(np.sum(hold)),
            goal,
            "",
            f"Of {len(errors)} recordings.",
        )


def _cases(effort: Effort) -> list[Case]:
    found = [
        Case("exact", bench(), {}),
        Case("motor torque noise 0.01 N·m", bench(), {"torque_noise": 0.01}),
        Case("cogging 0.01 N·m", bench(cogging=0.01), {}, judged=False),
        Case("cogging 0.01 N·m, ripple 1 %", bench(cogging=0.01, ripple=0.01), {}, False, False),
        Case("torque constant +2 %", bench(), {"torque_gain": 1.02}, False),
        *(Case(name, bench(law), {}, False, False) for name, law in LAWS.items()),
    ]
    return [replace(found[1], compared=False)] if effort.quick else found


def _unknown(effort: Effort) -> Iterator[Item]:
    rows, claims = [], []
    for case in _cases(effort):
        seconds = SHORT if effort.quick else None
        recordings = experiments(recorded(case.plant, 11, **case.motor, seconds=seconds), _start())
        fitted = ColumnFit(_start(), (*WHEEL, *MOTOR)).run(recordings)
        found = {each.name: each.value for each in fitted.found({})}
        errors = [_error(name, found[name]) for name in MOTOR]
        gain = 100.0 * (fitted.estimate["motor_torque_gain"] - 1.0)
        unknown = fitted.estimate.input_deviation[0]
        cells = (*(f"{error:+.2f}" for error in errors), f"{gain:+.2f}", f"{unknown:.4f}")
        rows.append((case.name, "likelihood", *cells))
        if case.compared:
            rows.append((case.name, "output error", *_simulated(fitted, recordings)))
        claims.append(_bias(case, dict(zip(MOTOR, errors, strict=True))))
    header = ("bench", "method", *(f"{name} (%)" for name in MOTOR), "motor torque gain (%)", "unrecorded torque (N·m)")
    note = (
        "The unrecorded torque is what the likelihood finds, per sample. Under another law of friction level and "
        "stiffness are those of the curve of Dahl that is nearest to it over the strokes driven, and the damping takes "
        "a part: that is a bias which no interval tells."
    )
    yield Table("What the model does not know: errors of one recording of each bench", header, tuple(rows), note)
    for claim in claims:
        yield from claim


def _simulated(fitted: Fitted, rows: list[BenchRecording]) -> tuple[str, ...]:
    """Errors of least squares of the output, from the same start."""
    wheel = {name: value for name, (value, _) in fitted.wheel.items()}
    free = tuple(each for each in fitted.estimate.free if each.name not in WHEEL)
    search = OutputError(SampledColumn, replace(_start(), **wheel), free, tuple(NOISE.values()), _STATES, most_steps=10)
    found = search.fit([row.experiment for row in rows])
    gain = 100.0 * (found["motor_torque_gain"] - 1.0)
    return (*(f"{_error(name, found[name]):+.2f}" for name in MOTOR), f"{gain:+.2f}", "–")


def _left_out() -> Iterator[Item]:
    """The paper's Figure 4 and its leave-one-out, on short experiments."""
    result = identify_column(_start(), recorded(bench(), 12, seconds=SHORT), (*WHEEL, *MOTOR))
    rows = tuple(
        (
            each.name,
            *(f"{_error(name, each.values[name]):+.3f}" for name in (*WHEEL, *MOTOR)),
            *(f"{100.0 * each.errors[name]:.2f}" if name in each.errors else "–" for name in NOISE),
        )
        for each in result.left_out
    )
    header = ("left out", *(f"{name} (%)" for name in (*WHEEL, *MOTOR)), *(f"NRMSE of {name} (%)" for name in NOISE))
    note = (
        "Errors of the parameters from the three other experiments, and of the simulation of the one left out, over "
        "the standard deviation of what was measured there. The noise of the bar's torque alone makes 1 to 2 %."
    )
    yield Table("Leave-one-out", header, rows, note)
    locked = next(each for each in result.shown if each.name == "sweep, wheel locked")
    marks = (
        Lines("measured", locked.time, locked.measured[:, 2]),
        Lines("simulated", locked.time, locked.simulated[:, 2], dashed=True),
    )
    yield Chart(
        "identification-matching",
        "Torque of the bar in a sweep with the wheel locked",
        "As in Figure 4 of the paper: the model is given the torque of the motor alone.",
        "Measured and simulated torque of the bar over time, one on the other",
        (Panel("", "time (s)", "torque of the bar (N·m)", marks),),
    )


def _bias(case: Case, errors: Mapping[str, float]) -> list[Claim]:
    """One claim per parameter; without a goal the error is told with its sign."""
    slug = "-".join("".join(c if c.isalnum() or c == "." else " " for c in case.name.lower()).split())
    slug = slug.replace("·", "-").replace("δ", "d")
    found = []
    for name, error in errors.items():
        goal = at_most(LIMITS[name]) if case.judged else None
        found.append(
            Claim(
                f"identification.{slug}.{name.replace('_', '-')}",
                f"Error of the {name.replace('_', ' ')} by likelihood: {case.name}.",
                GOAL if goal else "told, no goal",
                None,
                abs(error) if goal else error,
                goal,
                "%",
                "" if goal else "With its sign; a recording of 25 s.",
            )
        )
    return found
