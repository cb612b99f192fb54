"""The combined estimator on virtual cars: wrong parameters and disturbances, low friction, small cars at low speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from tierod.core.graph import Result, scan, trace
from tierod.core.recording import Channel, Recording
from tierod.monitors.sideslip.definition import SideslipMonitor
from tierod.monitors.sideslip.estimator import CombinedSideslip
from tierod.vehicles import load
from tierod.vehicles.vehicle import Parameter, Vehicle
from tierod_lab.ground import run
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.chassis import TwoTrack, Tyre
from tierod_lab.ground.chassis.two_track import Axle, Kingpins, demonstrator
from tierod_lab.ground.courses.course import Unevenness
from tierod_lab.ground.courses.manoeuvres import RandomSteer
from tierod_lab.papers.sideslip.calibration import BesideTruth
from tierod_lab.papers.sideslip.combined_drives import (
    FRONT,
    NOTHING,
    READINGS,
    REAR,
    WITH,
    WITHOUT_TORQUE,
    Belief,
    Driven,
    both_stiff,
    driven,
    errors,
    estimated,
    general,
    on,
    right,
    rms,
    scaled,
    slippery_ramp,
)
from tierod_lab.papers.sideslip.typical_cars import LIGHT, PASSENGER, SIMPLE, Class, typical
from tierod_lab.studies.metrics import Row

RANDOM, SINE = "random steering", "sine, 0.3 Hz"
CASES: dict[str, tuple[str, Belief]] = {
    "random steering": (RANDOM, right),
    "sine, 0.3 Hz": (SINE, right),
    "mixed drive from standstill": ("mixed drive from standstill", right),
    "front stiffness +20 %": (RANDOM, scaled(**{FRONT: 1.2})),
    "rear stiffness +20 %": (RANDOM, scaled(**{REAR: 1.2})),
    "both stiffnesses +20 %": (RANDOM, both_stiff),
    "both stiffnesses -20 %": (RANDOM, scaled(**{FRONT: 0.8, REAR: 0.8})),
    "steering friction +50 %": (RANDOM, scaled(road_wheel_friction=1.5)),
    "steering friction -50 %": (RANDOM, scaled(road_wheel_friction=0.5)),
    "mass +3 %, yaw inertia +10 %": (RANDOM, scaled(mass=1.03, yaw_inertia=1.1)),
    "axles and roll of no car in particular": (RANDOM, general),
    "bank 3°": ("bank 3°", right),
    "bank 3°, both stiffnesses +20 %": ("bank 3°", both_stiff),
    "crosswind 500 N": ("crosswind 500 N", right),
    "low friction, 0.35": ("low friction, 0.35", right),
    "sine, 0.05 Hz": ("sine, 0.05 Hz", right),
    "sine, 0.05 Hz, both stiffnesses +20 %": ("sine, 0.05 Hz", both_stiff),
}
"""Course and assumed parameters by name."""


def combined(task: tuple[str, int]) -> list[Row]:
    """One extended Kalman filter over yaw rate, lateral acceleration and, where the car has it, the steering's torque.

    The car is the full chassis on two tracks with tyres of another law, at 25 m/s. Every 10 ms; noise of the yaw rate
    0.003 rad/s, of the road-wheel angle 0.2 mrad, of the acceleration 0.1 m/s². Errors after the first minute.
    """
    case, seed = task
    course, belief = CASES[case]
    drive = on(course, seed)
    rows: list[Row] = []
    for name in (*READINGS, "nothing followed"):
        readings, tuning = (name, None) if name in READINGS else (WITH, NOTHING)
        error, inside = errors(drive, estimated(drive, belief, readings, tuning))
        rows.append({"case": case, "readings": name, "error": rms(error), "covered": float(np.mean(inside))})
    return rows


RAMPS: dict[str, tuple[float, float, float]] = {
    "0.35, 2 degrees/s": (0.35, 60.0, 2.0),
    "0.35, 5 degrees/s to the right": (0.35, -70.0, 5.0),
    "0.35, 15 degrees/s": (0.35, 75.0, 15.0),
    "0.2, 3 degrees/s": (0.2, 50.0, 3.0),
    "0.6, 5 degrees/s": (0.6, 100.0, 5.0),
    "1, 10 degrees/s": (1.0, 150.0, 10.0),
}
"""Road friction over that of a dry road [-], final steering wheel angle [deg] and its rate [deg/s], by name."""
SHOWN = "0.35, 5 degrees/s to the right"
PEAK = 0.98
"""Share of the largest front force of a ramp from which the peak counts as reached: the curve is flat there [-]."""
TURNING = 15.0  # Time at which a ramp begins to steer [s]


@dataclass(frozen=True)
class Ramp:
    """One ramp with the estimate, the true share of the largest front force, and times of its peak and warning [s]."""

    drive: Driven
    result: Result
    share: np.ndarray
    peak: float
    announced: float


def ramp(name: str, seed: int, readings: str = WITH) -> Ramp:
    """Drive a ramp of `RAMPS` and run the estimator with the measurements of `readings`."""
    drive = driven(slippery_ramp(*RAMPS[name]), seed)
    return against_the_peak(drive, estimated(drive, readings=readings))


def against_the_peak(drive: Driven, result: Result) -> Ramp:
    """The ramp with its peak and the announcement of it."""
    force = np.abs(drive.truth("front_lateral_force"))
    share = force / force.max()
    ahead = (result["limit_ahead"] > 0.5) & (drive.time > TURNING)
    announced = float(drive.time[np.argmax(ahead)]) if ahead.any() else math.inf
    return Ramp(drive, result, share, float(drive.time[np.argmax(share > PEAK)]), announced)


def ramps(task: tuple[str, int]) -> list[Row]:
    """Ever more steering at 22 m/s, onto a slippery road from a dry one: the peak of the front force announced.

    As a tyre slips, its pneumatic trail vanishes before its force has its peak, so the steering torque indicates the
    friction of the road early. The estimator announces the peak where the front axle uses more than 70 % of the
    greatest force that it expects, with a standard deviation to spare.
    """
    name, seed = task
    rows: list[Row] = []
    for readings in (WITH, WITHOUT_TORQUE):
        found = ramp(name, seed, readings)
        away = found.result["sideslip_angle"] - found.drive.truth("sideslip_angle")
        way = (found.drive.time > TURNING) & (found.drive.time <= found.peak)
        rows.append(
            {
                "ramp": name,
                "friction": RAMPS[name][0],
                "readings": readings,
                "lead": found.peak - found.announced,
                "error": math.degrees(rms(away[way])),
            }
        )
    return rows


QUIET = ("random steering", "mixed drive from standstill", "low friction, 0.35")
"""Drives that are searched for false announcements; on the last one alone the front axle comes near its peak."""
GRIP = 7900.0
"""Largest front axle force over road friction [N], measured on the ramps: 2790 N at a friction of 0.35. On a dry road
load transfer reduces it to 7500, so the share in use comes out 5 % too small there."""
FALSE, ICE = 0.6, 0.6
"""Share of the front axle's grip below which an announcement is false, and estimated over true friction of ice [-]."""


def quiet(task: tuple[str, int]) -> list[Row]:
    """Drives whose front axle does not come near its peak: time with a false announcement, and with false ice."""
    name, seed = task
    drive = on(name, seed)
    step = float(drive.time[1] - drive.time[0])
    road = np.maximum(drive.truth("road_friction"), 0.05)
    used = np.abs(drive.truth("front_lateral_force")) / (GRIP * road)
    rows: list[Row] = []
    for readings in (WITH, WITHOUT_TORQUE):
        result = estimated(drive, readings=readings)
        rows.append(
            {
                "drive": name,
                "readings": readings,
                "seconds": step * len(drive.time),
                "announced": step * float(np.sum((result["limit_ahead"] > 0.5) & (used < FALSE))),
                "ice": step * float(np.sum(result["friction"] / road < ICE)),
            }
        )
    return rows


SLOW_RATE, SETTLING = 100.0, 2.0
"""Sampling rate of the slow drives [Hz], and their straight start, which is not judged [s]."""
STEERED: dict[float, float] = {1.5: 8.0, 3.0: 8.0, 5.0: 6.5, 8.0: 3.0, 12.0: 1.5}
"""Speed [m/s] -> standard deviation of the road-wheel angle [deg]; less at speeds at which the grip limits it."""


class Small(NamedTuple):
    """A virtual car and its class."""

    chassis: TwoTrack
    kind: Class


def quadricycle() -> TwoTrack:
    """A light quadricycle with two seats: 450 kg, short, narrow tyres of low pressure, rear engine; assumed."""
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


@cache
def _small_eps() -> Any:
    return catalogue.load("small-eps").block


def small_cars() -> dict[str, Small]:
    """Cars by name."""
    return {
        "quadricycle, 450 kg": Small(quadricycle(), LIGHT),
        "light demonstrator, 403 kg": Small(demonstrator(), PASSENGER),
        "small car, 1050 kg": Small(_small_eps().chassis, PASSENGER),
    }


def slow_drive(chassis: TwoTrack, speed: float, seed: int) -> Recording:
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


def slow(task: tuple[str, float, int]) -> list[Row]:
    """Random steering at 1.5 to 12 m/s, up to 25 degrees at the road wheels, production sensors, no accelerometer.

    The estimator has mass, distances and steering ratio, tyres typical of the class, default noises.
    """
    name, speed, seed = task
    small = small_cars()[name]
    car, recording = brochure(small), slow_drive(small.chassis, speed, seed)
    block = SideslipMonitor.of_vehicle(CombinedSideslip.of_vehicle(car, 1.0 / SLOW_RATE), car)
    aligned = recording.align((*trace(block).sample, "sideslip_angle"), SLOW_RATE, maximum_age=0.1)
    result = scan(block, aligned.values[:, :-1])
    angle, deviation = result["statement.magnitude"], result["statement.deviation"]
    seen = BesideTruth(aligned.time, angle, deviation, aligned.values[:, -1], result)
    figures = seen.figures(SETTLING)
    other = SIMPLE["kinematics"](recording, car, SLOW_RATE).figures(SETTLING)
    return [
        {
            "car": name,
            "speed": speed,
            "mean": math.degrees(figures.mean_absolute),
            "rms": math.degrees(figures.rms),
            "covered": figures.coverage,
            "restarts": float(result["estimate.restarted"].sum()),
            "over_kinematics": figures.rms / other.rms,
        }
    ]
