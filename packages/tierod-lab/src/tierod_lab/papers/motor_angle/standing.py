"""The default observer where the angle is not observable: at standstill, and after a wrong initial angle."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.claims import Claim, Goal, at_least, at_most
from tierod.core.content import Band, Chart, Heading, Item, Lines, Mark, Panel, Table
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod_lab.papers.motor_angle.fault_drives import RATE, SUBSTEPS, bench_time
from tierod_lab.papers.motor_angle.observer_drives import (
    ObserverDrive,
    bench,
    drive,
    electrical,
    methods,
    of_another_motor,
    parameters,
    to_and_fro,
    with_true,
)
from tierod_lab.papers.motor_angle.reported import SEEDS, STANDING, TARGET
from tierod_lab.studies.effort import Effort

WITHIN, KEPT = 0.03, 0.1
"""Settling criterion: error of the angle modulo whole electrical turns [rad], and time it must stay below that [s]."""
BEGUN_SPEED = 1.0
"""Speed above which a starting motor counts as turning [rad/s]."""
WATCHED = 2.0
"""Time for which the observer is watched after a wrong initial angle [s]."""


def within_a_turn(angle: np.ndarray) -> np.ndarray:
    """Angle of the shaft modulo whole electrical turns [rad]."""
    return electrical(angle) / parameters()[1].motor_pole_pairs


def settled(wrong: np.ndarray) -> float:
    """Settling time, after which nothing is wrong for `KEPT`; infinite where that never occurs [s].

    Args:
        wrong: whether each sample is wrong, (n,)
    """
    kept = round(KEPT * RATE)
    summed = np.concatenate([[0], np.cumsum(wrong)])
    good = np.flatnonzero(summed[kept:] == summed[:-kept])
    return float(good[0]) / RATE if len(good) else math.inf


def settling(error: float, begins: str, trials: int) -> np.ndarray:
    """Settling times of the observer after a wrong initial angle [s].

    Args:
        error: error of the sensor, of random sign [rad]
        begins: "from rest" or "reversing"
        trials: number of trials
    """
    found = []
    for trial in range(trials):
        random = np.random.default_rng([SEEDS.of(STANDING, trials)[trial], 9])
        seen, start = BEGINNINGS[begins](trial, random)
        samples = seen.samples.copy()
        samples[:, 4] += error * random.choice((-1.0, 1.0))
        away = within_a_turn(replace(seen, samples=samples).error(of_another_motor(random)))
        found.append(settled(np.abs(away[start:]) > WITHIN))
    return np.array(found)


def _from_rest(trial: int, random: np.random.Generator) -> tuple[ObserverDrive, int]:
    time = bench_time(WATCHED)
    speed = random.uniform(20.0, 100.0) * random.choice((-1.0, 1.0)) * np.clip((time - 0.3) / 0.05, 0.0, 1.0)
    seen = drive(bench(), np.cumsum(speed) * SUBSTEPS / RATE, np.zeros(len(time)), SEEDS.of(STANDING, trial + 1)[trial])
    return seen, int(np.argmax(np.abs(seen.speed) > BEGUN_SPEED))


def _reversing(trial: int, random: np.random.Generator) -> tuple[ObserverDrive, int]:
    seen, length = to_and_fro(SEEDS.of(STANDING, 6)[trial % 6], 20.0), round(WATCHED * RATE)
    # A trial begins shortly before a reversal, after a second of the drive and early enough to be watched in full.
    turns = np.flatnonzero(np.diff(np.sign(seen.speed)) != 0.0)
    turns = turns[(turns > RATE) & (turns < len(seen.speed) - length)]
    begin = int(random.choice(turns) - random.integers(0, round(0.1 * RATE)))
    part = slice(begin, begin + length)
    cut = {name: values[part] for name, values in vars(seen).items() if values is not None}
    return ObserverDrive(**cut), 0


BEGINNINGS: dict[str, Callable[[int, np.random.Generator], tuple[ObserverDrive, int]]] = {
    "from rest": _from_rest,
    "reversing": _reversing,
}
"""Functions that return a drive and the sample from which the time counts, by name of the start."""


def _wrong_beginnings(trials: int) -> Iterator[Item]:
    """Settling times by size of the initial error.

    Args:
        trials: number of trials of every size
    """
    errors = (0.1, 0.3, 0.5, 0.75)
    found = {(begins, error): settling(error, begins, trials) for begins in BEGINNINGS for error in errors}
    rows = tuple(
        (f"{begins}, {error:g} rad", *(_milliseconds(each, share) for share in (0.5, 0.95, 1.0)))
        for (begins, error), each in found.items()
    )
    note = (
        f"{trials} trials each; a quarter of an electrical turn is 0.39 rad, half of one 0.79 rad. ∞: not within "
        f"{WATCHED:g} s."
    )
    yield Table(
        "Time until the error of a wrong beginning stays below 0.03 rad [ms]",
        ("", "median", "95 %", "most"),
        rows,
        note,
    )
    for begins, goal in (("from rest", 0.1), ("reversing", 0.3)):
        values = found[begins, 0.3]
        yield Claim(
            f"standing.begin-{begins.replace(' ', '-')}",
            f"A first error of 0.3 rad, {begins}, is gone: 95 % of the time to 0.03 rad.",
            TARGET,
            None,
            float(np.quantile(values, 0.95, method="higher")),
            at_most(goal),
            "s",
            f"median {np.median(values):.3f} s, most {values.max():.3f} s of {trials}",
        )


def _milliseconds(values: Sequence[float] | np.ndarray, share: float) -> str:
    value = 1e3 * float(np.quantile(values, share, method="higher"))
    return f"{value:.0f}" if math.isfinite(value) else "∞"


MOVING, HELD, AFTER = 5.6, 10.0, 5.0
"""Time in which the motor turns, is then held against the load, and turns again [s]."""
WARMER = 1.2
"""True resistance over the assumed one."""


class Held(NamedTuple):
    """Behaviour of an observer while the motor is held at standstill.

    Args:
        drift: drift of the error of the angle from the first to the last second [rad]
        early, late: stated standard deviation after half a second and at the end [rad]
        back: time from turning again until the angle is valid [s]
    """

    drift: float
    early: float
    late: float
    back: float


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Standing, and a wrong beginning",
        (
            f"The bench's motor turns for {MOVING:g} s, is held against 0.8 N·m for {HELD:g} s, and turns on. "
            "Held, its currents show nothing: the observer goes on by the increments of the sensor and says so by a "
            "variance that grows. It knows its angle again when it claims less than 0.03 rad and is right within.",
            "A wrong beginning: the sensor is off by a constant when the observer begins. From rest, the motor then "
            f"starts one way, and the time counts from {BEGUN_SPEED:g} rad/s; reversing, the motor turns the other way "
            "within a tenth of a second. Resistance, flux and inductance differ from the file's.",
        ),
    )
    seeds = SEEDS.of(STANDING, 2 if effort.quick else 6)
    held = {name: [standing(observer, held_drive(seed)) for seed in seeds] for name, observer in _observers().items()}
    yield _held_table(held)
    yield _held_chart(held_drive(seeds[0]))
    yield from _held_claims(held)
    yield from _wrong_beginnings(6 if effort.quick else 60)


def held_drive(seed: int) -> ObserverDrive:
    """Simulate a drive in both directions, a standstill, and the continued drive.

    Args:
        seed: seed of noise and place
    """
    time = bench_time(MOVING + HELD + AFTER)
    moving = np.where(time < MOVING + HELD, np.minimum(time, MOVING), time - HELD)
    # A quarter of a period ends where the motor is held, so that it stops at its largest angle.
    rate = 2.0 * np.pi * (0.25 + np.random.default_rng(seed).integers(1, 4)) / MOVING
    return drive(bench(), 10.0 * np.sin(rate * moving) * np.clip(2.0 * time, 0.0, 1.0), np.zeros(len(time)), seed)


def standing(observer: Block, seen: ObserverDrive) -> Held:
    """Behaviour of an observer on a drive of `held_drive`."""
    found = seen.observed(observer)
    away, deviation = found["motor_angle"] - seen.angle, found["motor_angle_standard_deviation"]
    first, second, last, end = (
        round(second * RATE) for second in (MOVING + 0.5, MOVING + 1.5, MOVING + HELD - 1.0, MOVING + HELD)
    )
    turning = end + int(np.argmax(np.abs(seen.speed[end:]) > BEGUN_SPEED))
    known = (deviation[turning:] < WITHIN) & (np.abs(within_a_turn(away[turning:])) < WITHIN)
    drift = abs(float(away[last:end].mean() - away[first:second].mean()))
    return Held(drift, float(deviation[first]), float(deviation[end - 1]), settled(~known))


def _observers() -> dict[str, MotorAngleObserver]:
    p = parameters()[1]
    return {
        "resistance as assumed": MotorAngleObserver(p),
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
    found = seen.observed(MotorAngleObserver(parameters()[1]))
    time, deviation = seen.time[part], 2.0 * found["motor_angle_standard_deviation"][part]
    marks: list[Mark] = [Band("default", time, -deviation, deviation)]
    others = methods()
    names = ("Luenberger, with load", "Kalman filter, with load")
    for name, observer in (*((name, others[name]) for name in names), ("default", None)):
        away = (found if observer is None else seen.observed(observer))["motor_angle"] - seen.angle
        marks.append(Lines(name, time, away[part] - away[part][0]))
    return Chart(
        "motor-angle-held",
        "An observer's angle while the motor is held (Figure 7)",
        f"Held from {MOVING:g} to {MOVING + HELD:g} s. Errors from the begin of the section on; the band is twice the "
        "standard deviation that the default claims. The others integrate a speed and turn by the measured angle.",
        "Errors of three observers while the motor stands: the default stays, and its band grows.",
        (Panel("", "time (s)", "error of the angle (rad)", tuple(marks)),),
    )


def _held_claims(held: dict[str, list[Held]]) -> Iterator[Claim]:
    every = [each for found in held.values() for each in found]
    note = "worst of all drives, with the right and with a warmer winding"

    def claim(key: str, text: str, measured: float, goal: Goal, unit: str) -> Claim:
        return Claim(f"standing.{key}", text, TARGET, None, measured, goal, unit, note)

    drift = max(each.drift for each in every)
    yield claim("drift", "Held for 10 s by a torque the angle does not drift.", drift, at_most(0.001), "rad")
    growth = min(each.late / each.early for each in every)
    yield claim("variance", "The standard deviation grows meanwhile: late over early.", growth, at_least(1.5), "")
    back = 1e3 * max(each.back for each in every)
    yield claim("known-again", "The angle is known again when the motor turns on.", back, at_most(50.0), "ms")
