"""The default observer after a wrong first angle: how soon it finds the right one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Item, Table
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.papers.motor_angle.fault_drives import RATE, SUBSTEPS
from tierod.papers.motor_angle.observer_accuracy import parameters
from tierod.papers.motor_angle.observer_drives import ObserverDrive, bench, drive, to_and_fro

WITHIN, KEPT = 0.03, 0.1
"""An angle is settled when its error stays below this [rad] for so long [s]; whole electrical turns left out."""
BEGUN_SPEED = 1.0
"""From this speed on a motor that starts is said to turn [rad/s]."""
WATCHED = 2.0
"""After a wrong beginning [s]."""
FIRST = 3000
"""Seed; those below were used while the observer was tuned."""
TARGET = "target of tierod"


def within_a_turn(angle: np.ndarray) -> np.ndarray:
    """An angle of the shaft without whole electrical turns [rad]."""
    pole_pairs = parameters()[1].motor_pole_pairs
    return np.angle(np.exp(1j * pole_pairs * angle)) / pole_pairs


def settled(wrong: np.ndarray) -> float:
    """Time after which nothing is wrong for `KEPT`; infinite where that never comes [s].

    Args:
        wrong: a value per sample
    """
    kept = round(KEPT * RATE)
    summed = np.concatenate([[0], np.cumsum(wrong)])
    good = np.flatnonzero(summed[kept:] == summed[:-kept])
    return float(good[0]) / RATE if len(good) else math.inf


def settling(error: float, begins: str, trials: int) -> np.ndarray:
    """Times in which the observer finds the angle after a wrong beginning [s].

    Args:
        error: of the sensor, either way [rad]
        begins: "from rest" or "reversing"
        trials: how many
    """
    found = []
    for trial in range(trials):
        random = np.random.default_rng([FIRST + trial, 9])
        seen, start = BEGINNINGS[begins](trial, random)
        samples = seen.samples.copy()
        samples[:, 4] += error * random.choice((-1.0, 1.0))
        told = replace(seen, samples=samples).observed(_another_motor(random))
        away = within_a_turn(told["motor_angle"] - seen.angle)
        found.append(settled(np.abs(away[start:]) > WITHIN))
    return np.array(found)


def _from_rest(trial: int, random: np.random.Generator) -> tuple[ObserverDrive, int]:
    time = np.arange(round(WATCHED * RATE / SUBSTEPS)) * SUBSTEPS / RATE
    speed = random.uniform(20.0, 100.0) * random.choice((-1.0, 1.0)) * np.clip((time - 0.3) / 0.05, 0.0, 1.0)
    seen = drive(bench(), np.cumsum(speed) * SUBSTEPS / RATE, np.zeros(len(time)), FIRST + trial)
    return seen, int(np.argmax(np.abs(seen.speed) > BEGUN_SPEED))


def _reversing(trial: int, random: np.random.Generator) -> tuple[ObserverDrive, int]:
    seen, length = to_and_fro(FIRST + trial % 6, 20.0), round(WATCHED * RATE)
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
"""Drives, and the sample from which the time counts."""


def _another_motor(random: np.random.Generator) -> MotorAngleObserver:
    p = parameters()[1]
    return MotorAngleObserver(
        with_true(p, random.uniform(0.8, 1.3), random.uniform(0.94, 1.02), random.uniform(0.93, 1.07))
    )


def with_true(p: SampledMotorParameters, resistance: float, flux: float, inductance: float) -> SampledMotorParameters:
    """Told parameters, where the true ones are so many times them."""
    return replace(
        p,
        motor_resistance=p.motor_resistance / resistance,
        motor_flux=p.motor_flux / flux,
        motor_inductance=p.motor_inductance / inductance,
    )


def items(trials: int) -> Iterator[Item]:
    """Time until the error is gone, by size.

    Args:
        trials: of every size
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
