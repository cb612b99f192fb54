"""The test drives: rounds, faults, and the share of their time in which the faults are observable."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.core.recording import Recording
from tierod_lab.papers.condition.drives import (
    ACTUATOR_SECONDS,
    LOSS,
    Drive,
    Injected,
    actuator_tests,
    lost,
    sensor_tests,
)
from tierod_lab.papers.condition.recorded import each, recorded
from tierod_lab.papers.condition.reported import USED, vehicles
from tierod_lab.papers.condition.tables import between, curves
from tierod_lab.papers.condition.truth import observable
from tierod_lab.papers.condition.vehicles import LONG, SHORT, THIRD
from tierod_lab.studies.effort import Effort

TEXT = (
    "The virtual demonstrator has two tracks, load transfer, tyres after Magic Formula with relaxation, a stiff rack "
    "of two bodies with dry friction, sensors with noise, steps and offsets, a road with slopes, bumps and wind. Its "
    "mass is 4 to 8 % off the monitor's first parameters, its cornering stiffness 5 to 10 %, its tyres' radius 2.5 to "
    "5 % and 0.3 to 0.6 % from side to side; every vehicle is drawn by its number.",
    "The rounds are redrawn in kind, since the paper prints no coordinates. It names no size of a fault either: here "
    "2 m/s, 0.3 rad/s, 1.5 rad, 3 N·m, 250 N for offsets of either sign, and three times the signal for an outlier.",
)


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("What is driven", TEXT)
    yield _demonstrators(effort)
    yield _rounds()
    yield from _shares(effort)
    yield _lost_yaw_rate()
    yield _torque_of_motor_one()


def _demonstrators(effort: Effort) -> Table:
    rows = tuple((f"{number}", f"{number + 10}", f"{number + 20}") for number in vehicles(effort))
    return Table(
        "Seeds of the reported drives",
        ("demonstrator, drawn by", "tests of sensors", "tests of actuators"),
        rows,
        "The numbers follow from the digest of the bank of filters of smartload, traced graph and tuning. Those "
        f"up to {USED} were driven while thresholds were chosen; none of them is reported.",
    )


def _rounds() -> Chart:
    panels = []
    for name in (SHORT, LONG, THIRD):
        made = recorded(Drive(name, 80.0, 0))
        x, y = (made[f"truth_position_{axis}"].values[::10] for axis in "xy")
        title = name.replace("-", " ")
        panels.append(Panel(title, "east [m]", "north [m]", (Lines(title, x, y),), to_scale=True))
    return Chart(
        "condition-rounds",
        "The three rounds (Figures 18, 19, 24)",
        "Ways that the demonstrator drove in 80 s.",
        "Three closed ways with many bends, seen from above.",
        tuple(panels),
    )


def _shown(drive: Drive, recording: Recording) -> tuple[str, str, float, float]:
    """Element, kind, observable share of the fault's time [-], and time from the fault until it is observable [s]."""
    injected = drive.injected[0]
    return injected.element, injected.kind, *observable(drive, recording)


def _shares(effort: Effort) -> Iterator[Item]:
    chosen = vehicles(effort)
    drives = [drive for number in chosen for drive in sensor_tests(number)]
    drives += [] if effort.quick else [drive for number in chosen for drive in actuator_tests(number)]
    found = each(_shown, drives, effort)
    rows = []
    for element, kind in dict.fromkeys((element, kind) for element, kind, _, _ in found):
        shares = [share for name, how, share, _ in found if (name, how) == (element, kind)]
        firsts = [first for name, how, _, first in found if (name, how) == (element, kind)]
        rows.append((f"{element} {kind}", f"{np.mean(shares):.3f}", f"{min(shares):.3f}", f"{max(firsts):.2f}"))
    yield Table(
        "Share of the time of a fault in which it is observable, and the latest first time [s]",
        ("fault", "mean", "least", "latest"),
        tuple(rows),
        "A fault is observable where, over 0.1 s, its likelihood ratio exceeds that of three standard deviations of "
        "the accuracy required of a reconfigured value. No diagnosis without memory can be right more often than that.",
    )


def _lost_yaw_rate() -> Chart:
    drive = Drive(SHORT, 60.0, 1, 11, (Injected("yaw_rate", LOSS),))
    made = recorded(drive)
    time, read, true = between(
        made["yaw_rate"].time, 15.0, 45.0, made["yaw_rate"].values, made["truth_yaw_rate"].values
    )
    return Chart(
        "condition-lost-yaw-rate",
        "A lost yaw rate (Figure 22)",
        "Where the true yaw rate passes zero, a lost reading equals it and is not detectable.",
        "A curve that swings about zero, and one that is zero between 20 and 40 s.",
        (curves("yaw rate", "yaw rate [rad/s]", time, {"true": true, "read": read}, 2),),
    )


def _torque_of_motor_one() -> Chart:
    drive = Drive(SHORT, ACTUATOR_SECONDS, 1, 21, (lost("steering_motor_1", start=123.5),))
    made = recorded(drive)
    columns = (made[name].values for name in ("steering_motor_1_target_torque", "truth_steering_motor_1_torque"))
    time, asked, given = between(made["yaw_rate"].time, 118.0, 130.0, *columns)
    return Chart(
        "condition-motor-torque",
        "Torque of steering motor 1 (Figure 28)",
        "Lost at 123.5 s, as in the paper; the torque asked for alternates between 65 and 35 % of the whole.",
        "Torque asked of a motor, and torque given, which is zero from 123.5 s on.",
        (curves("steering motor 1", "torque [N·m]", time, {"asked for": asked, "given": given}, 1),),
    )
