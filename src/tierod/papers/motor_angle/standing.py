"""The default observer where the currents tell no angle: a motor that is held still, and a wrong beginning."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Band, Chart, Heading, Item, Lines, Panel, Table
from tierod.experiments.effort import Effort
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.papers.motor_angle import wrong_beginning
from tierod.papers.motor_angle.fault_drives import RATE, SUBSTEPS
from tierod.papers.motor_angle.observer_accuracy import methods, parameters
from tierod.papers.motor_angle.observer_drives import ObserverDrive, bench, drive
from tierod.papers.motor_angle.wrong_beginning import (
    BEGUN_SPEED,
    FIRST,
    TARGET,
    WITHIN,
    settled,
    with_true,
    within_a_turn,
)

MOVING, HELD, AFTER = 5.6, 10.0, 5.0
"""The motor turns, is held against the load, and turns on for so long [s]."""
WARMER = 1.2
"""Resistance over what the observer is told."""


class Held(NamedTuple):
    """What an observer tells of a motor that is held.

    Args:
        drift: of the angle from the first to the last second [rad]
        early, late: standard deviation that it tells, after the first second and at the end [rad]
        back: time from turning again until it knows the angle [s]
    """

    drift: float
    early: float
    late: float
    back: float


def items(effort: Effort) -> Iterator[Item]:
    """Held still for ten seconds, then a wrong first angle."""
    yield Heading(
        "Standing, and a wrong beginning",
        (
            f"The bench's motor turns for {MOVING:g} s, is held against 0.8 N·m for {HELD:g} s, and turns on. "
            "Held, its currents tell nothing: the observer goes on by the increments of the sensor and says so by a "
            "variance that grows. It knows its angle again when it tells less than 0.03 rad, and is right within that.",
            "A wrong beginning: the sensor is off by a constant when the observer begins. From rest, the motor then "
            f"starts one way, and the time counts from {BEGUN_SPEED:g} rad/s; reversing, the motor turns the other way "
            "within a tenth of a second. Resistance, flux and inductance differ from the file's.",
        ),
    )
    seeds = range(FIRST, FIRST + (2 if effort.quick else 6))
    held = {name: [standing(observer, held_drive(seed)) for seed in seeds] for name, observer in _told().items()}
    yield _held_table(held)
    yield _held_chart(held_drive(FIRST))
    yield from _held_claims(held)
    yield from wrong_beginning.items(6 if effort.quick else 60)


def held_drive(seed: int) -> ObserverDrive:
    """To and fro, held at one place, and on.

    Args:
        seed: of the noises and the place
    """
    time = np.arange(round((MOVING + HELD + AFTER) * RATE / SUBSTEPS)) * SUBSTEPS / RATE
    moving = np.where(time < MOVING + HELD, np.minimum(time, MOVING), time - HELD)
    # So that a quarter of the period ends where the motor is held: at the greatest angle.
    rate = 2.0 * np.pi * (0.25 + np.random.default_rng(seed).integers(1, 4)) / MOVING
    return drive(bench(), 10.0 * np.sin(rate * moving) * np.clip(2.0 * time, 0.0, 1.0), np.zeros(len(time)), seed)


def standing(observer: Any, seen: ObserverDrive) -> Held:
    """What an observer tells of such a drive."""
    told = seen.observed(observer)
    away, deviation = told["motor_angle"] - seen.angle, told["motor_angle_standard_deviation"]
    first, second, last, end = (
        round(second * RATE) for second in (MOVING + 0.5, MOVING + 1.5, MOVING + HELD - 1.0, MOVING + HELD)
    )
    turning = end + int(np.argmax(np.abs(seen.speed[end:]) > BEGUN_SPEED))
    known = (deviation[turning:] < WITHIN) & (np.abs(within_a_turn(away[turning:])) < WITHIN)
    drift = abs(float(away[last:end].mean() - away[first:second].mean()))
    return Held(drift, float(deviation[first]), float(deviation[end - 1]), settled(~known))


def _told() -> dict[str, MotorAngleObserver]:
    p = parameters()[1]
    return {
        "resistance as told": MotorAngleObserver(p),
        f"resistance {WARMER:g} times that": MotorAngleObserver(with_true(p, WARMER, 1.0, 1.0)),
    }


def _held_table(held: dict[str, list[Held]]) -> Table:
    rows = tuple(
        (
            name,
            f"{max(each.drift for each in found):.5f}",
            f"{np.mean([each.early for each in found]):.3f}",
            f"{np.mean([each.late for each in found]):.3f}",
            f"{1e3 * max(each.back for each in found):.0f}",
        )
        for name, found in held.items()
    )
    header = ("", "drift, worst [rad]", "deviation, early [rad]", "late [rad]", "known again after, worst [ms]")
    return Table(
        f"Held still for {HELD:g} s by 0.8 N·m of spring and dry friction",
        header,
        rows,
        f"{len(next(iter(held.values())))} drives each.",
    )


def _held_chart(seen: ObserverDrive) -> Chart:
    part = slice(round((MOVING - 0.6) * RATE), round((MOVING + HELD + 1.0) * RATE), 20)
    told = seen.observed(MotorAngleObserver(parameters()[1]))
    time, deviation = seen.time[part], 2.0 * told["motor_angle_standard_deviation"][part]
    marks: list[Any] = [Band("default", time, -deviation, deviation)]
    others = methods()
    names = ("Luenberger, with load", "Kalman filter, with load")
    for name, observer in (*((name, others[name]) for name in names), ("default", None)):
        away = (told if observer is None else seen.observed(observer))["motor_angle"] - seen.angle
        marks.append(Lines(name, time, away[part] - away[part][0]))
    return Chart(
        "motor-angle-held",
        "An observer's angle while the motor is held (Figure 7)",
        f"Held from {MOVING:g} to {MOVING + HELD:g} s. Errors from the begin of the section on; the band is twice the "
        "standard deviation that the default tells. The others integrate a speed and turn by the measured angle.",
        "Errors of three observers while the motor stands: the default stays, and its band grows.",
        (Panel("", "time (s)", "error of the angle (rad)", tuple(marks)),),
    )


def _held_claims(held: dict[str, list[Held]]) -> Iterator[Claim]:
    every = [each for found in held.values() for each in found]
    note = "worst of all drives, with the right and with a warmer winding"

    def claim(key: str, text: str, measured: float, goal: Any, unit: str) -> Claim:
        return Claim(f"standing.{key}", text, TARGET, None, measured, goal, unit, note)

    drift = max(each.drift for each in every)
    yield claim("drift", "Held for 10 s by a torque the angle does not drift.", drift, at_most(0.001), "rad")
    growth = min(each.late / each.early for each in every)
    yield claim("variance", "The standard deviation grows meanwhile: late over early.", growth, at_least(1.5), "")
    back = 1e3 * max(each.back for each in every)
    yield claim("known-again", "The angle is known again when the motor turns on.", back, at_most(50.0), "ms")
