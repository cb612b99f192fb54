"""Sensitivity of the default observers to wrong parameters and sensors, other columns and other friction laws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.design import ColumnTuning
from tierod.monitors.driver_torque.observer import ColumnObserver, DelayedHandTorque
from tierod_lab.ground.cars.column_bench import ColumnBench
from tierod_lab.ground.steering.friction import DryFriction
from tierod_lab.ground.steering.friction_laws import Coulomb, Dahl, DahlPower, Law, LuGre, MaxwellSlip, Stribeck
from tierod_lab.papers.column.column_friction import ColumnFrictionObserver
from tierod_lab.papers.column.parameter_sets import SETS, bench_of
from tierod_lab.papers.column.reported import SEEDS, SENSITIVITY
from tierod_lab.papers.column.swept_bench import (
    DELAY,
    GOAL,
    HANDS,
    SIGNALS,
    Change,
    Errors,
    SweptBench,
    errors,
    known_column,
    over_hands,
    samples,
    swept,
)
from tierod_lab.studies.effort import Effort

OFFSET = 0.05
"""Offset of the torque of the torsion bar [N m]."""

MOTOR_NOISE = 0.01
"""Standard deviation of noise on the motor torque at its shaft [N m]; 0.18 at the steering wheel axis."""

_INERTIA = "steering_wheel_inertia"
_WRONG = (
    ("inertia of the wheel", _INERTIA, (0.9, 0.98, 1.02, 1.1)),
    ("damping of the wheel", "steering_wheel_damping", (0.9, 1.1)),
    ("stiffness of the bar", "torsion_bar_stiffness", (0.9, 1.1)),
    ("inertia of the motor", "motor_inertia", (0.9, 1.1)),
    ("damping of the motor", "motor_damping", (0.9, 1.1)),
    ("stiffness of the gear", "gear_stiffness", (0.9, 1.1)),
)
"""Wrong parameters: name in the table, field of `ColumnParameters`, and factors."""

WRONG_TEXT = (
    "Inertia and damping of the wheel enter the torque of the hands directly: at 3 Hz the wheel's inertia takes "
    "6.5 N·m, of which 2 % are an amplitude of 0.13 N·m. No observer can know better; a car's own inertia has to be "
    "identified with hands off the wheel.",
    "An offset of the bar looks like a twist that the angles do not confirm. It is learnt where the angles are known "
    "to be zero on the unloaded bar (tuning with offset='driver_torque'). Where they are not, the same misfit is put "
    "down to the angles: that leaves the offset of the bar in the torque of the hands but keeps it out of the rest.",
    "Everywhere else in this part the torque of the motor is known exactly and all signals are of one instant; what "
    "sensors cost of which gain, noise or time differs from the assumed one is at the end of the table.",
)


def with_wrong_parameters(effort: Effort) -> Iterator[Item]:
    """Table and claims on wrong parameters and sensors."""
    found = _found(effort)
    yield Heading("Wrong parameters", WRONG_TEXT)
    header = ("wrong", "steps", "ramps", "no hands", "NIS per output")
    rows = tuple((what, *_cells(each)) for what, each in found.items())
    yield Table("Root mean square error of the torque of the hands, default observer (N·m)", header, rows)
    yield Claim(
        "torque.wheel-inertia",
        "Error of the default observer with the inertia of the wheel wrong by 2 %, hands that pull within 100 ms.",
        GOAL,
        None,
        max(found[f"inertia of the wheel {sign}2 %"]["ramps"].hand_torque for sign in "+-"),
        at_most(0.055),
        "N*m",
        "The larger of +2 and -2 %. The error grows with the square of the frequency: a sweep that stays longer at "
        "high ones, as the linear one in the table, has more of it.",
    )
    yield Claim(
        "torque.bar-offset",
        "Error with an offset of the bar of 0.05 N·m, learnt because the angles are zero on the unloaded bar.",
        GOAL,
        None,
        found["bar +0.05 N·m, learnt"]["ramps"].hand_torque,
        at_most(0.04),
        "N*m",
        "Hands that pull within 100 ms.",
    )


def _found(effort: Effort) -> dict[str, dict[str, Errors]]:
    known = known_column()
    found = {"nothing": _errors(known, effort)}
    for what, name, factors in _WRONG:
        for factor in factors:
            found[f"{what} {100.0 * (factor - 1.0):+.0f} %"] = _errors(_wrong(known, name, factor), effort)
    slightly = ColumnObserver.of_parameters(_wrong(known, _INERTIA, 1.02))
    found["inertia of the wheel +2 %, linear sweep"] = over_hands(slightly, effort, pace="linear")
    for what, tuning in _OFFSETS.items():
        found[what] = over_hands(ColumnObserver.of_parameters(known, tuning=tuning), effort, change=_with_offset)
    for what, change in SENSORS.items():
        found[what] = over_hands(ColumnObserver.of_parameters(known), effort, change=change)
    return found


_OFFSETS = {
    "bar +0.05 N·m, not learnt": ColumnTuning(),
    "bar +0.05 N·m, taken for an offset of the motor's angle": ColumnTuning(offset="motor_angle_mechanical"),
    "bar +0.05 N·m, learnt": ColumnTuning(offset="driver_torque"),
}
"""Tunings of the observer for an offset of the torsion bar, by name."""


def _with_offset(samples: np.ndarray) -> np.ndarray:
    return np.asarray(samples + np.array([0.0, 0.0, 0.0, OFFSET]))


def _scaled(column: int, factor: float) -> Change:
    return lambda samples: samples * np.where(np.arange(samples.shape[1]) == column, factor, 1.0)


def _noisy_motor(samples: np.ndarray) -> np.ndarray:
    noise = np.random.default_rng(SEEDS.of(SENSITIVITY, 1)[0]).normal(0.0, MOTOR_NOISE, len(samples))
    return np.asarray(samples + noise[:, None] * np.array([1.0, 0.0, 0.0, 0.0]))


def _late_bar(samples: np.ndarray) -> np.ndarray:
    late = samples.copy()
    late[1:, _BAR] = samples[:-1, _BAR]
    return late


_MOTOR, _BAR = SIGNALS.index("motor_torque"), SIGNALS.index("driver_torque")
SENSORS: dict[str, Change] = {
    "gain of the bar's sensor +2 %": _scaled(_BAR, 1.02),
    "bar's torque 1 ms late": _late_bar,
    "torque of the motor +2 %": _scaled(_MOTOR, 1.02),
    f"noise of {MOTOR_NOISE} N·m on the torque of the motor": _noisy_motor,
}
"""Sensor errors by name, as functions from correct to wrong samples."""


def _wrong(known: ColumnParameters, name: str, factor: float) -> ColumnParameters:
    return replace(known, **{name: factor * getattr(known, name)})


def _errors(column: ColumnParameters, effort: Effort) -> dict[str, Errors]:
    return over_hands(ColumnObserver.of_parameters(column), effort)


def _cells(found: dict[str, Errors]) -> tuple[str, ...]:
    return (*(f"{each.hand_torque:.3f}" for each in found.values()), f"{found['ramps'].nis / 3.0:.2f}")


LAWS: Mapping[str, Law] = {
    "Dahl, as on the bench": Dahl(0.05),
    "Dahl, exponent 0.5": DahlPower(0.05, 0.5),
    "Dahl, exponent 2": DahlPower(0.05, 2.0),
    "Maxwell slip": MaxwellSlip(),
    "Stribeck": Stribeck(),
    "LuGre": LuGre(),
    "Coulomb": Coulomb(),
}
"""Friction laws of the plant, all of the level 0.1 N·m."""

ELSEWHERE_TEXT = (
    "The three columns have the eigenvalues of the paper's table 3 and differ in wheel, bar and ratio; each observer "
    "has the numbers of its column, the noises stay those tuned on S1. The friction laws are all of 0.1 N·m: the "
    "default knows none of them, the observer that knows Dahl's law assumes the one of the bench.",
)
_COLUMNS_HEADER = ("column", "steps", "ramps", "no hands", "steps, 20 ms later", "ramps, 20 ms later")
_LAWS_HEADER = ("friction of the bench", "torque of the hands", "disturbance torque", "by Dahl's law", "level found")
_SEED = 11


def elsewhere(effort: Effort) -> Iterator[Item]:
    """Tables and claims on other columns and other friction laws."""
    yield Heading("Other columns, other friction", ELSEWHERE_TEXT)
    sets = list(SETS)[:1] if effort.quick else list(SETS)
    columns = {name: _column(SETS[name]) for name in sets}
    rows = tuple((name, *(f"{value:.3f}" for value in found)) for name, found in columns.items())
    yield Table("Error of the torque of the hands (N·m)", _COLUMNS_HEADER, rows)
    laws = list(LAWS)[:2] if effort.quick else list(LAWS)
    found = {name: _law(name) for name in laws}
    rows = tuple((name, *(f"{value:.4f}" for value in values)) for name, values in found.items())
    yield Table("Errors under other laws of friction, hands with ramps (N·m)", _LAWS_HEADER, rows)
    yield Claim(
        "torque.columns",
        "Error of the default observer on every column of the three, hands that jump.",
        GOAL,
        None,
        max(values[0] for values in columns.values()),
        at_most(0.07),
        "N*m",
        "The largest of three.",
    )
    yield Claim(
        "torque.friction-laws",
        "Error of the default observer's torque of the hands under every law of friction, ramps.",
        GOAL,
        None,
        max(values[0] for values in found.values()),
        at_most(0.04),
        "N*m",
        "The largest of seven.",
    )


def _column(p: ColumnParameters) -> tuple[float, ...]:
    """Errors of default and delayed observer on a column with known parameters [N m]."""
    now, later = ColumnObserver.of_parameters(p), DelayedHandTorque.of_parameters(p)
    runs = {hands: [swept(hands, 40.0, _SEED, SweptBench(bench_of(p)))] for hands in HANDS}
    at_once = [errors(now, each).hand_torque for each in runs.values()]
    return (*at_once, *(errors(later, runs[hands], DELAY).hand_torque for hands in ("steps", "ramps")))


def _law(name: str) -> tuple[float, ...]:
    """Under a friction law: errors of hand and disturbance torque, disturbance error by Dahl's law, level [N m]."""
    run = swept("ramps", 40.0, _SEED, SweptBench(ColumnBench(friction=DryFriction(level=0.1, law=LAWS[name]))))
    default = ColumnObserver.of_parameters(known_column())
    by_law = ColumnFrictionObserver.of_parameters(known_column(), 0.05)
    found, known = errors(default, [run]), errors(by_law, [run])
    level = float(scan(by_law, samples(run))["friction_level"][-1])
    return found.hand_torque, found.disturbance_torque, known.disturbance_torque, level
