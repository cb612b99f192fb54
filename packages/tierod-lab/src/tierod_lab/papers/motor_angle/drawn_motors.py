"""Accuracy of the default observer on motors that differ from the vehicle file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Heading, Item, Table
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.varied import Varied
from tierod_lab.papers.motor_angle.fault_drives import bench_time, course
from tierod_lab.papers.motor_angle.observer_drives import (
    ObserverDrive,
    bench,
    drive,
    of_another_motor,
    parameters,
    rms,
    to_and_fro,
    with_true,
)
from tierod_lab.papers.motor_angle.reported import DRAWN, RAMPED, SEEDS, TARGET
from tierod_lab.studies.effort import Effort

DRAWS, SECONDS = 20, 20.0
"""Number of motors, and duration of a drive [s]."""


class Errors(NamedTuple):
    """Root mean square and largest error of the angle [rad]."""

    rms: float
    most: float


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Motors that differ from the vehicle file",
        (
            f"Drives of {SECONDS:g} s under load. Resistance, flux and inductance of the motor are 0.8 to 1.3, 0.94 to "
            "1.02 and 0.93 to 1.07 times those that the observer assumes; or the resistance alone is 20 % higher, or "
            "rises by 40 % over the drive while the flux falls by 4 % and the inductance is 10 % lower.",
        ),
    )
    draws = effort.made(drawn, SEEDS.of(DRAWN, 3 if effort.quick else DRAWS))
    seeds = SEEDS.of(RAMPED, 1 if effort.quick else 3)
    warm, warming = effort.made(_warm, seeds), effort.made(ramped, seeds)
    found = [each.rms for each in draws]
    rows = (
        (f"{len(draws)} draws", f"{np.median(found):.4f}", f"{max(found):.4f}", f"{max(e.most for e in draws):.3f}"),
        *(
            (name, f"{np.median([e.rms for e in each]):.4f}", f"{_worst(each):.4f}", f"{max(e.most for e in each):.3f}")
            for name, each in (("resistance +20 %", warm), ("resistance rising by 40 %", warming))
        ),
    )
    header = ("", "rms, median [rad]", "rms, worst [rad]", "most [rad]")
    yield Table("Error of the default's angle", header, rows)
    median, note = float(np.median(found)), f"{len(draws)} motors"
    yield _claim("median", "Error of the angle over drawn motors, root mean square: median.", median, 0.006, note)
    yield _claim("worst", "The same: worst motor.", max(found), 0.01, note)
    yield _claim("most", "The same: largest error at any instant.", max(each.most for each in draws), 0.07, note)
    yield _claim("warm", "Resistance 20 % above the observer's: worst root mean square.", _worst(warm), 0.006)
    yield _claim("warming", "Resistance rising by 40 %: worst root mean square.", _worst(warming), 0.006)


def drawn(seed: int) -> Errors:
    """Errors over a drive of a motor whose parameters are drawn at random."""
    return _errors(of_another_motor(np.random.default_rng([seed, 13])), to_and_fro(seed, SECONDS))


def _warm(seed: int) -> Errors:
    return _errors(MotorAngleObserver(with_true(parameters()[1], 1.2, 1.0, 1.0)), to_and_fro(seed, SECONDS))


def ramped(seed: int) -> Errors:
    """Errors over a drive in which the resistance rises by 40 %, with less flux and inductance."""
    plant = bench()
    machine = plant.motor.machine
    time = bench_time(SECONDS)
    paths = ("motor.machine.resistance", "motor.machine.flux")
    share = time / SECONDS
    varying = (machine.resistance * (1.0 + 0.4 * share), machine.flux * (1.0 - 0.04 * share))
    given = {f"parameters.{path}": values for path, values in zip(paths, varying, strict=True)}
    seen = drive(Varied(_lighter(plant), paths), course(time, seed), np.zeros(len(time)), seed, **given)
    return _errors(MotorAngleObserver(parameters()[1]), seen)


def _lighter(plant: MotorBench) -> MotorBench:
    machine = plant.motor.machine
    lower = replace(machine, inductance_d=0.9 * machine.inductance_d, inductance_q=0.9 * machine.inductance_q)
    return replace(plant, motor=replace(plant.motor, machine=lower))


def _errors(observer: MotorAngleObserver, seen: ObserverDrive) -> Errors:
    away = seen.error(observer)
    return Errors(rms(away), float(np.abs(away).max()))


def _worst(found: list[Errors]) -> float:
    return max(each.rms for each in found)


def _claim(key: str, text: str, measured: float, most: float, note: str = "") -> Claim:
    return Claim(f"accuracy.{key}", text, TARGET, None, measured, at_most(most), "rad", note)
