"""A real car with a reference of the sideslip and without a steering torque: race laps."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.linear import discretise
from tierod.models.single_track import SingleTrack
from tierod.vehicles import Vehicle, load
from tierod_lab.papers import real_data
from tierod_lab.papers.sideslip.calibration import BesideTruth, beside_truth, truth_of, with_parameters
from tierod_lab.studies.metrics import Row


@dataclass(frozen=True)
class RealCar:
    """A real car with its recording."""

    file: tuple[str, str]  # folder and file of the recording
    vehicle: str  # vehicle file that was fitted to it

    def recording(self) -> Recording | None:
        """The recording; None where it or the library of its reader is missing."""
        return real_data.recorded(*self.file, channel_map=load(self.vehicle).channel_map)


RACE = RealCar(("ferrari_250lm_race", "laps.parquet"), "ferrari-250lm")
RATE = 100.0  # Sampling rate [Hz]
FITTED = 0.6  # Share of the laps to which parameters were fitted; the rest is judged [-]
NOISES = {"yaw_rate": 0.01, "lateral_acceleration": 0.5, "sideslip_drift": 0.02, "yaw_drift": 0.3}
"""Guessed noises and drifts of the linear Kalman filter."""


def _beside(recording: Recording, estimate: np.ndarray, time: np.ndarray) -> BesideTruth:
    truth = recording.align((truth_of(recording),), RATE, maximum_age=0.1).values[:, 0]
    return BesideTruth(time, estimate, np.full(len(time), math.nan), truth)


def simple(recording: Recording, car: Vehicle) -> dict[str, BesideTruth]:
    """Estimates that a user would take otherwise, with the tyres of the vehicle file, by name."""
    names = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "road_wheel_angle")
    aligned = recording.align(names, RATE, maximum_age=0.1)
    speed = np.maximum(aligned.values[:, 0], 2.0)
    yaw_rate, acceleration, steer = aligned.values[:, 1:].T
    rolling = car["rear_distance"] * yaw_rate / speed
    share = car["front_distance"] / (car["front_distance"] + car["rear_distance"])
    slip = car["mass"] * share * speed * yaw_rate / car["rear_cornering_stiffness"]
    outputs = scan(_linear_filter(car), np.column_stack([steer, speed, yaw_rate, acceleration]))
    found = {
        "sideslip of zero": np.zeros(len(speed)),
        "kinematics": np.arctan(rolling),
        "steady single track": np.arctan(rolling - slip),
        "linear Kalman filter": outputs["mean.sideslip_angle"],
    }
    return {name: _beside(recording, values, aligned.time) for name, values in found.items()}


def _linear_filter(car: Vehicle) -> KalmanFilter:
    model = discretise(SingleTrack, "midpoint")
    return KalmanFilter(
        model,
        model.Parameters(car.parameters_for(SingleTrack.Parameters), 1.0 / RATE),
        initial_mean=(0.0, 0.0),
        initial_variance=(0.01, 0.1),
        process_noise=(NOISES["sideslip_drift"] ** 2 / RATE, NOISES["yaw_drift"] ** 2 / RATE),
        measurement_noise=(NOISES["yaw_rate"] ** 2, NOISES["lateral_acceleration"] ** 2),
    )


def _row(seen: BesideTruth, start: float, **more: str) -> Row:
    found = seen.figures(start)
    covered = found.coverage if seen.result is not None else math.nan
    return {**more, "mean": math.degrees(found.mean_absolute), "rms": math.degrees(found.rms), "covered": covered}


def race_laps(wrong: bool) -> list[Row]:
    """A Ferrari 250 LM in a race, 275 s, beside an inertial navigation system that wanders by some 0.14 degrees.

    Tyres, noises, place of the accelerometer, and the zeros of steering sensor and INS were fitted to the first 60 %;
    the last 40 % are judged. Then one stiffness at a time is wrong by a fifth. Simple estimates have the same tyres.
    """
    laps = RACE.recording()
    if laps is None:
        return []
    first, last = laps["sideslip_angle"].time[[0, -1]].tolist()
    car, until = load(RACE.vehicle), first + FITTED * (last - first)
    found = {**simple(laps, car), "combined": beside_truth(laps, car)}
    rows = [_row(each, until, estimator=name, wrong="") for name, each in found.items()]
    for axle, factor in itertools.product(("front", "rear"), (1.2, 0.8)) if wrong else ():
        name = f"{axle}_cornering_stiffness"
        seen = beside_truth(laps, with_parameters(car, {name: factor * car[name]}))
        rows.append(_row(seen, until, estimator="combined", wrong=f"{axle} {100.0 * (factor - 1.0):+.0f} %"))
    return rows
