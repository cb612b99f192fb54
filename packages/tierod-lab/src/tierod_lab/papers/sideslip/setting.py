"""Setting of the sideslip studies: two virtual cars steered by wire, their sensors and their drives."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from tierod.core.recording import Recording
from tierod.models.steer_by_wire import Actuator
from tierod.vehicles import load
from tierod_lab.ground import Sensor, SensorSet, SingleTrack, run
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.courses.course import Adhesion, AnyCondition, Breeze, Course, Slope
from tierod_lab.ground.courses.manoeuvres import SineSteer

RATE = 1000.0  # Sampling rate [Hz]

SENSORS = SensorSet(
    {
        "yaw_rate": Sensor(noise=0.003, rate=RATE),
        "road_wheel_angle": Sensor(noise=2e-4, rate=RATE),
        "vehicle_speed": Sensor(noise=0.01, rate=RATE),
        "motor_current": Sensor(noise=0.02, rate=RATE),
        "lateral_acceleration": Sensor(noise=0.05, rate=RATE),
        "longitudinal_acceleration": Sensor(noise=0.05, rate=RATE),
    },
    "A test car steered by wire, every millisecond: the sensors of the paper's car are not printed.",
)
"""Sensors with the noise of a good gyroscope and of an encoder at the pinion."""

STRAIGHT_ON = 2.0  # Duration of straight driving at the start of every drive [s], which is not judged


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


def neutral(car: Any) -> Any:
    """The car with a softer rear axle, which makes it neutral: C_r = C_f a / b."""
    front = 100e3
    rear = front * 1.33 / 1.31
    if isinstance(car.chassis, SingleTrack):
        return dataclasses.replace(car, chassis=dataclasses.replace(car.chassis, rear_stiffness=rear))
    return dataclasses.replace(car, chassis=car.chassis.with_axle_stiffness(front, rear))


CARS = {"virtual car": virtual_car, "brush tyres": brush_car}  # Name in the tables -> maker of the car


@dataclass(frozen=True)
class Drive:
    """One drive with sine steer."""

    speed: float  # speed [m/s]
    steer: float  # amplitude of the road-wheel angle [deg]
    frequency: float  # frequency of the sine [Hz]
    conditions: tuple[AnyCondition, ...] = ()  # disturbances by road and wind
    neutral: bool = False  # whether the car is made neutral
    periods: int = 5  # number of periods of the sine

    def course(self) -> Course:
        """The drive as a course of the proving ground."""
        return SineSteer(
            speed=self.speed,
            amplitude=math.radians(self.steer) / steering_ratio(),
            frequency=self.frequency,
            periods=self.periods,
            settle=STRAIGHT_ON,
            rest=2.0,
            conditions=self.conditions,
        )


SLOW = Drive(6.7, 8.0, 0.25)
FAST = Drive(25.0, 1.3, 0.3)
"""The two manoeuvres of the tables: that of the paper's test, and one at the speed of a country road."""

SLIPPERY = (Adhesion(left=0.35, right=0.35),)
BANKED = (Slope(bank=math.radians(3.0)),)
WINDY = (Breeze(crosswind=-6.7),)
"""Conditions with a low road friction, with a bank, and with a crosswind: 500 N to the right at 25 m/s."""


@dataclass(frozen=True)
class Driven:
    """Signals and truth of a drive on one time grid."""

    time: np.ndarray  # sampling times [s], (n,)
    signals: dict[str, np.ndarray] = field(default_factory=dict)  # measured signals by name, (n,) each
    # true signals by name without the prefix `truth_`, (n,) each
    truths: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def judged(self) -> np.ndarray:
        """Whether a sample lies after the straight start, (n,)."""
        return self.time >= STRAIGHT_ON

    def torque(self) -> np.ndarray:
        """Actuator torque at the road wheels [N m], from the motor current by the vehicle file, (n,)."""
        return actuator().road_wheel_torque(actuator().motor_torque(self.signals["motor_current"]))


def driven(car: Any, course: Course, seed: int) -> Driven:
    """Drives a car over a course."""
    return of_recording(run(car, course, seed=seed, sensors=SENSORS).recording)


def on(drive: Drive, name: str, seed: int) -> Driven:
    """Drives a car of `CARS`."""
    car = CARS[name]()
    return driven(neutral(car) if drive.neutral else car, drive.course(), seed)


def of_recording(recording: Recording) -> Driven:
    """Signals and truth of a recording; the truth is interpolated to the times of the yaw rate."""
    time = recording["yaw_rate"].time
    truths = {
        name.removeprefix("truth_"): np.interp(time, recording[name].time, recording[name].values)
        for name in recording.names
        if name.startswith("truth_")
    }
    return Driven(time, {name: recording[name].values for name in SENSORS.sensors}, truths)


@cache
def actuator() -> Actuator:
    """Actuator of the vehicle file."""
    return load("steer-by-wire").parameters_for(Actuator)


def steering_ratio() -> float:
    """Steering ratio of the vehicle file."""
    return actuator().steering_ratio
