"""Small virtual cars at low speed and large steer angles, without an accelerometer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from tierod.core.claims import Claim, at_most, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan, trace
from tierod.core.recording import Channel, Recording
from tierod.monitors.sideslip.definition import SideslipMonitor
from tierod.monitors.sideslip.estimator import CombinedSideslip
from tierod.vehicles import load
from tierod.vehicles.vehicle import Parameter, Vehicle
from tierod_lab.ground import run
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.chassis import TwoTrack, Tyre
from tierod_lab.ground.chassis.suspension import Axle, Kingpins
from tierod_lab.ground.chassis.two_track import demonstrator
from tierod_lab.ground.courses.conditions import Unevenness
from tierod_lab.ground.courses.open_loop import RandomSteer
from tierod_lab.papers.sideslip.calibration import BesideTruth
from tierod_lab.papers.sideslip.real_recordings import GOAL
from tierod_lab.papers.sideslip.reported import SEEDS, SLOW
from tierod_lab.papers.sideslip.typical_cars import LIGHT, PASSENGER, SIMPLE, Class, typical
from tierod_lab.studies.effort import Effort

RATE = 100.0
"""Sampling rate [Hz]."""

STEERED: dict[float, float] = {1.5: 8.0, 3.0: 8.0, 5.0: 6.5, 8.0: 3.0, 12.0: 1.5}
"""Speed [m/s] -> standard deviation of the road-wheel angle [deg]; less at speeds at which the grip limits it."""

SETTLING = 2.0
"""Duration of straight driving at the start [s], which is not judged."""


@dataclass(frozen=True)
class Small:
    """A virtual car and its class.

    Args:
        chassis: true chassis
        kind: class whose typical tyres the estimator assumes; the true tyres differ
    """

    chassis: TwoTrack
    kind: Class


def quadricycle() -> TwoTrack:
    """A light quadricycle with two seats: 450 kg, short, narrow tyres of low pressure, rear engine; assumed.

    It rolls by 5 degrees at 0.6 g, more than any larger car.
    """
    tyre = Tyre(
        radius=0.25, nominal_load=1100.0, cornering_stiffness=16.0, friction=0.9, lateral_relaxation=0.3, trail=0.015
    )
    return TwoTrack(
        mass=450.0,
        yaw_inertia=305.0,
        front_distance=0.95,
        rear_distance=0.74,
        centre_height=0.6,
        roll_inertia=80.0,
        drag_area=0.7,
        side_area=3.0,
        side_force_lead=0.2,
        front=Axle(1.10, 0.03, 10.6e3, 380.0, 0.0, 0.4, tyre),
        rear=Axle(1.09, 0.06, 8.6e3, 310.0, 0.0, 0.4, tyre),
        kingpins=Kingpins(mechanical_trail=0.015, scrub_radius=0.02, inclination=0.15),
    ).with_axle_stiffness(21.3e3, 29.8e3)


def cars() -> dict[str, Small]:
    """Cars by their name in the table."""
    return {
        "quadricycle, 450 kg": Small(quadricycle(), LIGHT),
        "light demonstrator, 403 kg": Small(demonstrator(), PASSENGER),
        "small car, 1050 kg": Small(_small_eps().chassis, PASSENGER),
    }


@cache
def _small_eps() -> Any:
    return catalogue.load("small-eps").block


def driven(chassis: TwoTrack, speed: float, seed: int) -> Recording:
    """Recording of 90 s of random steer at a speed [m/s] on an uneven road, without lateral acceleration."""
    car = _small_eps()
    driver = replace(car.driver, mass=chassis.mass, wheelbase=chassis.wheelbase, rear_distance=chassis.rear_distance)
    course = RandomSteer(
        speed=speed,
        deviation=math.radians(STEERED[speed]) / car.steering.linkage.ratio,
        lowest=0.05,
        highest=0.4,
        time=90.0,
        settle=SETTLING,
        rest=1.0,
        seed=seed,
        conditions=(Unevenness(),),
    )
    recording = run(replace(car, chassis=chassis, driver=driver), course, seed=seed).recording
    kept = ("vehicle_speed", "steering_wheel_angle", "yaw_rate", "longitudinal_acceleration")
    truth = recording["truth_sideslip_angle"]
    channels = {name: recording[name] for name in kept}
    return Recording(channels | {"sideslip_angle": Channel("sideslip_angle", truth.time, truth.values, "rad")})


def brochure(small: Small) -> Vehicle:
    """Vehicle file with the data of a brochure (mass, axle distances, steering ratio) and typical tyres."""
    chassis, ratio = small.chassis, _small_eps().steering.linkage.ratio
    values = {
        "mass": (chassis.mass, "kg"),
        "front_distance": (chassis.front_distance, "m"),
        "rear_distance": (chassis.rear_distance, "m"),
        "steering_ratio": (ratio, ""),
    }
    parameters = {name: Parameter(name, value, unit, None, "brochure") for name, (value, unit) in values.items()}
    return typical(replace(load("midsize-eps"), name="brochure", parameters=parameters), small.kind)


def estimated(recording: Recording, car: Vehicle) -> BesideTruth:
    """Runs the combined estimator over a recording; signals that it lacks stay NaN."""
    block = SideslipMonitor.of_vehicle(CombinedSideslip.of_vehicle(car, 1.0 / RATE), car)
    names = trace(block).sample
    aligned = recording.align((*names, "sideslip_angle"), RATE, maximum_age=0.1)
    result = scan(block, aligned.values[:, :-1])
    angle, deviation = result["statement.magnitude"], result["statement.deviation"]
    return BesideTruth(aligned.time, angle, deviation, aligned.values[:, -1], result)


@dataclass(frozen=True)
class Found:
    """Errors of one car over all speeds.

    Args:
        mean, rms: mean absolute and root mean square error of the estimator [deg]
        coverage: coverage of its 95 % band [-]
        restarts: number of restarts of the filter
        simple: mean absolute and root mean square error of the simple estimates, by name [deg]
        beside_kinematics: root mean square error over that of the kinematic estimate at the worst speed [-]
    """

    mean: float
    rms: float
    coverage: float
    restarts: float
    simple: dict[str, tuple[float, float]]
    beside_kinematics: float


def judged(small: Small, seed: int, speeds: tuple[float, ...] = tuple(STEERED)) -> Found:
    """Errors of a car, with all speeds [m/s] pooled."""
    car = brochure(small)
    errors: list[np.ndarray] = []
    inside: list[np.ndarray] = []
    simple: dict[str, list[np.ndarray]] = {name: [] for name in SIMPLE}
    restarts = 0.0
    for speed in speeds:
        recording = driven(small.chassis, speed, seed)
        seen = estimated(recording, car)
        assert seen.result is not None
        kept = (seen.time > SETTLING) & np.isfinite(seen.error)
        errors.append(np.degrees(seen.error[kept]))
        inside.append(np.abs(seen.error[kept]) <= 1.96 * seen.deviation[kept])
        restarts += float(seen.result["estimate.restarted"].sum())
        for name, estimate in SIMPLE.items():
            simple[name].append(np.degrees(estimate(recording, car, RATE).error[kept]))
    pairs = zip(errors, simple["kinematics"], strict=True)
    return Found(
        *_sizes(errors),
        float(np.concatenate(inside).mean()),
        restarts,
        {name: _sizes(each) for name, each in simple.items()},
        max(_sizes([own])[1] / _sizes([other])[1] for own, other in pairs),
    )


def _sizes(errors: list[np.ndarray]) -> tuple[float, float]:
    error = np.concatenate(errors)
    return float(np.mean(np.abs(error))), float(np.sqrt(np.mean(error * error)))


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Small, slow, strongly steered",
        (
            "Random steering at 1.5 to 12 m/s, up to 25 degrees at the road wheels, production sensors without an "
            "accelerometer. The estimator has mass, distances and steering ratio, tyres typical of the class, default "
            "noises.",
        ),
    )
    seed = SEEDS.of(SLOW, 1)[0]
    speeds = (3.0,) if effort.quick else tuple(STEERED)
    found = {name: judged(small, seed, speeds) for name, small in cars().items()}
    rows = [
        (
            name,
            f"{each.mean:.3f} / {each.rms:.3f}",
            f"{100.0 * each.coverage:.0f} %",
            *(f"{mean:.3f} / {rms:.3f}" for mean, rms in each.simple.values()),
        )
        for name, each in found.items()
    ]
    yield Table(
        "Mean absolute / root mean square error of the sideslip, no accelerometer (degrees)",
        ("car", "combined", "in the 95 % band", *SIMPLE),
        tuple(rows),
        "The seed of the drives follows from the digest of the judged estimators.",
    )
    worst = max(found.values(), key=lambda each: each.rms)
    for key, value, goal in (("mean", worst.mean, 0.3), ("rms", worst.rms, 0.4)):
        yield Claim(f"slow.{key}", f"Worst of three small cars: {key} error.", GOAL, None, value, at_most(goal), "deg")
    restarts = sum(each.restarts for each in found.values())
    yield Claim("slow.restarts", "New starts of the filter.", GOAL, None, restarts, exactly(0.0), "")
    yield Claim(
        "slow.kinematics",
        "Root mean square error over that of atan(rear distance * yaw rate / speed), worst car and speed.",
        GOAL,
        None,
        max(each.beside_kinematics for each in found.values()),
        at_most(1.0),
        "",
    )
