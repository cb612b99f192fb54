"""The combined estimator on the virtual car: wrong parameters and disturbances, low friction, quiet drives."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tierod.core.graph import Result, scan
from tierod.core.recording import Recording
from tierod.models.lateral_motion import LateralParameters
from tierod.monitors.sideslip.estimator import CombinedSample, CombinedSideslip
from tierod.vehicles import load
from tierod_lab.ground import Sensor, SensorSet, run
from tierod_lab.ground.courses.course import (
    Adhesion,
    AnyCondition,
    Breeze,
    Course,
    During,
    Gusts,
    Restlessness,
    Slope,
    Unevenness,
)
from tierod_lab.ground.courses.manoeuvres import AngleRamp, RandomSteer, SineSteer
from tierod_lab.ground.courses.roads import City, Country, Motorway, NaturalDrive
from tierod_lab.papers.sideslip.drives import actuator, virtual_car
from tierod_lab.studies.metrics import Row

RATE = 100.0  # Sampling rate [Hz]
_NOISES = {
    "yaw_rate": 0.003,
    "road_wheel_angle": 2e-4,
    "lateral_acceleration": 0.1,
    "longitudinal_acceleration": 0.1,
    "vehicle_speed": 0.02,
    "motor_current": 0.02,
}
SENSORS = SensorSet(
    {name: Sensor(noise=noise, rate=RATE) for name, noise in _NOISES.items()},
    "A car steered by wire, as its own control units see it.",
)
SPEED = 25.0  # Speed of the open-loop drives [m/s]
SETTLED = 60.0  # Warm-up: time before an estimate is judged [s]
CHANGED = 20.0  # Time at which the road becomes banked or slippery, or a wind begins [s]


def _later(start: float = CHANGED) -> During:
    return During(start=start, end=1e4, ramp=1.0)


def _random(*conditions: AnyCondition, deviation: float = 14.0) -> Course:
    return RandomSteer(
        speed=SPEED,
        deviation=math.radians(deviation),
        lowest=0.1,
        highest=1.0,
        time=100.0,
        settle=2.0,
        rest=2.0,
        conditions=conditions,
    )


def _sine(frequency: float) -> Course:
    periods = round(100.0 * frequency)
    return SineSteer(speed=SPEED, amplitude=math.radians(34.0), frequency=frequency, periods=periods)


def _mixed() -> Course:
    conditions = (Restlessness(), Gusts(deviation=2.0), Unevenness())
    return NaturalDrive(time=240.0, wait=3.0, roads=(City(), Country(), Motorway()), conditions=conditions)


COURSES: dict[str, Callable[[], Course]] = {
    "random steering": _random,
    "sine, 0.3 Hz": lambda: _sine(0.3),
    "mixed drive from standstill": _mixed,
    "bank 3°": lambda: _random(Slope(window=_later(), bank=math.radians(3.0))),
    "crosswind 500 N": lambda: _random(Breeze(window=_later(), crosswind=-6.7)),
    "low friction, 0.35": lambda: _random(Adhesion(window=_later(), left=0.35, right=0.35), deviation=7.0),
}
"""Name in the tables -> maker of the course."""
FRONT, REAR = "front_cornering_stiffness", "rear_cornering_stiffness"  # Parameters that the cases assume wrongly
CASES: dict[str, tuple[str, Mapping[str, float]]] = {
    **{name: (name, {}) for name in COURSES},
    "front stiffness +20 %": ("random steering", {FRONT: 1.2}),
    "rear stiffness +20 %": ("random steering", {REAR: 1.2}),
    "both stiffnesses +20 %": ("random steering", {FRONT: 1.2, REAR: 1.2}),
    "both stiffnesses -20 %": ("random steering", {FRONT: 0.8, REAR: 0.8}),
    "steering friction +50 %": ("random steering", {"road_wheel_friction": 1.5}),
    "steering friction -50 %": ("random steering", {"road_wheel_friction": 0.5}),
    "mass +3 %, yaw inertia +10 %": ("random steering", {"mass": 1.03, "yaw_inertia": 1.1}),
    "bank 3°, both stiffnesses +20 %": ("bank 3°", {FRONT: 1.2, REAR: 1.2}),
}
"""Course, and factors of assumed parameters, by name."""
WITH, WITHOUT_TORQUE = "all", "no torque"


@dataclass(frozen=True)
class Driven:
    """A drive, sampled for the estimator."""

    time: np.ndarray  # sampling times [s], (n,)
    samples: np.ndarray  # columns of `CombinedSample`, (n, 6)
    recording: Recording  # recording with the truth

    def truth(self, name: str) -> np.ndarray:
        """A true signal at the sampling times, (n,)."""
        channel = self.recording[f"truth_{name}"]
        values: np.ndarray = np.interp(self.time, channel.time, channel.values)
        return values


def driven(course: Course, seed: int) -> Driven:
    """Drives the virtual car over a course; the actuator torque follows from its current by the vehicle file."""
    seeded: Any = dataclasses.replace(course, seed=seed)  # type: ignore[type-var]
    recording = run(virtual_car(), seeded, seed=seed, sensors=SENSORS).recording
    current = recording["motor_current"].values
    columns = {name: recording[name].values for name in CombinedSample._fields if name in recording}
    columns["road_wheel_torque"] = actuator().road_wheel_torque(actuator().motor_torque(current))
    samples = np.column_stack([columns[name] for name in CombinedSample._fields])
    return Driven(recording["yaw_rate"].time, samples, recording)


@cache
def on(name: str, seed: int) -> Driven:
    """Drive over a course of `COURSES`."""
    return driven(COURSES[name](), seed)


def estimated(drive: Driven, readings: str = WITH, factors: Mapping[str, float] | None = None) -> Result:
    """Runs the combined estimator over a drive.

    Args:
        readings: whether it has the steering's torque, `WITH` or `WITHOUT_TORQUE`
        factors: assumed over true parameters of the vehicle file
    """
    car = load("steer-by-wire").parameters_for(LateralParameters)
    car = dataclasses.replace(car, **{name: factor * getattr(car, name) for name, factor in (factors or {}).items()})
    return scan(CombinedSideslip.of_parameters(car, 1.0 / RATE, None, readings == WITH), drive.samples)


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def combined(task: tuple[str, int]) -> list[Row]:
    """One extended Kalman filter over yaw rate, lateral acceleration and, where the car has it, the steering's torque.

    The car is the full chassis on two tracks with tyres of another law, at 25 m/s. Every 10 ms; noise of the yaw rate
    0.003 rad/s, of the road-wheel angle 0.2 mrad, of the acceleration 0.1 m/s². Errors after the first minute.
    """
    case, seed = task
    course, factors = CASES[case]
    drive = on(course, seed)
    rows: list[Row] = []
    for readings in (WITH, WITHOUT_TORQUE):
        result = estimated(drive, readings, factors)
        error = result["sideslip_angle"] - drive.truth("sideslip_angle")
        # Where the car crawls the estimate is held.
        judged = (drive.time > SETTLED) & (drive.truth("speed") > 2.0) & (result["held"] < 0.5)
        inside = (np.abs(error) < 1.96 * result["sideslip_angle_deviation"])[judged]
        covered = float(np.mean(inside))
        rows.append({"case": case, "readings": readings, "error": rms(np.degrees(error[judged])), "covered": covered})
    return rows


RAMPS = {"2 degrees/s": (60.0, 2.0), "5 degrees/s to the right": (-70.0, 5.0), "15 degrees/s": (75.0, 15.0)}
"""Final steering wheel angle [deg] and its rate [deg/s] on a road of friction 0.35, by name."""
SHOWN = "5 degrees/s to the right"
PEAK = 0.98
"""Share of the largest front force of a ramp from which the peak counts as reached: the curve is flat there [-]."""
TURNING = 15.0  # Time at which a ramp begins to steer [s]


def _slippery(name: str, seed: int) -> Driven:
    angle, rate = (math.radians(each) for each in RAMPS[name])
    slippery = (Adhesion(window=_later(10.0), left=0.35, right=0.35),)
    course = AngleRamp(speed=22.0, angle=angle, rate=rate, settle=TURNING, rest=1.0, conditions=slippery)
    return driven(course, seed)


def against_the_peak(drive: Driven, result: Result) -> tuple[float, float]:
    """Times at which the front force has its peak, and at which that was announced [s]."""
    share = np.abs(drive.truth("front_lateral_force"))
    ahead = (result["limit_ahead"] > 0.5) & (drive.time > TURNING)
    announced = float(drive.time[np.argmax(ahead)]) if ahead.any() else math.inf
    return float(drive.time[np.argmax(share > PEAK * share.max())]), announced


def ramps(task: tuple[str, int]) -> list[Row]:
    """Ever more steering at 22 m/s, onto a slippery road from a dry one: the peak of the front force announced.

    As a tyre slips, its pneumatic trail vanishes before its force has its peak, so the steering torque indicates the
    friction of the road early. The estimator announces the peak where the front axle uses more than 70 % of the
    greatest force that it expects, with a standard deviation to spare.
    """
    name, seed = task
    drive, rows = _slippery(name, seed), list[Row]()
    for readings in (WITH, WITHOUT_TORQUE):
        result = estimated(drive, readings)
        peak, announced = against_the_peak(drive, result)
        away = (result["sideslip_angle"] - drive.truth("sideslip_angle"))[(drive.time > TURNING) & (drive.time <= peak)]
        error = math.degrees(rms(away))
        rows.append({"ramp": name, "readings": readings, "lead": peak - announced, "error": error})
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
        result = estimated(drive, readings)
        announced = step * float(np.sum((result["limit_ahead"] > 0.5) & (used < FALSE)))
        ice = step * float(np.sum(result["friction"] / road < ICE))
        seconds = step * len(drive.time)
        rows.append({"drive": name, "readings": readings, "seconds": seconds, "announced": announced, "ice": ice})
    return rows
