"""Every observer of a motor's angle by name, and how it follows a drive."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.papers.motor_angle.dq_motor import DqMotorParameters
from tierod.papers.motor_angle.feedforward import FeedforwardAngle
from tierod.papers.motor_angle.feedforward_load import FeedforwardWithLoad
from tierod.papers.motor_angle.flux_observer import FluxObserver
from tierod.papers.motor_angle.observer_drives import SAMPLE_TIME, ObserverDrive
from tierod.papers.motor_angle.printed_observers import extended_kalman, luenberger, reduced_luenberger
from tierod.vehicles import load

SPEEDS = (0.0, 20.0, 40.0, 80.0, math.inf)
"""Edges of the ranges of speed [rad/s]."""


class Accuracy(NamedTuple):
    """How an observer follows: root mean squares of speed [rad/s] and angle [rad], the largest error of that [rad]."""

    speed: float
    angle: float
    largest: float


def parameters(name: str = "motor-bench") -> tuple[DqMotorParameters, SampledMotorParameters]:
    """Of a vehicle, for observers in the rotor's and in the stator's axes."""
    vehicle = load(name)
    return vehicle.parameters_for(DqMotorParameters), vehicle.parameters_for(SampledMotorParameters)


def methods(vehicle: str = "motor-bench") -> dict[str, Any]:
    """Every observer of a vehicle's motor by name."""
    dq, fixed = parameters(vehicle)
    found: dict[str, Any] = {}
    for name, make in (
        ("Luenberger", luenberger),
        ("reduced Luenberger", reduced_luenberger),
        ("Kalman filter", extended_kalman),
    ):
        found[f"{name}, as printed"] = make(dq, SAMPLE_TIME, load=False, axes="measured")
        found[f"{name}, with load"] = make(dq, SAMPLE_TIME, axes="measured")
        found[f"{name}, with load, own axes"] = make(dq, SAMPLE_TIME)
    found["feedforward, held when slow"] = FeedforwardAngle(fixed)
    found["feedforward, increments when slow"] = FeedforwardAngle(fixed, slow="increments")
    found["feedforward, increments, with load"] = FeedforwardWithLoad.of(fixed, slow="increments")
    found["flux observer"] = FluxObserver(fixed)
    found["default"] = MotorAngleObserver(fixed)
    return found


def accuracy(observer: Any, drives: list[ObserverDrive]) -> Accuracy:
    """How an observer follows some drives."""
    squares, largest = np.zeros(2), 0.0
    for seen in drives:
        found = seen.observed(observer)
        away = found["motor_angle"] - seen.angle
        squares += np.mean((found["motor_speed"] - seen.speed) ** 2), np.mean(away**2)
        largest = max(largest, float(np.abs(away).max()))
    speed, angle = np.sqrt(squares / len(drives))
    return Accuracy(float(speed), float(angle), largest)


def by_speed(observer: Any, drives: list[ObserverDrive]) -> list[float]:
    """Root mean square of the electrical error, whole turns left out, per range of speed [rad]."""
    error = np.concatenate([seen.observed(observer)["motor_angle"] - seen.angle for seen in drives])
    pole_pairs = parameters()[0].motor_pole_pairs
    within = np.angle(np.exp(1j * pole_pairs * error))
    speed = np.abs(np.concatenate([seen.speed for seen in drives]))
    return [float(np.sqrt(np.mean(within[(speed >= low) & (speed < high)] ** 2))) for low, high in pairwise(SPEEDS)]
