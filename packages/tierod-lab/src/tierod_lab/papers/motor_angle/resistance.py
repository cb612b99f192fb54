"""Accuracy of the default observer with a winding that is warmer than assumed or warms up during the drive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning
from tierod_lab.ground.motor import Warming
from tierod_lab.papers.motor_angle.fault_drives import bench_time, course
from tierod_lab.papers.motor_angle.observer_drives import (
    ObserverDrive,
    bench,
    drive,
    electrical,
    parameters,
    rms,
    to_and_fro,
)
from tierod_lab.papers.motor_angle.reported import RESISTANCE, SEEDS, TARGET
from tierod_lab.studies.effort import Effort

SPEEDS = (0.0, 20.0, 44.0, 110.0, np.inf)
"""Edges of the electrical speed ranges [rad/s]."""
WARMER = 1.2
"""True resistance over the assumed one."""
CAPACITY = 1.95
"""Heat capacity of a winding whose resistance rises by about 40 % in 20 s of the bench's work [J/K]."""


class Errors(NamedTuple):
    """Root mean square errors of the angle over some drives.

    Args:
        drives: error of every drive [rad]
        ranges: electrical error over all drives, by range of speed [rad]
        rise: relative rise of the resistance from start to end, mean over the drives [-]
    """

    drives: np.ndarray
    ranges: list[float]
    rise: float


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "A warmer winding",
        (
            "The resistance of a winding at work is not measured. It is 20 % higher than the observer assumes, "
            "or rises by 40 % in the drive, with magnets 4 % weaker and an inductance 10 % smaller than assumed.",
        ),
    )
    count, seconds = (2, 8.0) if effort.quick else (8, 20.0)
    seeds = SEEDS.of(RESISTANCE, count)
    found = {name: _errors(*case, seeds, seconds) for name, case in _cases().items()}
    yield _table(found)
    yield _chart(ramped(seeds[0], seconds))
    yield from _claims(found)


def ramped(seed: int, seconds: float) -> ObserverDrive:
    """Simulate a drive in which the winding warms by some hundred degrees.

    Args:
        seed: seed of course and noise
        seconds: duration [s]
    """
    # The heat capacity scales with the duration, so that the rise is the same in short drives.
    plant = bench()
    capacity = CAPACITY * seconds / 20.0
    warming = Warming(capacity, 1e9, winding_conductance=0.0, ambient_temperature=293.15)
    plant = replace(plant, motor=replace(plant.motor, warming=warming))
    time = bench_time(seconds)
    return drive(plant, course(time, seed), np.zeros(len(time)), seed)


def _cases() -> dict[str, tuple[MotorAngleObserver, bool]]:
    known = parameters()[1]
    colder = replace(known, motor_resistance=known.motor_resistance / WARMER)
    fixed = MotorAngleTuning(first_resistance=1e-6, first_flux=1e-6, resistance_wander=0.0, flux_wander=0.0)
    return {
        "as assumed": (MotorAngleObserver(known), False),
        "20 % higher": (MotorAngleObserver(colder), False),
        "20 % higher, resistance and flux not learnt": (MotorAngleObserver(colder, fixed), False),
        "rising by 40 %": (MotorAngleObserver(_other(known)), True),
    }


def _other(known: SampledMotorParameters) -> SampledMotorParameters:
    return replace(known, motor_flux=known.motor_flux / 0.96, motor_inductance=known.motor_inductance / 0.9)


def _errors(observer: MotorAngleObserver, warms: bool, seeds: Sequence[int], seconds: float) -> Errors:
    drives = [ramped(seed, seconds) if warms else to_and_fro(seed, seconds) for seed in seeds]
    away = [seen.error(observer) for seen in drives]
    within = electrical(np.concatenate(away))
    speed = parameters()[0].motor_pole_pairs * np.abs(np.concatenate([seen.speed for seen in drives]))
    ranges = [(speed >= low) & (speed < high) for low, high in pairwise(SPEEDS)]
    rise = float(np.mean([seen.resistance[-1] / seen.resistance[0] - 1.0 for seen in drives]))
    return Errors(np.array([rms(each) for each in away]), [rms(within[each]) for each in ranges], rise)


def _table(found: Mapping[str, Errors]) -> Table:
    header = ("resistance", "angle, median", "worst", "below 20 rad/s", "20 to 44", "44 to 110", "above 110")
    rows = tuple(
        (
            name,
            f"{np.median(each.drives):.4f}",
            f"{each.drives.max():.4f}",
            *(f"{value:.3f}" for value in each.ranges),
        )
        for name, each in found.items()
    )
    note = (
        "Angle of the shaft over whole drives; then the electrical error, whole turns left out, by electrical speed. "
        f"The rise was {100.0 * found['rising by 40 %'].rise:.0f} % in the mean."
    )
    return Table("Error of the angle with a wrong resistance, rms (rad)", header, rows, note)


def _chart(seen: ObserverDrive) -> Chart:
    learnt = seen.observed(MotorAngleObserver(_other(parameters()[1])))
    thin = slice(None, None, 100)
    panel = Panel(
        "",
        "time (s)",
        "resistance (mΩ)",
        (
            Lines("learnt", seen.time[thin], 1e3 * learnt["motor_resistance"][thin]),
            Lines("true", seen.time[thin], 1e3 * seen.resistance[thin], dashed=True),
        ),
    )
    return Chart(
        "motor-angle-resistance",
        "A resistance that rises while the motor works",
        "The observer assumes the cold one and a wrong flux and inductance; it learns where 3 A flow or more.",
        "The learnt resistance follows the true one upwards by some 40 percent.",
        (panel,),
    )


def _claims(found: Mapping[str, Errors]) -> Iterator[Claim]:
    for key, name in (("warm", "20 % higher"), ("ramp", "rising by 40 %")):
        each = found[name].drives
        yield Claim(
            f"motor-angle.resistance.{key}",
            f"The default observer keeps the angle with a resistance that is {name} than assumed"
            if key == "warm"
            else "The default observer keeps the angle while the resistance rises by 40 %",
            TARGET,
            None,
            float(each.max()),
            at_most(0.006),
            "rad",
            f"Worst of {len(each)} drives, rms of the shaft; median {np.median(each):.4f} rad.",
        )
