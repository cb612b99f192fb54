"""The compared estimators: both observers, each with placed poles and with Kalman gains, and two without feedback."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache

import numpy as np

from tierod.core.block import Model
from tierod.core.graph import Result, scan
from tierod.methods.estimators.observers import Luenberger
from tierod.models.linear import discretise
from tierod.models.single_track import SingleTrack
from tierod_lab.papers.sideslip.conventional import conventional_kalman, conventional_poles
from tierod_lab.papers.sideslip.observer import LowSpeed, SteeringTorqueObserver
from tierod_lab.papers.sideslip.setting import RATE, Driven
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.two_stage import two_stage_kalman, two_stage_poles

Build = Callable[[SteeredVehicle.Parameters, float], SteeringTorqueObserver]

OBSERVERS: dict[str, Build] = {
    "conventional, poles x10": conventional_poles,
    "conventional, Kalman": conventional_kalman,
    "two-stage, poles x2": two_stage_poles,
    "two-stage, Kalman": two_stage_kalman,
}
"""Name in the tables -> maker of the observer."""

MODEL, INVERSION = "model only", "torque inverted"
NAMES = (*OBSERVERS, MODEL, INVERSION)


@dataclass(frozen=True)
class Course:
    """Course of an estimate over a drive."""

    sideslip_angle: np.ndarray  # estimated sideslip angle [rad], (n,)
    result: Result | None = None  # all outputs of the observer; None for an estimate without feedback


def samples(drive: Driven) -> np.ndarray:
    """Samples of an observer over a drive, columns in the order of its fields, (n, 4)."""
    names = ("vehicle_speed", "yaw_rate", "road_wheel_angle")
    return np.column_stack([*(drive.signals[name] for name in names), drive.torque()])


def courses(p: SteeredVehicle.Parameters, drive: Driven) -> dict[str, Course]:
    """Runs every estimator of `NAMES` with the parameters over a drive."""
    found = {name: observed(built(name, p), drive) for name in OBSERVERS}
    found[MODEL] = Course(open_loop(SingleTrack, p, drive))
    found[INVERSION] = Course(inverted(p, drive, found["two-stage, poles x2"]))
    return found


@cache
def built(name: str, p: SteeredVehicle.Parameters) -> SteeringTorqueObserver:
    """An observer of `OBSERVERS` with the parameters."""
    return OBSERVERS[name](p, 1.0 / RATE)


def observed(observer: SteeringTorqueObserver, drive: Driven) -> Course:
    """Runs an observer over a drive."""
    result = scan(observer, samples(drive))
    return Course(result["sideslip_angle"], result)


def open_loop(model: Model, p: SteeredVehicle.Parameters, drive: Driven) -> np.ndarray:
    """Sideslip angle [rad] of a single-track model driven by the measured steer angle, without feedback, (n,)."""
    sampled = discretise(model, "midpoint")
    own = SingleTrack.Parameters(*(getattr(p, field.name) for field in fields(SingleTrack.Parameters)))
    # With gains of zero, and NaN as measurements, the observer only predicts.
    observer = Luenberger(sampled, sampled.Parameters(own, 1.0 / RATE), (0.0, 0.0), ((0.0, 0.0), (0.0, 0.0)))
    speed = np.maximum(drive.signals["vehicle_speed"], LowSpeed.slowest)
    missing = np.full(len(speed), np.nan)
    columns = np.column_stack([drive.signals["road_wheel_angle"], speed, missing, missing])
    return scan(observer, columns)["mean.sideslip_angle"]


def inverted(p: SteeredVehicle.Parameters, drive: Driven, observer: Course) -> np.ndarray:
    """Sideslip angle [rad] from the observed self-aligning torque by eq (12), without filtering, (n,)."""
    assert observer.result is not None
    speed = np.maximum(drive.signals["vehicle_speed"], LowSpeed.slowest)
    stiffness = (p.mechanical_trail + p.pneumatic_trail) * p.front_cornering_stiffness
    steer, yaw_rate = drive.signals["road_wheel_angle"], drive.signals["yaw_rate"]
    force: np.ndarray = observer.result["self_aligning_torque"] / stiffness
    sideslip: np.ndarray = steer - p.front_distance * yaw_rate / speed - force
    return sideslip


def error(course: Course, drive: Driven) -> float:
    """Root mean square error of the sideslip angle over the judged samples [deg]."""
    difference = (course.sideslip_angle - drive.truths["sideslip_angle"])[drive.judged]
    return float(np.degrees(np.sqrt(np.mean(difference**2))))
