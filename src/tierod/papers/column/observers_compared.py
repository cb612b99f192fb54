"""The paper's observers of the column beside tierod's own: errors, claims, and a figure like the paper's figure 10."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.block import Block
from tierod.core.claims import Claim, at_most, between
from tierod.core.content import Chart, Item, Lines, Panel, Table
from tierod.core.graph import scan
from tierod.experiments.effort import Effort
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.delayed import DelayedHandTorque
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod.monitors.driver_torque.printed import COLUMNS, PrintedObserver
from tierod.papers.column.column_friction import ColumnFrictionObserver, FrictionTuning
from tierod.papers.column.observer_runs import Errors, drive, errors, over_hands, samples, seeds
from tierod.vehicles import load

DELAY = 20
"""Samples of the output with a lag: 20 ms."""
OWN = "Raffone, section 5, with noises of our own"
GOAL = "goal of tierod"


def believed() -> ColumnParameters:
    """The bench's column as the vehicle file gives it: right, unless it is made wrong."""
    return load("column-bench").parameters_for(ColumnParameters)


def observers() -> dict[str, tuple[Block, int]]:
    """Every observer with its lag in samples."""
    known = believed()
    found: dict[str, tuple[Block, int]] = {
        f"paper: {column}": (PrintedObserver.of_column(known, column), 0) for column in COLUMNS
    }
    found["tierod: default"] = (ColumnObserver.of_parameters(known), 0)
    found["tierod: 20 ms later"] = (DelayedHandTorque.of_parameters(known), DELAY)
    found["tierod: friction known by its law"] = (ColumnFrictionObserver.of_vehicle(load("column-bench")), 0)
    return found


def items(effort: Effort) -> Iterator[Item]:
    """Table, claims and chart."""
    found = {name: over_hands(block, effort, delay) for name, (block, delay) in observers().items()}
    header = ("observer", "steps", "ramps", "no hands", "disturbance torque")
    rows = [(name, *_cells(each)) for name, each in found.items()]
    note = (
        "The last column is the error of the torque of friction at the motor, of 0.1 N·m; the others are errors of the "
        "torque of the hands. The observer that knows Dahl's law has one filter for all that hands may do."
    )
    yield Table("Root mean square errors (N·m)", header, tuple(rows), note)
    yield from _paper_claims(found)
    yield from _own_claims(found, effort)
    yield _chart(effort)


def _cells(each: dict[str, Errors]) -> tuple[str, ...]:
    torques = [f"{each[hands].hand_torque:.3f}" for hands in ("steps", "ramps", "free")]
    disturbance = each["ramps"].disturbance_torque
    return (*torques, "" if np.isnan(disturbance) else f"{disturbance:.4f}")


def _paper_claims(found: dict[str, dict[str, Errors]]) -> Iterator[Claim]:
    printed = {name: each["steps"].hand_torque for name, each in found.items() if name.startswith("paper")}
    full = printed["paper: full"]
    yield Claim(
        "torque.paper-full",
        "Error of the paper's observer on the full column, hands that jump.",
        OWN,
        None,
        full,
        between(0.11, 0.13),
        "N*m",
        "A scaled Kalman filter of all eight states works: the reduction is not needed for observability.",
    )
    yield Claim(
        "torque.paper-reduced",
        "Both reductions, with any spring and with or without feed-through, are as good as the full column.",
        OWN,
        None,
        max(abs(value / full - 1.0) for value in printed.values()),
        at_most(0.05),
        "",
        "Largest relative difference between the errors of the six observers and that of the full one.",
    )


def _own_claims(found: dict[str, dict[str, Errors]], effort: Effort) -> Iterator[Claim]:
    default, later = found["tierod: default"], found["tierod: 20 ms later"]
    cases = (
        ("default-steps", "hands that jump", default["steps"].hand_torque, 0.07),
        ("default-ramps", "hands that pull within 100 ms", default["ramps"].hand_torque, 0.04),
        ("later-steps", "20 ms later, hands that jump", later["steps"].hand_torque, 0.04),
        ("later-ramps", "20 ms later, hands that pull within 100 ms", later["ramps"].hand_torque, 0.015),
    )
    for name, what, value, goal in cases:
        yield Claim(
            f"torque.{name}", f"Error of the default observer, {what}.", GOAL, None, value, at_most(goal), "N*m"
        )
    yield Claim(
        "torque.disturbance",
        "Error of the disturbance torque, friction unknown.",
        GOAL,
        None,
        default["ramps"].disturbance_torque,
        at_most(0.018),
        "N*m",
    )
    known = believed()
    for name, what, level, angle, limit in (
        ("friction", "by its law, level known", 0.1, 0.05, at_most(0.004)),
        ("friction-level", "by its law, level half of the true one at the start", 0.05, 0.05, at_most(0.004)),
        ("friction-angle", "by its law with twice the true angle, level half", 0.05, 0.1, None),
    ):
        block = ColumnFrictionObserver.of_parameters(known, angle, friction=FrictionTuning(level=level))
        value = errors(block, "ramps", effort).disturbance_torque
        claim = f"Error of the disturbance torque, friction {what}."
        yield Claim(f"torque.{name}", claim, GOAL, None, value, limit, "N*m")


_SHOWN = ("paper: series spring", "paper: balanced", "tierod: default", "tierod: 20 ms later")


def _chart(effort: Effort) -> Chart:
    run = drive("steps", seeds(effort)[0])
    time = run["time"]
    window = (time > 21.0) & (time < 29.0)
    thin = np.flatnonzero(window)[::5]
    marks = []
    for name in _SHOWN:
        block, delay = observers()[name]
        torque = scan(block, samples(run))["hand_torque"]
        marks.append(Lines(name, time[thin] - 1e-3 * delay, torque[thin]))
    marks.append(Lines("true", time[thin], run["hand_torque"][thin], dashed=True))
    angle = np.degrees(run["steering_wheel_angle"][thin])
    return Chart(
        "column-hand-torque",
        "A pull of 2 N·m during the sweep",
        "The estimate with a lag is drawn where it belongs, 20 ms before it is known.",
        "Angle of the steering wheel swinging by 30 degrees; below, the torque of the hands rising to 2 N·m and back, "
        "with noise of 0.1 N·m for the paper's observers and next to none for tierod's.",
        (
            Panel("Steering wheel", "time (s)", "angle (°)", (Lines("steering wheel", time[thin], angle),)),
            Panel("Torque of the hands", "time (s)", "torque (N·m)", tuple(marks)),
        ),
    )
