"""Drives on which tierod's default friction monitor is judged: cars that differ, steps of friction, unknown laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.statuses import Status
from tierod_lab.ground import FrictionCourse
from tierod_lab.ground.chassis.tyres import TYRES
from tierod_lab.papers.friction.cases import HEALTHY, STATES, UNKNOWN_LAWS, Case
from tierod_lab.papers.friction.judging import FOUND, Course, Verdict, aligned, judged
from tierod_lab.papers.friction.reported import DRIVES, SEEDS, monitor
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Row

SLIGHT = (1.0, 2.0)
"""Range of the smallest added friction [N*m]: PWM 15 % of Table 1. Each car draws its own value from it."""

Level = tuple[float, float]  # Baseline of a car and its standard deviation [N*m]


def _on(case: Case, level: Level | None = None, changed_at: float | None = None) -> tuple[Course, Verdict]:
    return judged(aligned(case.recording(), monitor()), level, changed_at)


class FleetCar(NamedTuple):
    """A car of its own, driven fault-free and with each fault, on roads and tyres that differ from drive to drive."""

    number: int
    slight: float  # friction that PWM 15 % adds to this car [N*m]
    minutes: float


def fleet_cars(effort: Effort) -> list[FleetCar]:
    """48 cars."""
    chance = np.random.default_rng(1)
    cars = range(2 if effort.quick else 48)
    return [FleetCar(car, float(chance.uniform(*SLIGHT)), 5.0 if effort.quick else 7.0) for car in cars]


def over_fleet(car: FleetCar) -> list[Row]:
    """Cars with trail, damping, inertia and the gains and offsets of all sensors of their own, on all tyres.

    Every one is driven fault-free, which gives its baseline, and with each fault. The estimator assumes the nominal
    car. A gain common to both torques scales friction, and no signal reveals it: the part of the errors that the drawn
    gains explain is the floor of the standard deviation, for any estimator.
    """
    first, tyres = SEEDS.of(DRIVES, 1)[0], list(TYRES)
    own = first + 1000 + car.number
    levels = {**STATES, "PWM 15%": HEALTHY + car.slight}
    rows: list[Row] = []
    level: Level | None = None
    for place, (state, friction) in enumerate(levels.items()):
        route = first + (10_000 + car.number if not place else 20_000 + 1000 * (place - 1) + car.number)
        case = Case(route, friction, car.minutes, car=own, tyres=tyres[(car.number + place) % len(tyres)])
        course, verdict = _on(case, level)
        level = level if place else verdict.level
        gains = {f"{name}_gain": case.setup().sensors[name].gain for name in ("driver_torque", "motor_torque")}
        missed = float(state != "Healthy" and verdict.status not in FOUND)
        error = course.mean - friction
        rows.append(
            {"car": car.number, "state": state, "level": friction, "error": error, "relative": error / friction,
             "missed": missed, "said": str(verdict.status), **gains}
        )  # fmt: skip
    return rows


def with_floor(made: Sequence[Sequence[Row]]) -> list[Row]:
    """The rows of all cars with the part of the error that both torque gains explain, by health state."""
    rows = [dict(row) for car in made for row in car]
    for state in STATES:
        own = [row for row in rows if row["state"] == state and math.isfinite(float(row["error"]))]
        errors = np.array([row["error"] for row in own], float)
        known = np.array([[row["driver_torque_gain"], row["motor_torque_gain"], 1.0] for row in own], float)
        known = known * np.array([[row["level"]] for row in own], float)
        # Three coefficients would fit three cars without any residual.
        if len(own) > 3:
            explained = known @ np.linalg.lstsq(known, errors, rcond=None)[0]
            for row, value in zip(own, explained, strict=True):
                row["floor"] = float(value)
    return [{"floor": math.nan, **row} for row in rows]


def step_drives(effort: Effort) -> list[tuple[int, float, float]]:
    """Number of a drive, friction after the step [N*m], duration [min]."""
    minutes, count = (8.0, 1) if effort.quick else (12.0, 12)
    return [(number, after, minutes) for after in (12.5, 5.5) for number in range(count)]


def over_steps(task: tuple[int, float, float]) -> list[Row]:
    """Friction steps up half-way through the drive of a car of its own; times are enabled time from the step."""
    number, after, minutes = task
    first, at = SEEDS.of(DRIVES, 1)[0], 30.0 * minutes
    case = Case(first + 30_000 + number, FrictionCourse.step(HEALTHY, after, at=at), minutes, car=first + 3000 + number)
    _, verdict = _on(case, changed_at=at)
    return [{"after": after, "delay": verdict.delay, "early": float(verdict.early)}]


def law_drives(effort: Effort) -> list[tuple[str, tuple[int, ...], float]]:
    """Friction law, routes of the drives, duration [min]."""
    first = SEEDS.of(DRIVES, 1)[0]
    routes, minutes = ((7001,), 5.0) if effort.quick else ((7001, 7002), 7.0)
    laws = UNKNOWN_LAWS[:1] if effort.quick else UNKNOWN_LAWS
    return [(law, tuple(first + each for each in routes), minutes) for law in laws]


def over_laws(task: tuple[str, tuple[int, ...], float]) -> list[Row]:
    """The estimator models friction that builds up over an angle by three shapes; real friction may follow another law.

    Then the value may be biased, but a change from the car's baseline must still be found.
    """
    law, routes, minutes = task
    level = _on(Case(SEEDS.of(DRIVES, 1)[0] + 7000, HEALTHY, minutes, law=law))[1].level
    rows: list[Row] = []
    for friction in STATES.values():
        for route in routes:
            course, verdict = _on(Case(route, friction, minutes, law=law), level)
            right = (Status.HEALTHY,) if friction == HEALTHY else FOUND
            wrong = float(verdict.status not in right)
            rows.append({"law": law, "level": friction, "error": course.mean - friction, "wrong": wrong})
    return rows
