"""Equation (6) with the cosine of the steer angle, compared with the small-angle form that the paper continues with."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Heading, Item, Table
from tierod.core.model import Model
from tierod.models.linear import discretise
from tierod.models.single_track import SingleTrack
from tierod_lab.papers.sideslip.conventional import ConventionalKalman, conventional_kalman
from tierod_lab.papers.sideslip.estimators import Course, error, observed, open_loop
from tierod_lab.papers.sideslip.matching import matched
from tierod_lab.papers.sideslip.observer import finer_steps
from tierod_lab.papers.sideslip.reported import SEEDS, SIDE_BY_SIDE
from tierod_lab.papers.sideslip.setting import CARS, FAST, RATE, SLOW, Drive, on
from tierod_lab.papers.sideslip.steered_single_track import TurnedSingleTrack, TurnedSteeredVehicle
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.table import PAPER
from tierod_lab.studies.effort import Effort

MODELS: dict[str, Model] = {"small angles": SingleTrack, "cos δ (eq 6)": TurnedSingleTrack}
"""Name in the table -> model."""

WIDE = Drive(4.0, 20.0, 0.2)
DRIVES = {"6.7 m/s, 8° at 0.25 Hz (the paper's)": SLOW, "25 m/s, 1.3° at 0.3 Hz": FAST, "4 m/s, 20° at 0.2 Hz": WIDE}
PAPERS, _, WIDEST = DRIVES
ANGLES = (5.0, 8.0, 15.0, 25.0, 35.0)
"""Road-wheel angles in the closed-form table [deg]."""

TEXT = (
    "Eq (6) has the cosine of the steer at the front force; eq (9) and all that follows take it as one. Both forms run "
    "here: in closed form on a steady circle, as a model without feedback, and in the conventional "
    "observer with Kalman gains.",
)


class Steady(NamedTuple):
    """Motion on a steady circle.

    Args:
        sideslip_angle: sideslip angle [rad]
        yaw_rate: yaw rate [rad/s]
    """

    sideslip_angle: float
    yaw_rate: float


def steady(p: SingleTrack.Parameters, steer: float, speed: float, turned: bool) -> Steady:
    """Sideslip and yaw rate on a steady circle, in closed form.

    Args:
        p: parameters of the car
        steer: road-wheel angle [rad]
        speed: speed [m/s]
        turned: whether the cosine of the steer angle is kept

    In steady state both balances of eq (6) are linear in sideslip angle and yaw rate, at any steer angle.
    """
    share = math.cos(steer) if turned else 1.0
    front, rear = share * p.front_cornering_stiffness, p.rear_cornering_stiffness
    a, b, m = p.front_distance, p.rear_distance, p.mass
    matrix = [
        [-(front + rear), -m * speed - (a * front - b * rear) / speed],
        [-(a * front - b * rear), -(a * a * front + b * b * rear) / speed],
    ]
    found = np.linalg.solve(matrix, [-front * steer, -a * front * steer])
    return Steady(float(found[0]), float(found[1]))


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Equation (6) with the cosine of the steer", TEXT)
    yield _circles()
    found = {
        (car, name): _errors(car, drive, SEEDS.of(SIDE_BY_SIDE, 1 if effort.quick else 3))
        for car in CARS
        for name, drive in DRIVES.items()
    }
    header = [f"{what}, {name}" for what in ("model only", "conventional, Kalman") for name in MODELS]
    yield Table(
        "Sideslip by both forms of eq (6), root mean square error [deg]",
        ("car", "drive", *header),
        tuple((car, name, *(f"{each:.3f}" for each in errors)) for (car, name), errors in found.items()),
    )
    yield from _claims(found)


def _circles() -> Table:
    p = matched("brush tyres", SLOW.speed, SLOW.steer)
    rows = []
    for angle in ANGLES:
        steer = math.radians(angle)
        pair = [steady(p, steer, SLOW.speed, turned) for turned in (False, True)]
        sideslips = (f"{math.degrees(each.sideslip_angle):.3f}" for each in pair)
        rates = (f"{math.degrees(each.yaw_rate):.2f}" for each in pair)
        rows.append((f"{angle:g}°", f"{math.cos(steer):.4f}", *sideslips, *rates))
    return Table(
        "Steady circle at 6.7 m/s, by both forms",
        ("steer", "cos δ", "sideslip, small angles [deg]", "with it", "yaw rate, small angles [deg/s]", "with it"),
        tuple(rows),
        "Slip angles beyond some 4° leave the linear tyre, whichever form is taken.",
    )


def _errors(car: str, drive: Drive, seeds: Sequence[int]) -> list[float]:
    """Errors of model alone and observer, each in both forms of eq (6), mean over the seeds [deg]."""
    p = matched(car, drive.speed, drive.steer)
    errors = []
    for seed in seeds:
        driven = on(drive, car, seed)
        alone = [error(Course(open_loop(model, p, driven)), driven) for model in MODELS.values()]
        both = (conventional_kalman(p, 1.0 / RATE), turned_kalman(p, 1.0 / RATE))
        errors.append([*alone, *(error(observed(each, driven), driven) for each in both)])
    return [float(each) for each in np.mean(errors, axis=0)]


def turned_kalman(p: SteeredVehicle.Parameters, sample_time: float) -> ConventionalKalman:
    """The conventional observer with Kalman gains for eq (6) with the cosine of the steer angle.

    Args:
        p: parameters of the car
        sample_time: sampling interval [s]
    """
    plain = conventional_kalman(p, sample_time)
    model: Any = discretise(TurnedSteeredVehicle, "midpoint", finer_steps(sample_time))
    parameters = model.Parameters(plain.filter.parameters.continuous, sample_time)
    return dataclasses.replace(plain, filter=dataclasses.replace(plain.filter, model=model, parameters=parameters))


def _claims(found: dict[tuple[str, str], list[float]]) -> Iterator[Claim]:
    moved = {key: max(abs(each[0] - each[1]), abs(each[2] - each[3])) for key, each in found.items()}
    yield Claim(
        "paper.cosine",
        "The cosine of the steer in eq (6) can be taken as one: largest change of an error by it, in the paper's test.",
        f"{PAPER}, eqs (6) and (9)",
        "one",
        max(value for (_, drive), value in moved.items() if drive == PAPERS),
        at_most(0.02),
        "deg",
        f"On steer of 20° at 4 m/s {max(value for (_, drive), value in moved.items() if drive == WIDEST):.3f} degrees.",
    )
