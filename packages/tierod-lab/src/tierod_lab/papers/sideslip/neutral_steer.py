"""Neutral steer: sideslip is unobservable from the yaw rate alone, and observable with the aligning torque."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tierod.core.claims import Claim, exactly
from tierod.core.content import Heading, Item, Table
from tierod.methods.analysis.observability import Observability, observability
from tierod.models.linear import LinearSystem, linearise
from tierod.physics.single_track import understeer_gradient
from tierod_lab.papers.sideslip.matching import from_file
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle, TorqueShownVehicle
from tierod_lab.papers.sideslip.table import PAPER
from tierod_lab.studies.effort import Effort

RATIOS = (0.8, 0.95, 0.99, 1.0, 1.01, 1.05, 1.4)
SPEEDS = (6.7, 25.0, 40.0)
"""Speeds [m/s]."""


def items(effort: Effort) -> Iterator[Item]:
    speeds = SPEEDS[:2] if effort.quick else SPEEDS
    found = shown(from_file(), RATIOS, speeds)
    yield Heading(
        "Neutral steer",
        (
            "Rank of observability, from the orthonormal staircase, for the car of the vehicle file whose rear "
            "axle is made softer and stiffer. Rear over neutral is its cornering stiffness over that with which the "
            "car neither understeers nor oversteers. The margin is the share of the sideslip in the yaw rate, "
            "for states of usual magnitude (0.02 rad, 0.2 rad/s). A rank counts any non-zero direction; the margin "
            "indicates that near neutral steer a stiffness error of one percent is as large as the observable part.",
        ),
    )
    yield table(found)
    neutral = [each for each in found if each.rear_over_neutral == 1.0]
    yield from _claims(neutral, found)


def _claims(neutral: list[Shown], all_of_them: list[Shown]) -> Iterator[Claim]:
    yield Claim(
        "paper.neutral-yaw-rate",
        "In neutral steer the sideslip is not observable by the yaw rate alone.",
        f"{PAPER}, section V",
        "unobservable",
        float(max(each.by_outputs[0].rank for each in neutral)),
        exactly(1.0),
        "",
        "Largest rank over the speeds; two states.",
    )
    yield Claim(
        "paper.neutral-aligning-torque",
        "With the aligning torque as a second measurement the vehicle is always observable.",
        f"{PAPER}, section VI",
        "always",
        float(min(each.by_outputs[1].rank for each in all_of_them)),
        exactly(2.0),
        "",
        "Smallest rank over understeer and speed; two states.",
    )
    yield Claim(
        "paper.neutral-steering-model",
        "With the steering in the model, yaw rate and steering angle show all four states in neutral steer.",
        f"{PAPER}, section V",
        "observable",
        float(min(each.by_outputs[2].rank for each in all_of_them)),
        exactly(4.0),
        "",
        "Smallest rank over understeer and speed. The angle alone shows them as well.",
    )


OUTPUTS = ("yaw rate", "yaw rate and aligning torque", "yaw rate and angle, steering modelled", "angle alone")
"""Names of the sets of measurements, in the order of `Shown.by_outputs`."""

DIMENSIONS = (2, 2, 4, 4)
"""Number of states of the system for each of `OUTPUTS`."""

TYPICAL = (0.02, 0.2)
"""Typical magnitudes of sideslip angle [rad] and yaw rate [rad/s], by which states are scaled for the margin."""


@dataclass(frozen=True)
class Shown:
    """Observability at one understeer gradient and speed.

    Args:
        rear_over_neutral: cornering stiffness of the rear axle over that of neutral steer [-]
        understeer_gradient: [rad*s**2/m]
        speed: [m/s]
        by_outputs: observability for each of `OUTPUTS`
        margin: second singular value of the observability by the yaw rate, for states scaled by `TYPICAL` [-]
    """

    rear_over_neutral: float
    understeer_gradient: float
    speed: float
    by_outputs: tuple[Observability, ...]
    margin: float


def shown(
    p: SteeredVehicle.Parameters, ratios: Sequence[float], speeds: Sequence[float], tolerance: float = 1e-9
) -> list[Shown]:
    """Observability of a car for several cornering stiffnesses of the rear axle and several speeds.

    Args:
        p: of the car
        ratios: cornering stiffness of the rear axle over C_f a / b, that of neutral steer [-]
        speeds: [m/s]
        tolerance: of the ranks

    Source: Yih, Ryu, Gerdes, sections V and VI.
    """
    found = []
    for ratio in ratios:
        rear = ratio * p.front_cornering_stiffness * p.front_distance / p.rear_distance
        car = dataclasses.replace(p, rear_cornering_stiffness=rear, road_wheel_friction=0.0)
        gradient = understeer_gradient(p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, rear)
        for speed in speeds:
            each = systems(car, speed)
            by_outputs = tuple(observability(system, tolerance) for system in each)
            margin = observability(each[0], tolerance, TYPICAL).singular_values[1]
            found.append(Shown(ratio, gradient, speed, by_outputs, float(margin)))
    return found


def systems(p: SteeredVehicle.Parameters, speed: float) -> tuple[LinearSystem, ...]:
    """The linear system for each of `OUTPUTS`, without friction, at a speed [m/s]."""
    free = dataclasses.replace(p, road_wheel_friction=0.0)
    own = TorqueShownVehicle.Parameters(
        *(getattr(p, each.name) for each in dataclasses.fields(TorqueShownVehicle.Parameters))
    )
    vehicle = linearise(TorqueShownVehicle, own, (0.0, 0.0), (0.0, speed))
    steered = linearise(SteeredVehicle, free, (0.0,) * 4, (0.0, speed))
    return (_only(vehicle, 0), vehicle, steered, _only(steered, 1))


def _only(system: LinearSystem, output: int) -> LinearSystem:
    chosen = [output]
    return dataclasses.replace(system, C=system.C[chosen], D=system.D[chosen], outputs=(system.outputs[output],))


def table(found: Sequence[Shown]) -> Table:
    """Table of the observability ranks over understeer and speed."""
    return Table(
        "Rank of the observability over understeer and speed",
        ("rear over neutral", "understeer (deg per m/s²)", "speed (m/s)", *OUTPUTS, "margin of the yaw rate"),
        tuple(_row(each) for each in found),
    )


def _row(each: Shown) -> tuple[str, ...]:
    ranks = (f"{one.rank} of {n}" for one, n in zip(each.by_outputs, DIMENSIONS, strict=True))
    gradient = math.degrees(each.understeer_gradient)
    return (f"{each.rear_over_neutral:g}", f"{gradient:+z.3f}", f"{each.speed:g}", *ranks, f"{each.margin:.1e}")
