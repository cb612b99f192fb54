"""Drives of the study of the combined estimator: the virtual car steered by wire, and the assumed parameters."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tierod.core.graph import Result, scan
from tierod.core.recording import Recording
from tierod.models.lateral_parameters import LateralParameters
from tierod.monitors.sideslip.estimator import CombinedSample, CombinedSideslip
from tierod.monitors.sideslip.tuning import CombinedTuning
from tierod.vehicles import load
from tierod_lab.ground import Sensor, SensorSet, run
from tierod_lab.ground.courses.course import Adhesion, AnyCondition, Breeze, Course, During, Gusts, Restlessness, Slope
from tierod_lab.ground.courses.course import Unevenness as Uneven
from tierod_lab.ground.courses.manoeuvres import AngleRamp, RandomSteer, SineSteer
from tierod_lab.ground.courses.roads import City, Country, Motorway, NaturalDrive
from tierod_lab.papers.sideslip.setting import actuator, virtual_car

RATE = 100.0  # Sampling rate [Hz]

SENSORS = SensorSet(
    {
        "yaw_rate": Sensor(noise=0.003, rate=RATE),
        "road_wheel_angle": Sensor(noise=2e-4, rate=RATE),
        "lateral_acceleration": Sensor(noise=0.1, rate=RATE),
        "longitudinal_acceleration": Sensor(noise=0.1, rate=RATE),
        "vehicle_speed": Sensor(noise=0.02, rate=RATE),
        "motor_current": Sensor(noise=0.02, rate=RATE),
    },
    "A car steered by wire, as its own control units see it.",
)

SPEED = 25.0  # Speed of the open-loop drives [m/s]

SETTLED = 60.0  # Warm-up: time before an estimate is judged [s]

CHANGED = 20.0  # Time at which the road becomes banked or slippery, or a wind begins [s]


def _later(start: float = CHANGED) -> During:
    return During(start=start, end=1e4, ramp=1.0)


def _random(*conditions: AnyCondition, deviation: float = 14.0, highest: float = 1.0) -> Course:
    return RandomSteer(
        speed=SPEED,
        deviation=math.radians(deviation),
        lowest=0.1,
        highest=highest,
        time=100.0,
        settle=2.0,
        rest=2.0,
        conditions=conditions,
    )


def _sine(frequency: float, *conditions: AnyCondition) -> Course:
    periods = round(100.0 * frequency)
    amplitude = math.radians(34.0)
    return SineSteer(speed=SPEED, amplitude=amplitude, frequency=frequency, periods=periods, conditions=conditions)


def _mixed() -> Course:
    conditions = (Restlessness(), Gusts(deviation=2.0), Uneven())
    return NaturalDrive(time=240.0, wait=3.0, roads=(City(), Country(), Motorway()), conditions=conditions)


def slippery_ramp(adhesion: float, angle: float, rate: float) -> Course:
    """Straight on a dry road, then ramp steer on a slippery one until the front axle slides.

    Args:
        adhesion: road friction over that of the dry road [-]
        angle: steering wheel angle at the end [deg]
        rate: steering wheel rate [deg/s]
    """
    slippery = (Adhesion(window=_later(10.0), left=adhesion, right=adhesion),)
    return AngleRamp(
        speed=22.0, angle=math.radians(angle), rate=math.radians(rate), settle=15.0, rest=1.0, conditions=slippery
    )


COURSES: dict[str, Callable[[], Course]] = {
    "random steering": _random,
    "sine, 0.3 Hz": lambda: _sine(0.3),
    "sine, 0.05 Hz": lambda: _sine(0.05),
    "mixed drive from standstill": _mixed,
    "bank 3°": lambda: _random(Slope(window=_later(), bank=math.radians(3.0))),
    "crosswind 500 N": lambda: _random(Breeze(window=_later(), crosswind=-6.7)),
    "low friction, 0.35": lambda: _random(Adhesion(window=_later(), left=0.35, right=0.35), deviation=7.0),
}
"""Name in the tables -> maker of the course."""

Belief = Callable[[LateralParameters], LateralParameters]


def scaled(**factors: float) -> Belief:
    """A change that multiplies the named parameters by factors."""

    def change(car: LateralParameters) -> LateralParameters:
        return dataclasses.replace(car, **{name: factor * getattr(car, name) for name, factor in factors.items()})

    return change


def right(car: LateralParameters) -> LateralParameters:
    """The parameters of the vehicle file, unchanged."""
    return car


def both_stiff(car: LateralParameters) -> LateralParameters:
    """The parameters with both cornering stiffnesses 20 % too high."""
    return scaled(**{FRONT: 1.2, REAR: 1.2})(car)


def general(car: LateralParameters) -> LateralParameters:
    """The parameters with generic tyre curves, friction, relaxation and roll, as without circle tests of this car."""
    known = (car.mass, car.yaw_inertia, car.front_distance, car.rear_distance, car.front_cornering_stiffness)
    return dataclasses.replace(
        LateralParameters(*known, car.rear_cornering_stiffness),
        sensor_forward=car.sensor_forward,
        drive_front_share=car.drive_front_share,
        centre_height=car.centre_height,
    )


FRONT, REAR = "front_cornering_stiffness", "rear_cornering_stiffness"  # Parameters that the cases assume wrongly

WITH, WITHOUT_TORQUE = "all", "no torque"
READINGS: dict[str, tuple[bool, tuple[str, ...]]] = {
    WITH: (True, ()),
    "no a_y": (True, ("lateral_acceleration",)),
    WITHOUT_TORQUE: (False, ()),
    "neither": (False, ("lateral_acceleration",)),
}
"""Available measurements, by name: whether the steering torque is used, and the signals that are missing."""

NOTHING = CombinedTuning(
    log_front_stiffness=None,
    log_rear_stiffness=None,
    log_friction=None,
    bank_angle=None,
    side_force=None,
    side_moment=None,
    log_steering_friction=None,
    log_trail=None,
)
"""Tuning that estimates the motion alone and takes all parameters as exact and all disturbances as zero."""


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
    """Drives the virtual car over a course."""
    seeded: Any = dataclasses.replace(course, seed=seed)  # type: ignore[type-var]
    recording = run(virtual_car(), seeded, seed=seed, sensors=SENSORS).recording
    return of_recording(recording)


@cache
def on(name: str, seed: int) -> Driven:
    """Drive over a course of `COURSES`."""
    return driven(COURSES[name](), seed)


def of_recording(recording: Recording) -> Driven:
    """A drive from its recording; the actuator torque follows from its current by the vehicle file."""
    current = recording["motor_current"].values
    columns = {name: recording[name].values for name in CombinedSample._fields if name in recording}
    columns["road_wheel_torque"] = actuator().road_wheel_torque(actuator().motor_torque(current))
    samples = np.column_stack([columns[name] for name in CombinedSample._fields])
    return Driven(recording["yaw_rate"].time, samples, recording)


@cache
def from_file() -> LateralParameters:
    """Parameters of the vehicle file."""
    return load("steer-by-wire").parameters_for(LateralParameters)


def estimator(belief: Belief = right, readings: str = WITH, tuning: CombinedTuning | None = None) -> CombinedSideslip:
    """The combined estimator for the virtual car.

    Args:
        belief: change from the parameters of the vehicle file to the assumed ones
        readings: name in `READINGS`
        tuning: tuning of the estimator; the default one where None
    """
    return CombinedSideslip.of_parameters(belief(from_file()), 1.0 / RATE, tuning, READINGS[readings][0])


def estimated(
    drive: Driven, belief: Belief = right, readings: str = WITH, tuning: CombinedTuning | None = None
) -> Result:
    """Runs the combined estimator over a drive; arguments as in `estimator`."""
    samples = drive.samples.copy()
    for name in READINGS[readings][1]:
        samples[:, CombinedSample._fields.index(name)] = np.nan
    return scan(estimator(belief, readings, tuning), samples)


def errors(drive: Driven, result: Result, start: float = SETTLED) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the sideslip angle [deg], and whether the 95 % band contains the truth, (m,) each.

    Judged are the samples after `start` [s] and above 2 m/s at which the estimate is not held.
    """
    error = result["sideslip_angle"] - drive.truth("sideslip_angle")
    judged = (drive.time > start) & (drive.truth("speed") > 2.0) & (result["held"] < 0.5)
    inside = np.abs(error) < 1.96 * result["sideslip_angle_deviation"]
    return np.degrees(error[judged]), inside[judged]


def rms(values: Any) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
