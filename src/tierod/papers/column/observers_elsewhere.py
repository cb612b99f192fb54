"""The default observers of the column on other columns, and under friction that they do not know."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan
from tierod.experiments.effort import Effort
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.delayed import DelayedHandTorque
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod.papers.column.column_friction import ColumnFrictionObserver
from tierod.papers.column.observer_runs import FROM, rms, samples
from tierod.papers.column.observers_compared import DELAY, GOAL, believed
from tierod.papers.column.parameter_sets import SETS
from tierod.papers.column.swept_bench import SweptBench, swept
from tierod.proving_ground.cars.column_bench import ColumnBench
from tierod.proving_ground.steering.friction import DryFriction
from tierod.proving_ground.steering.friction_laws import Coulomb, Dahl, DahlPower, Law, LuGre, MaxwellSlip, Stribeck

LAWS: Mapping[str, Law] = {
    "Dahl, as on the bench": Dahl(0.05),
    "Dahl, exponent 0.5": DahlPower(0.05, 0.5),
    "Dahl, exponent 2": DahlPower(0.05, 2.0),
    "Maxwell slip": MaxwellSlip(),
    "Stribeck": Stribeck(),
    "LuGre": LuGre(),
    "Coulomb": Coulomb(),
}
"""Friction of the plant, all of 0.1 N·m."""

TEXT = (
    "The three columns have the eigenvalues of the paper's table 3 and differ in wheel, bar and ratio; each observer "
    "has the numbers of its column, the noises stay those tuned on S1. The friction laws are all of 0.1 N·m: the "
    "default knows none of them, the observer that knows Dahl's law believes in the one of the bench.",
)
_COLUMNS_HEADER = ("column", "steps", "ramps", "no hands", "steps, 20 ms later", "ramps, 20 ms later")
_LAWS_HEADER = ("friction of the bench", "torque of the hands", "disturbance torque", "by Dahl's law", "level found")
_SEED = 11


def items(effort: Effort) -> Iterator[Item]:
    """Both tables and the claims."""
    yield Heading("Other columns, other friction", TEXT)
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
    """Errors of default and delayed observer on a column that they know."""
    plant = ColumnBench(
        wheel_inertia=p.steering_wheel_inertia,
        wheel_damping=p.steering_wheel_damping,
        bar_stiffness=p.torsion_bar_stiffness,
        gear_ratio=p.motor_ratio,
        gear_stiffness=p.gear_stiffness,
        gear_inertia=p.gear_inertia,
        motor_inertia=p.motor_inertia,
        motor_damping=p.motor_damping,
    )
    now, later = ColumnObserver.of_parameters(p), DelayedHandTorque.of_parameters(p)
    runs = {hands: swept(hands, 40.0, _SEED, SweptBench(plant)) for hands in ("steps", "ramps", "free")}
    at_once = [_error(scan(now, samples(run))["hand_torque"], run["hand_torque"], run) for run in runs.values()]
    late = []
    for hands in ("steps", "ramps"):
        told = scan(later, samples(runs[hands]))["hand_torque"][DELAY:]
        late.append(_error(told, runs[hands]["hand_torque"][:-DELAY], runs[hands]))
    return (*at_once, *late)


def _law(name: str) -> tuple[float, ...]:
    """Errors of the torque of the hands and of the disturbance torque, by both observers, and the level found."""
    bench = SweptBench(ColumnBench(friction=DryFriction(level=0.1, law=LAWS[name])))
    run = swept("ramps", 40.0, _SEED, bench)
    found = scan(ColumnObserver.of_parameters(believed()), samples(run))
    by_law = scan(ColumnFrictionObserver.of_parameters(believed(), 0.05), samples(run))
    return (
        _error(found["hand_torque"], run["hand_torque"], run),
        _error(found["disturbance_torque"], run["disturbance_torque"], run),
        _error(by_law["disturbance_torque"], run["disturbance_torque"], run),
        float(by_law["friction_level"][-1]),
    )


def _error(told: np.ndarray, true: np.ndarray, run: dict[str, np.ndarray]) -> float:
    counted = run["time"][: len(told)] > FROM
    return rms([(told - true)[counted]])
