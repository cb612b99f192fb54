"""Vehicle files with typical tyres, and simple estimators of the sideslip for comparison."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.core.graph.maths import present, where
from tierod.core.recording import Recording
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.linear import discretise
from tierod.models.single_track import SingleTrack
from tierod.physics.single_track import front_axle_load
from tierod.vehicles.vehicle import Parameter, Vehicle
from tierod_lab.papers.sideslip.calibration import BesideTruth, truth_of

LINEAR: Any = discretise(SingleTrack, "midpoint")
RATE = 100.0

LINEAR_START = {
    "front": 8e4,
    "rear": 1.2e5,
    "yaw_rate": 0.01,
    "lateral_acceleration": 2.0,
    "sideslip_drift": 0.02,
    "yaw_drift": 0.3,
}
"""Initial cornering stiffnesses [N/rad], noises and drifts for the fit of the linear filter."""


@dataclass(frozen=True)
class LeakyKinematic:
    """Lateral speed as the leaky integral of lateral acceleration less yaw rate times speed."""

    sample_time: Annotated[float, "s"]  # sampling interval
    # time constant of the leak; a longer one drifts more, a shorter one loses long corners
    leak_time: Annotated[float, "s"]

    class Sample(NamedTuple):
        vehicle_speed: Annotated[Any, "m/s"]
        yaw_rate: Annotated[Any, "rad/s"]
        lateral_acceleration: Annotated[Any, "m/s**2"]

    def init(self) -> float:
        return 0.0

    def step(self, state: Any, sample: Any) -> tuple[Any, Any]:
        rate = sample.lateral_acceleration - sample.yaw_rate * sample.vehicle_speed - state / self.leak_time
        speed = where(present(rate), state + self.sample_time * rate, state)
        return speed, speed / sample.vehicle_speed


def signals(recording: Recording, names: tuple[str, ...], rate: float = RATE) -> tuple[np.ndarray, np.ndarray]:
    """Sampling times [s] and the named signals on that grid, (n,) and (n, k)."""
    aligned = recording.align(names, rate, maximum_age=0.1)
    return aligned.time, aligned.values


def beside(recording: Recording, estimate: np.ndarray, rate: float = RATE) -> BesideTruth:
    """An estimate without a band, paired with the truth of the recording."""
    time, truth = signals(recording, (truth_of(recording),), rate)
    return BesideTruth(time, estimate, np.full(len(time), np.nan), truth[:, 0])


def nothing(recording: Recording) -> BesideTruth:
    """The estimate of zero sideslip."""
    return beside(recording, np.zeros(len(signals(recording, ("vehicle_speed",))[0])))


def leaky(recording: Recording, until: float, leak_time: float = 1.5) -> BesideTruth:
    """The leaky integral, with gain (roll) and offset of the acceleration fitted to the part before a time [s]."""
    time, values = signals(recording, (*LeakyKinematic.Sample._fields, truth_of(recording)))
    block, speed, truth = LeakyKinematic(1.0 / RATE, leak_time), values[:, 0], values[:, 3]
    # The integral is linear in its inputs: with one part for the yaw rate and one for the acceleration, least squares
    # find the gain without another run.
    turning, accelerating = (
        scan(block, values[:, :3] * np.array(kept)).values[:, 0] for kept in ((1.0, 1.0, 0.0), (1.0, 0.0, 1.0))
    )
    columns = np.column_stack([accelerating, 1.0 / speed])
    early = (time < until) & np.isfinite(truth)
    gains = np.linalg.lstsq(columns[early], (np.tan(truth) - turning)[early], rcond=None)[0]
    return beside(recording, np.arctan(turning + columns @ gains))


def linear(recording: Recording, vehicle: Vehicle, until: float) -> BesideTruth:
    """A linear single-track Kalman filter; stiffnesses, noises and offsets are fitted to the part before a time [s]."""
    from scipy.optimize import least_squares

    names = ("road_wheel_angle", "vehicle_speed", "yaw_rate", "lateral_acceleration")
    _, values = signals(recording, names)
    # Units of 3 mrad for the zeros, and of 30 % for the other parameters, put all of them on one scale.
    offset, span = np.array([1.0, 0.0, 0.0, 0.0]), np.array([3e-3, 3e-3])

    def run(moved: np.ndarray) -> BesideTruth:
        tuned = dict(zip(LINEAR_START, np.array(list(LINEAR_START.values())) * np.exp(0.3 * moved[2:]), strict=True))
        zeros = span * moved[:2]
        out = scan(linear_filter(vehicle, tuned), values + zeros[0] * offset)
        return beside(recording, out["mean.sideslip_angle"] + zeros[1])

    def residuals(moved: np.ndarray) -> np.ndarray:
        seen = run(moved)
        # Without the first second of warm-up; the last terms keep the parameters near their start.
        return np.concatenate([np.degrees(seen.error[(seen.time < until)][100::10]), 0.3 * moved])

    return run(least_squares(residuals, np.zeros(2 + len(LINEAR_START)), diff_step=1e-3, max_nfev=15).x)


def linear_filter(vehicle: Vehicle, tuned: dict[str, float], rate: float = RATE) -> KalmanFilter:
    """A Kalman filter of the linear single-track model.

    Args:
        vehicle: vehicle file that gives mass, yaw inertia and axle distances
        tuned: stiffnesses, noises and drifts, as in `LINEAR_START`
        rate: sampling rate [Hz]
    """
    names = ("mass", "yaw_inertia", "front_distance", "rear_distance")
    mass, inertia, front, rear = (vehicle[name] for name in names)
    car = SingleTrack.Parameters(mass, inertia, front, rear, tuned["front"], tuned["rear"])
    return KalmanFilter(
        LINEAR,
        LINEAR.Parameters(car, 1.0 / rate),
        initial_mean=(0.0, 0.0),
        initial_variance=(0.01, 0.1),
        process_noise=(tuned["sideslip_drift"] ** 2 / rate, tuned["yaw_drift"] ** 2 / rate),
        measurement_noise=(tuned["yaw_rate"] ** 2, tuned["lateral_acceleration"] ** 2),
    )


def geometric(recording: Recording, until: float, rate: float = 50.0) -> BesideTruth:
    """Rear distance times yaw rate over speed, with the distance fitted to the part before a time.

    Args:
        until: end of the part that is fitted [s]
        rate: sampling rate [Hz]
    """
    time, values = signals(recording, ("yaw_rate", "vehicle_speed", truth_of(recording)), rate)
    curvature, truth = values[:, 0] / values[:, 1], values[:, 2]
    early = time < until
    distance = float(curvature[early] @ truth[early] / (curvature[early] @ curvature[early]))
    return beside(recording, distance * curvature, rate)


SLOWEST = 1.0  # Lower bound of the speed by which the simple estimates divide [m/s]

LINEAR_NOISES = {"yaw_rate": 0.01, "lateral_acceleration": 0.5, "sideslip_drift": 0.02, "yaw_drift": 0.3}
"""Guessed noises and drifts of the linear Kalman filter; its stiffnesses are those of the vehicle file."""


@dataclass(frozen=True)
class Class:
    """Typical tyres of a class of cars; assumed."""

    front_stiffness: float  # front_stiffness, rear_stiffness: cornering stiffness of an axle over its load [1/rad]
    rear_stiffness: float
    friction: float  # friction of the tyres on a dry road [-]


PASSENGER = Class(12.0, 17.0, 1.0)  # 205 mm summer tyres, softened by the compliance of a steered and of a fixed axle

SPORTS = Class(15.0, 21.0, 1.2)  # Tyres that are 25 % stiffer and have 20 % more grip than those of `PASSENGER`

LIGHT = Class(10.5, 13.0, 0.9)  # Narrow tyres of low pressure, as on quadricycles


def typical(car: Vehicle, kind: Class, **known: float) -> Vehicle:
    """Vehicle file as from tape measure, scale and brochure: without fitted tyres and noises.

    Args:
        car: vehicle file that gives mass, axle distances, steering ratio and drive share
        known: parameters that replace those of the file, such as a distance with a measuring error
    """
    kept = ("mass", "front_distance", "rear_distance", "steering_ratio", "drive_front_share")
    values = {name: car[name] for name in kept if name in car} | known
    mass, front, rear = (values[name] for name in kept[:3])
    values |= {
        # The usual estimate where none is measured: a dynamic index of one.
        "yaw_inertia": mass * front * rear,
        "front_cornering_stiffness": kind.front_stiffness * front_axle_load(mass, front, rear),
        # With the distances swapped: load of the rear axle.
        "rear_cornering_stiffness": kind.rear_stiffness * front_axle_load(mass, rear, front),
        "tyre_friction": kind.friction,
    }
    parameters = {
        name: Parameter(name, value, car.parameters[name].unit if name in car else "", None, "assumed: typical")
        for name, value in values.items()
    }
    return replace(car, parameters=parameters)


def measured_wrong(car: Vehicle, kind: Class, tape: float = 0.03, scale: float = 0.03) -> tuple[Vehicle, ...]:
    """Typical files with errors of tape [m] and scale (relative): first without error, then all eight corners."""
    corners = [(0.0, 0.0, 0.0), *((a, b, c) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0))]
    return tuple(
        typical(
            car,
            kind,
            front_distance=car["front_distance"] + front * tape,
            rear_distance=car["rear_distance"] + rear * tape,
            mass=car["mass"] * (1.0 + mass * scale),
        )
        for front, rear, mass in corners
    )


def kinematic(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """Sideslip angle as atan(rear distance * yaw rate / speed), without slip of the rear tyres."""
    speed, yaw_rate = _motion(recording, rate)
    return beside(recording, np.arctan(car["rear_distance"] * yaw_rate / speed), rate)


def steady(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """The kinematic sideslip angle less the slip angle of the rear axle in a steady turn, with linear tyres."""
    speed, yaw_rate = _motion(recording, rate)
    wheelbase = car["front_distance"] + car["rear_distance"]
    force = car["mass"] * car["front_distance"] / wheelbase * speed * yaw_rate
    slip = force / car["rear_cornering_stiffness"]
    return beside(recording, np.arctan(car["rear_distance"] * yaw_rate / speed - slip), rate)


def linear_kalman(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """A Kalman filter of the linear single-track model with the same typical tyres."""
    names = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "road_wheel_angle", "steering_wheel_angle")
    _, values = signals(recording, names, rate)
    angle = np.where(np.isfinite(values[:, 3]), values[:, 3], car["steering_ratio"] * values[:, 4])
    stiffness = {axle: car[f"{axle}_cornering_stiffness"] for axle in ("front", "rear")}
    filter = linear_filter(car, LINEAR_NOISES | stiffness, rate)
    speed = np.maximum(values[:, 0], 2.0 * SLOWEST)
    out = scan(filter, np.column_stack([angle, speed, values[:, 1:3]]))
    return beside(recording, out["mean.sideslip_angle"], rate)


SIMPLE = {
    "kinematics": kinematic,
    "steady single track": steady,
    "linear Kalman filter": linear_kalman,
}
"""Name in the tables -> simple estimator, which a user would take otherwise."""


def _motion(recording: Recording, rate: float) -> tuple[np.ndarray, np.ndarray]:
    _, values = signals(recording, ("vehicle_speed", "yaw_rate"), rate)
    return np.maximum(values[:, 0], SLOWEST), values[:, 1]
