"""Trade-off of noise against bandwidth: both observers with ever faster poles, and with Kalman gains."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Chart, Heading, Item, Lines, Panel
from tierod_lab.papers.sideslip.conventional import conventional_poles
from tierod_lab.papers.sideslip.estimators import Build, Course, built, error, observed
from tierod_lab.papers.sideslip.matching import matched
from tierod_lab.papers.sideslip.reported import SEEDS, SIDE_BY_SIDE
from tierod_lab.papers.sideslip.setting import FAST, RATE, SLOW, Drive, Driven, on
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.table import FAST_GOAL, GOAL, PAPER, SLOW_GOAL
from tierod_lab.papers.sideslip.two_stage import two_stage_poles
from tierod_lab.studies.effort import Effort

CAR = "brush tyres"
FACTORS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)
"""Factors by which the observer poles are faster than the eigenvalues of the system [-]."""

WITH_POLES: dict[str, Build] = {"conventional": conventional_poles, "two-stage": two_stage_poles}
PRINTED = 10.0
"""Factor that the paper recommends [-]."""


@dataclass(frozen=True)
class Traded:
    """Noise and error of one observer at one speed, by factor of its poles.

    Args:
        noise: standard deviation of the sideslip angle due to sensor noise [deg], (factors,)
        errors: root mean square error of the sideslip angle [deg], (factors,)
    """

    noise: np.ndarray
    errors: np.ndarray


def items(effort: Effort) -> Iterator[Item]:
    factors = FACTORS[::3] if effort.quick else FACTORS
    yield Heading(
        "Noise against bandwidth",
        (
            "The car with brush tyres, both manoeuvres. Poles are real, the given factor times the size of the "
            "system's eigenvalues; those of the disturbance observer stay at 60 to 70 per second. Noise is the "
            "standard deviation of the difference between two runs with other sensor noise, over the root of two.",
        ),
    )
    tasks = [(name, drive, factors) for drive in (SLOW, FAST) for name in WITH_POLES]
    made = effort.made(_traded, tasks)
    found = {(name, drive.speed): each for (name, drive, _), each in zip(tasks, made, strict=True)}
    yield _chart(found, factors)
    yield from _claims(found, factors)


def _traded(task: tuple[str, Drive, tuple[float, ...]]) -> Traded:
    name, drive, factors = task
    p = matched(CAR, drive.speed, drive.steer)
    runs = [on(drive, CAR, seed) for seed in SEEDS.of(SIDE_BY_SIDE, 2)]
    pairs = [_pair(WITH_POLES[name], p, factor, runs) for factor in factors]
    return Traded(*(np.array(column) for column in zip(*pairs, strict=True)))


def _pair(build: Build, p: SteeredVehicle.Parameters, factor: float, runs: list[Driven]) -> tuple[float, float]:
    observer = build(p, 1.0 / RATE, factor)  # type: ignore[call-arg]
    return _noise_and_error([observed(observer, run) for run in runs], runs)


def _noise_and_error(courses: list[Course], runs: list[Driven]) -> tuple[float, float]:
    first, second = (course.sideslip_angle[run.judged] for course, run in zip(courses, runs, strict=True))
    # Both runs share the truth and the model error, so that their difference holds the noise of two runs only.
    noise = float(np.degrees(np.std(first - second) / np.sqrt(2.0)))
    return noise, float(np.mean([error(course, run) for course, run in zip(courses, runs, strict=True)]))


def _chart(found: dict[tuple[str, float], Traded], factors: tuple[float, ...]) -> Chart:
    panels = []
    for drive in (SLOW, FAST):
        p = matched(CAR, drive.speed, drive.steer)
        runs = [on(drive, CAR, seed) for seed in SEEDS.of(SIDE_BY_SIDE, 2)]
        kalman = {
            f"{words}, Kalman": _noise_and_error([observed(built(f"{words}, Kalman", p), run) for run in runs], runs)
            for words in WITH_POLES
        }
        for at, what in ((0, "noise"), (1, "error")):
            marks = tuple(
                Lines(name, factors, (found[name, drive.speed].noise, found[name, drive.speed].errors)[at])
                for name in WITH_POLES
            )
            levels = tuple((name, pair[at]) for name, pair in kalman.items())
            title = f"{what}, {drive.speed:g} m/s"
            panels.append(Panel(title, "factor of the poles", f"{what} [deg]", marks, levels, logarithmic=True))
    return Chart(
        "noise-against-bandwidth",
        "Noise and error of the observers over the speed of their poles",
        "Sideslip angle. Dashed: the same observers with Kalman gains.",
        "Noise and error of both observers over the factor of their poles, at 6.7 and 25 m/s.",
        tuple(panels),
    )


def _claims(found: dict[tuple[str, float], Traded], factors: tuple[float, ...]) -> Iterator[Claim]:
    for drive in (SLOW, FAST):
        each = found["conventional", drive.speed]
        best = int(np.argmin(each.errors))
        yield Claim(
            f"paper.ten-times-{drive.speed:g}",
            f"Poles at least ten times farther left than the system's are a good choice ({drive.speed:g} m/s).",
            f"{PAPER}, below eq (17)",
            "at least 10",
            each.errors[factors.index(PRINTED)] - each.errors[best] if PRINTED in factors else None,
            at_most(0.01),
            "deg",
            f"Error above that of the best factor, {factors[best]:g}.",
            cause="The paper prints no noise of its sensors, which decides: faster poles pass more of it. With a "
            "gyroscope of 0.003 rad/s the error is, by factor: "
            + ", ".join(f"{factor:g}: {error:.3f}" for factor, error in zip(factors, each.errors, strict=True))
            + " deg.",
            irreproducible=True,
        )
        for name in WITH_POLES:
            errors = found[name, drive.speed].errors
            yield Claim(
                f"observers.poles-{name}-{drive.speed:g}",
                f"With the best of its poles the {name} observer finds the sideslip angle ({drive.speed:g} m/s).",
                GOAL,
                None,
                float(errors.min()),
                at_most(SLOW_GOAL if drive is SLOW else FAST_GOAL),
                "deg",
                f"Factor {factors[int(np.argmin(errors))]:g}, the best of those in the figure; {CAR}.",
            )
