"""Two virtual cars steered by wire, their drives, and parameters of the observers matched to them on slow circles."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from tierod.core.graph import Result, scan
from tierod.methods.estimators.observers import Luenberger
from tierod.models.linear import discretise
from tierod.models.single_track import SingleTrack as SingleTrackModel
from tierod.models.steering_column import Actuator
from tierod.physics.motion import front_slip_speed, rear_slip_speed
from tierod.vehicles import load
from tierod_lab.ground import Sensor, SensorSet, SingleTrack, run
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.courses.course import Course
from tierod_lab.ground.courses.manoeuvres import AngleRamp, SineSteer
from tierod_lab.papers.sideslip.observers import (
    LowSpeed,
    SteeringTorqueObserver,
    conventional_kalman,
    conventional_poles,
)
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.two_stage import two_stage_kalman, two_stage_poles

RATE = 1000.0  # Sampling rate [Hz]
STRAIGHT_ON = 2.0  # Duration of straight driving at the start of every drive [s], which is not judged
_NOISES = {
    "yaw_rate": 0.003,
    "road_wheel_angle": 2e-4,
    "vehicle_speed": 0.01,
    "motor_current": 0.02,
    "lateral_acceleration": 0.05,
    "longitudinal_acceleration": 0.05,
}
"""Noise of a good gyroscope and of an encoder at the pinion."""
SENSORS = SensorSet(
    {name: Sensor(noise=noise, rate=RATE) for name, noise in _NOISES.items()},
    "A test car steered by wire, every millisecond: the sensors of the paper's car are not printed.",
)


@cache
def virtual_car() -> Any:
    """The virtual car steered by wire: two tracks, Magic Formula, tyre relaxation, roll, inclined kingpins."""
    return catalogue.load("steer-by-wire").block


@cache
def brush_car() -> Any:
    """The same steering on a single track with brush tyres (Fiala), little relaxation and no weight jacking."""
    chassis = SingleTrack(
        mass=1640.0,
        yaw_inertia=3500.0,
        front_distance=1.33,
        rear_distance=1.31,
        front_stiffness=100e3,
        rear_stiffness=140e3,
        mechanical_trail=0.023,
        contact_half_length=0.09,
        weight_lever=0.0,
        relaxation_length=0.05,
    )
    return dataclasses.replace(virtual_car(), chassis=chassis)


CARS = {"virtual car": virtual_car, "brush tyres": brush_car}  # Name in the tables -> maker of the car


@cache
def actuator() -> Actuator:
    """Actuator of the vehicle file."""
    return load("steer-by-wire").parameters_for(Actuator)


@dataclass(frozen=True)
class Drive:
    """One drive with five periods of sine steer."""

    speed: float  # speed [m/s]
    steer: float  # amplitude of the road-wheel angle [deg]
    frequency: float  # frequency of the sine [Hz]

    def course(self) -> Course:
        """The drive as a course of the proving ground."""
        return SineSteer(
            speed=self.speed,
            amplitude=math.radians(self.steer) / actuator().steering_ratio,
            frequency=self.frequency,
            periods=5,
            settle=STRAIGHT_ON,
            rest=2.0,
        )


SLOW, FAST = Drive(6.7, 8.0, 0.25), Drive(25.0, 1.3, 0.3)
"""The two manoeuvres of the tables: that of the paper's test, and one at the speed of a country road."""


@dataclass(frozen=True)
class Driven:
    """Signals and truth of a drive on one time grid."""

    time: np.ndarray  # sampling times [s], (n,)
    signals: dict[str, np.ndarray] = field(default_factory=dict)  # measured signals by name, (n,) each
    # true signals by name without the prefix `truth_`, (n,) each
    truths: dict[str, np.ndarray] = field(default_factory=dict)

    def torque(self) -> np.ndarray:
        """Actuator torque at the road wheels [N m], from the motor current by the vehicle file, (n,)."""
        return actuator().road_wheel_torque(actuator().motor_torque(self.signals["motor_current"]))


def driven(car: Any, course: Course, seed: int) -> Driven:
    """Drives a car over a course; the truth is interpolated to the times of the yaw rate."""
    recording = run(car, course, seed=seed, sensors=SENSORS).recording
    time = recording["yaw_rate"].time
    truths = {
        name.removeprefix("truth_"): np.interp(time, recording[name].time, recording[name].values)
        for name in recording.names
        if name.startswith("truth_")
    }
    return Driven(time, {name: recording[name].values for name in SENSORS.sensors}, truths)


CIRCLES = math.radians(3.0)  # Steering wheel rate of the slow circles [rad/s], slow against the dynamics of the car
CIRCLE_SEEDS = (7001, 7002)  # Seeds of the sensor noise, to the left and to the right


def from_file() -> SteeredVehicle.Parameters:
    """The parameters of the vehicle file."""
    return load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)


@cache
def matched(car: str, drive: Drive) -> SteeredVehicle.Parameters:
    """Parameters of the vehicle file with cornering stiffnesses and trail matched to a car at the speed of a drive.

    Ramp steer at constant speed to both sides, with the true sideslip angle as of an optical sensor. Least squares give
    the slopes of axle force over slip angle and of aligning torque over front force. The trail includes every other
    torque in proportion to that force, such as the one of inclined kingpins.
    """
    p = from_file()
    columns = np.hstack([_circle(CARS[car](), p, drive, side) for side in (0, 1)])
    front, rear, front_slip, rear_slip, torque = columns
    trail = _slope(front, torque)
    return dataclasses.replace(
        p,
        front_cornering_stiffness=_slope(front_slip, front),
        rear_cornering_stiffness=_slope(rear_slip, rear),
        pneumatic_trail=trail - p.mechanical_trail,
    )


def _circle(car: Any, p: SteeredVehicle.Parameters, drive: Drive, side: int) -> np.ndarray:
    """Axle forces [N], slip angles [rad] and aligning torque [N m] during the ramp to one side, (5, n)."""
    sign, ratio = 1.0 - 2.0 * side, actuator().steering_ratio
    angle = sign * math.radians(drive.steer) / ratio
    seen = driven(
        car, AngleRamp(speed=drive.speed, angle=angle, rate=CIRCLES, settle=2.0, rest=0.0), CIRCLE_SEEDS[side]
    )
    speed, yaw_rate, steer = (seen.signals[name] for name in ("vehicle_speed", "yaw_rate", "road_wheel_angle"))
    # The ramp is slow enough to neglect the yaw acceleration in the split of the force between the axles.
    sideslip, force = seen.truths["sideslip_angle"], p.mass * seen.truths["centre_lateral_acceleration"]
    wheelbase, rate = p.front_distance + p.rear_distance, sign * CIRCLES * ratio
    # The wheels turn at a constant rate, so friction and damping are constant and inertia adds nothing.
    resisting = p.road_wheel_damping * rate + math.copysign(p.road_wheel_friction, rate)
    axles = (
        force * p.rear_distance / wheelbase,
        force * p.front_distance / wheelbase,
        front_slip_speed(speed * sideslip, yaw_rate, speed, steer, p.front_distance) / speed,
        rear_slip_speed(speed * sideslip, yaw_rate, p.rear_distance) / speed,
        seen.torque() - resisting,
    )
    return np.array(axles)[:, seen.time > 4.0]


def _slope(x: np.ndarray, y: np.ndarray) -> float:
    return float(x @ y / (x @ x))


OBSERVERS: dict[str, Callable[..., SteeringTorqueObserver]] = {
    "conventional, poles x10": conventional_poles,
    "conventional, Kalman": conventional_kalman,
    "two-stage, poles x2": two_stage_poles,
    "two-stage, Kalman": two_stage_kalman,
}
"""Name in the tables -> maker of the observer."""
MODEL = "model only"


def observed(observer: SteeringTorqueObserver, drive: Driven) -> Result:
    """Outputs of an observer over a drive."""
    names = ("vehicle_speed", "yaw_rate", "road_wheel_angle")
    return scan(observer, np.column_stack([*(drive.signals[name] for name in names), drive.torque()]))


def open_loop(p: SteeredVehicle.Parameters, drive: Driven) -> np.ndarray:
    """Sideslip angle [rad] of the single track driven by the measured steer angle, without feedback, (n,)."""
    sampled = discretise(SingleTrackModel, "midpoint")
    own = SingleTrackModel.Parameters(
        *(getattr(p, each.name) for each in dataclasses.fields(SingleTrackModel.Parameters))
    )
    # With gains of zero, and NaN as measurements, the observer only predicts.
    observer = Luenberger(sampled, sampled.Parameters(own, 1.0 / RATE), (0.0, 0.0), ((0.0, 0.0), (0.0, 0.0)))
    speed = np.maximum(drive.signals["vehicle_speed"], LowSpeed.slowest)
    missing = np.full(len(speed), np.nan)
    columns = np.column_stack([drive.signals["road_wheel_angle"], speed, missing, missing])
    return scan(observer, columns)["mean.sideslip_angle"]


def error(sideslip_angle: np.ndarray, drive: Driven) -> float:
    """Root mean square error of a sideslip angle after the straight start [deg]."""
    difference = (sideslip_angle - drive.truths["sideslip_angle"])[drive.time >= STRAIGHT_ON]
    return float(np.degrees(np.sqrt(np.mean(difference**2))))
