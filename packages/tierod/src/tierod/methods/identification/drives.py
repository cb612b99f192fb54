"""Ordinary drives for the identification of a vehicle: signals on one grid, lateral motion, and likelihood."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Model, Scalar, Tree, model_like, rebuild
from tierod.core.errors import InputError
from tierod.core.graph.maths import both, log, present, sqrt, where
from tierod.core.recording import Recording
from tierod.io.derive import complete, ingredients
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import Vector, correct_in_turn, from_diagonal, plus, upper
from tierod.methods.estimators.shapes import Belief, leaf_values
from tierod.models.lateral_motion import LateralParameters, Sampled, lateral_motion
from tierod.physics.friction import gauss_markov_noise
from tierod.physics.motion import GRAVITY
from tierod.vehicles import Vehicle

UNKNOWNS = ("bank_angle", "lateral_acceleration_bias", "yaw_rate_bias", "road_wheel_angle_offset")
_MOTION = lateral_motion(UNKNOWNS, roll=True)
MOVING = ("lateral_speed", "yaw_rate", "front_deflection", "rear_deflection", "roll_angle", "roll_rate")

# Standard deviations of the motion at the start of a stretch of driving, in the units of the states
START = {
    "lateral_speed": 0.3,
    "yaw_rate": 0.1,
    "front_deflection": 0.01,
    "rear_deflection": 0.01,
    "roll_angle": 0.01,
    "roll_rate": 0.03,
}

GATE = 16.0  # Gate of the filter: bound of a squared innovation over its variance, beyond which the noise is raised


class DriveState(NamedTuple):
    """Motion with its unknowns, and the steering angle reading straight ahead, at the road wheels."""

    motion: _MOTION.State  # type: ignore[name-defined]  # made at run time
    steering_zero: Annotated[float, "rad"]


@dataclass(frozen=True)
class DriveParameters:
    """Parameters of the model."""

    sampled: Sampled  # of the lateral motion
    # share of the lateral acceleration in a bend that the bank of the road compensates
    superelevation: Annotated[float, ""] = 0.0


def _driven(x: DriveState, u: Tree) -> Tree:
    return u._replace(road_wheel_angle=u.road_wheel_angle - x.steering_zero)


def _transition(x: DriveState, u: Tree, p: DriveParameters) -> DriveState:
    bank, pulled = x.motion.bank_angle, u.vehicle_speed * x.motion.yaw_rate
    # Roads are banked in bends: this part of the bank follows the bend, only the deviation from it is a state.
    on_road = x.motion._replace(bank_angle=bank - p.superelevation / GRAVITY * pulled)
    moved = _MOTION.transition(on_road, _driven(x, u), p.sampled)
    return DriveState(moved._replace(bank_angle=bank * p.sampled.fading[0]), x.steering_zero)


def _output(x: DriveState, u: Tree, p: DriveParameters) -> Tree:
    return _MOTION.output(x.motion, _driven(x, u), p.sampled)


DRIVE_MODEL: Model = model_like(
    _MOTION,
    "DriveModel",
    "Lateral motion with a zero of the steering angle.",
    State=DriveState,
    Parameters=DriveParameters,
    transition=_transition,
    output=_output,
)


@dataclass(frozen=True)
class DriveNoises:
    """Noises of model and sensors in an ordinary drive, named as in a vehicle file where it has them."""

    # yaw_rate_noise, lateral_acceleration_noise: standard deviation of one measurement
    yaw_rate_noise: Annotated[float, "rad/s"] = 0.004
    lateral_acceleration_noise: Annotated[float, "m/s**2"] = 0.3
    # lateral_speed_drift, yaw_rate_drift: growth of the model error per square root of time
    lateral_speed_drift: Annotated[float, "m/s**1.5"] = 0.05
    yaw_rate_drift: Annotated[float, "rad/s**1.5"] = 0.02
    roll_rate_drift: Annotated[float, "rad/s**1.5"] = 0.002  # growth of the model error per square root of time
    # bank_wander, bank_wander_time: standard deviation and correlation time of the bank beside the superelevation
    bank_wander: Annotated[float, "rad"] = 0.015
    bank_wander_time: Annotated[float, "s"] = 10.0
    # share of the lateral acceleration in a bend that the bank of the road compensates
    superelevation: Annotated[float, ""] = 0.1
    # road_wheel_angle_wander, road_wheel_angle_wander_time: standard deviation and correlation time of the error of the
    # angle, by twist and gears
    road_wheel_angle_wander: Annotated[float, "rad"] = 0.001
    road_wheel_angle_wander_time: Annotated[float, "s"] = 3.0
    # lateral_acceleration_zero, yaw_rate_zero, steering_zero: prior standard deviations of the sensor zeros
    lateral_acceleration_zero: Annotated[float, "m/s**2"] = 0.2
    yaw_rate_zero: Annotated[float, "rad/s"] = 0.01
    steering_zero: Annotated[float, "rad"] = 0.005


def drive_filter(car: LateralParameters, noises: DriveNoises, sample_time: float) -> KalmanFilter:
    """The Kalman filter of a car in a drive. Args: sample_time: sampling interval [s]."""
    bank = noises.bank_wander, noises.bank_wander_time
    angle = noises.road_wheel_angle_wander, noises.road_wheel_angle_wander_time
    fading = (math.exp(-sample_time / bank[1]), 1.0, 1.0, math.exp(-sample_time / angle[1]))
    deviations = (
        *(START[name] for name in MOVING),
        *(noises.bank_wander, noises.lateral_acceleration_zero, noises.yaw_rate_zero),
        *(noises.road_wheel_angle_wander, noises.steering_zero),
    )
    process = (
        noises.lateral_speed_drift**2 * sample_time,
        noises.yaw_rate_drift**2 * sample_time,
        None,
        None,
        None,
        noises.roll_rate_drift**2 * sample_time,
        float(gauss_markov_noise(*bank, sample_time)),
        None,
        None,
        float(gauss_markov_noise(*angle, sample_time)),
        None,
    )
    return KalmanFilter(
        DRIVE_MODEL,
        DriveParameters(Sampled(car, sample_time, usual=(0.0,) * len(UNKNOWNS), fading=fading), noises.superelevation),
        initial_mean=(0.0,) * len(deviations),
        initial_variance=tuple(each**2 for each in deviations),
        process_noise=process,
        measurement_noise=(noises.yaw_rate_noise**2, noises.lateral_acceleration_noise**2),
        gate=GATE,
    )


# Speed below which samples are left out [m/s]: slow tyres give little information, and the steer is large
SLOWEST = 2.0


class DriveSample(NamedTuple):
    """Signals of an ordinary drive; NaN where missing."""

    vehicle_speed: Annotated[Scalar, "m/s"]
    longitudinal_acceleration: Annotated[Scalar, "m/s**2"]
    steering_angle: Annotated[Scalar, "rad"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    lateral_acceleration: Annotated[Scalar, "m/s**2"]


class DriveScore(NamedTuple):
    """Innovations of a sample over their standard deviations, logarithms of the latter, and estimated sensor zeros.

    The zeros, with their variances, are those of steering angle at the road wheels, yaw rate and lateral acceleration
    after the sample.
    """

    whitened_yaw_rate: Annotated[Scalar, ""]
    whitened_lateral_acceleration: Annotated[Scalar, ""]
    spread_yaw_rate: Annotated[Scalar, ""]
    spread_lateral_acceleration: Annotated[Scalar, ""]
    steering_zero: Annotated[Scalar, "rad"]
    yaw_rate_zero: Annotated[Scalar, "rad/s"]
    lateral_acceleration_zero: Annotated[Scalar, "m/s**2"]
    steering_variance: Annotated[Scalar, "rad**2"]
    yaw_rate_variance: Annotated[Scalar, "rad**2/s**2"]
    lateral_acceleration_variance: Annotated[Scalar, "m**2/s**4"]


@dataclass(frozen=True)
class DriveLikelihood:
    filter: KalmanFilter  # from `drive_filter`
    ratio: Annotated[float, ""]  # road-wheel angle over the measured angle

    Sample = DriveSample
    Output = DriveScore

    def init(self) -> Belief:
        return self.filter.init()

    def step(self, state: Belief, sample: DriveSample) -> tuple[Belief, DriveScore]:
        """State and score after one sample; below `SLOWEST` the motion is reset and the zeros are kept."""
        kind = self.filter.model
        angle = self.ratio * sample.steering_angle
        running = both(both(present(sample.vehicle_speed), present(angle)), sample.vehicle_speed > SLOWEST)
        inputs = kind.Input(
            where(running, sample.vehicle_speed, SLOWEST),
            where(present(sample.longitudinal_acceleration), sample.longitudinal_acceleration, 0.0),
            where(running, angle, 0.0),
        )
        given = self.filter.Sample(inputs, kind.Output(sample.yaw_rate, sample.lateral_acceleration))
        belief, whitened, spread = self._filtered(state, given)
        mean = [where(running, a, b) for a, b in zip(leaf_values(belief.mean), self._still(state), strict=True)]
        covariance = [
            where(running, a, b) for a, b in zip(belief.covariance, self._forgotten(state.covariance), strict=True)
        ]
        after = Belief(rebuild(state.mean, mean), tuple(covariance))
        size = len(mean)
        at = {pair: k for k, pair in enumerate(upper(size))}
        zeros = (size - 1, 8, 7)  # places of steering zero, yaw rate bias and lateral acceleration bias in the state
        score = DriveScore(
            *(where(running, each, 0.0) for each in (*whitened, *spread)),
            *(mean[k] for k in zeros),
            *(covariance[at[k, k]] for k in zeros),
        )
        return after, score

    def _filtered(self, state: Belief, sample: Tree) -> tuple[Belief, list[Scalar], list[Scalar]]:
        predicted = self.filter._predict(state, sample.input, leaf_values(self.filter.process_noise), ())
        rows, residuals, known = self.filter.innovations(predicted, sample)
        noise = self.filter.bounded_noise(leaf_values(self.filter.measurement_noise), known, residuals)
        done = correct_in_turn(predicted.covariance, rows, residuals, noise)
        mean = [plus(a, b) for a, b in zip(predicted.mean, done.correction.shift, strict=True)]
        whitened, spread = [], []
        for residual, variance in zip(done.residuals, done.spreads, strict=True):
            there = present(residual)
            whitened.append(where(there, residual, 0.0) / sqrt(variance))
            spread.append(where(there, 0.5 * log(variance), 0.0))
        return Belief(rebuild(state.mean, mean), done.correction.covariance), whitened, spread

    def _still(self, state: Belief) -> Vector:
        """Mean at standstill: zero motion, other states unchanged."""
        values = leaf_values(state.mean)
        return tuple(0.0 if k < len(MOVING) else value for k, value in enumerate(values))

    def _forgotten(self, covariance: Vector) -> Vector:
        """Covariance at standstill: the initial one for the motion, without correlation with the other states."""
        first = from_diagonal(leaf_values(self.filter.initial_variance))
        moving = len(MOVING)
        pairs = upper(len(leaf_values(self.filter.initial_variance)))
        return tuple(a if i < moving else b for (i, _), a, b in zip(pairs, first, covariance, strict=True))


RATE = 50.0  # Sample rate [Hz]; yaw and roll of a car are below 5 Hz
HELD = 0.2  # Longest gap of a speed or an angle that is bridged [s]
LEAST_DRIVEN = 30.0  # Smallest time of a drive above the slowest speed [s]
SPEED, ALONG, LATERAL, YAW = "vehicle_speed", "longitudinal_acceleration", "lateral_acceleration", "yaw_rate"
# Candidates for the steering angle; the first one that a recording contains is used
ANGLES = ("road_wheel_angle", "steering_wheel_angle")
SIGNALS = ingredients((SPEED, ALONG, *ANGLES, YAW, LATERAL))


class Drive(NamedTuple):
    """One drive, resampled for identification."""

    name: str
    samples: np.ndarray  # of `DriveSample`, (n, 5); inputs of the model are means since the sample before
    angle: str  # name of the signal of the steering angle
    driven: float  # time above the slowest speed with all signals [s]


def drive_of(name: str, recording: Recording) -> Drive:
    recording = complete(recording, (SPEED,))
    angle = next((each for each in ANGLES if each in recording), ANGLES[1])
    for wanted in (SPEED, angle, YAW):
        if wanted not in recording or not np.isfinite(recording[wanted].values).any():
            raise InputError(
                f"{name} has no '{wanted}'; identification of a vehicle needs speed (or both rear wheel speeds), "
                "steering angle and yaw rate. 'tierod inspect' shows what the recording has; name it in the channel map"
            )
    driven = recording.align((SPEED, ALONG, angle), RATE, "linear", maximum_age=HELD).values
    read = recording.align((YAW, LATERAL), RATE, maximum_age=0.999 / RATE).values
    # The model takes its inputs as constant over the sample that ends, hence their means.
    driven[1:] = 0.5 * (driven[1:] + driven[:-1])
    samples = np.column_stack([driven, read])
    seconds = _seconds_driven(samples)
    if seconds < LEAST_DRIVEN:
        raise InputError(
            f"{name} holds {seconds:.0f} s of driving above {SLOWEST:g} m/s with all signals; identification of a "
            f"vehicle needs {LEAST_DRIVEN:g} s, better ten minutes of town and country road"
        )
    return Drive(name, samples, angle, seconds)


def drives_of(recordings: Mapping[str, Recording]) -> list[Drive]:
    return [drive_of(name, recording) for name, recording in recordings.items()]


def _seconds_driven(samples: np.ndarray) -> float:
    fast = np.nan_to_num(samples[:, 0]) > SLOWEST
    return float(np.count_nonzero(fast & np.isfinite(samples[:, 2]) & np.isfinite(samples[:, 3]))) / RATE


# Largest difference of two recordings of one drive [-]: of the yaw rates over their spread, of the speeds over their
# mean, root mean squares. Rounding and resampling make a tenth of it; laps of one driver differ by 0.3 and 0.05.
YAW_ALIKE, SPEED_ALIKE = 0.15, 0.02
SHORTEST: Annotated[float, "s"] = 30.0  # Shortest common time of two recordings of one drive
SAME_ANGLE = 0.02  # Relative difference of two steering angles up to which they are one signal [-]
# Factor by which the steering angle must be too large or too small to be one of another place [-]; ratios of a class
# differ by a tenth, steering and road wheels by 12 and more
ELSEWHERE = 2.0
SLOW: Annotated[float, "m/s"] = 12.0  # Speed up to which the geometry of the turn makes most of the steering angle
TURNING: Annotated[float, "rad/s"] = 0.05  # Yaw rate from which a turn counts, above offsets of the sensor
_ELSEWHERE = "measured at another place, such as the road wheels, or has another unit"


class Twice(NamedTuple):
    """Two recordings of one drive."""

    first: str
    second: str
    factor: float  # steering angle of the second over that of the first; NaN where they are not in proportion

    def __str__(self) -> str:
        same = f"{self.first} and {self.second} hold the same drive"
        size = abs(self.factor)
        unlike = [] if self.factor > 0.0 or math.isnan(size) else ["have opposite signs"]
        elsewhere = not abs(size - 1.0) < SAME_ANGLE
        if math.isnan(size):
            unlike.append("are not in proportion")
        elif elsewhere:
            unlike.append(f"differ by a factor of {max(size, 1.0 / size):.3g}")
        if not unlike:
            return f"{same}; it counts once: leave one out"
        place = f": one of them is {_ELSEWHERE}" if elsewhere else ""
        return (
            f"{same}, and their steering angles {' and '.join(unlike)}{place}; the drive counts once: leave out the "
            "file whose angle is not that of the channel map"
        )


def refuse_unlike(drives: Sequence[Drive], vehicle: Vehicle) -> None:
    """Refuse recordings of the same drive, whose evidence must count once, and angles of other places than stated."""
    for place, second in enumerate(drives):
        for first in drives[:place]:
            if (found := given_twice(first, second)) is not None:
                raise InputError(str(found))
    if len({each.angle for each in drives}) > 1:
        first, second = drives[0], next(each for each in drives if each.angle != drives[0].angle)
        raise InputError(
            f"{first.name} gives {first.angle} and {second.name} {second.angle}: identify from drives with the same "
            "angle, or leave the other one out of the channel map"
        )
    wheelbase = vehicle["front_distance"] + vehicle["rear_distance"]
    for each in drives:
        if said := _contradicted(each, 1.0 if each.angle == ANGLES[0] else vehicle["steering_ratio"], wheelbase):
            raise InputError(said)


def given_twice(first: Drive, second: Drive) -> Twice | None:
    """The two drives as one, if speed and yaw rate are the same over a common time; clocks may begin elsewhere."""
    lag = _lag(np.nan_to_num(first.samples[:, 3]), np.nan_to_num(second.samples[:, 3]))
    one, other = first.samples[max(lag, 0) :], second.samples[max(-lag, 0) :]
    count = min(len(one), len(other))
    one, other = one[:count], other[:count]
    both = np.isfinite(one[:, [0, 3]]).all(axis=1) & np.isfinite(other[:, [0, 3]]).all(axis=1)
    if both.sum() < SHORTEST * RATE:
        return None
    one, other = one[both], other[both]
    turn, speed = one[:, 3], one[:, 0]
    yaw = _rms(turn - other[:, 3]) / max(float(np.std(turn)), 1e-9)
    if yaw > YAW_ALIKE or _rms(speed - other[:, 0]) > SPEED_ALIKE * max(float(np.mean(speed)), 1e-9):
        return None
    known = np.isfinite(one[:, 2]) & np.isfinite(other[:, 2])
    angle, again = one[known, 2], other[known, 2]
    factor = float(again @ angle / max(float(angle @ angle), 1e-12))
    alike = abs(factor) > 1e-6 and _rms(again - factor * angle) < YAW_ALIKE * _rms(again)
    return Twice(first.name, second.name, factor if alike else math.nan)


def _angle_factor(drive: Drive, ratio: float, wheelbase: float) -> float:
    """Measured steering angle over that of the geometry of slow turns; NaN with too little turning."""
    speed, angle, yaw_rate = (drive.samples[:, place] for place in (0, 2, 3))
    with np.errstate(invalid="ignore"):
        used = np.isfinite(angle) & (speed > 2.0) & (speed < SLOW) & (np.abs(yaw_rate) > TURNING)
    if used.sum() < RATE:
        return math.nan
    expected = np.arctan(wheelbase * yaw_rate[used] / speed[used]) / ratio
    return float(angle[used] @ expected / (expected @ expected))


def _contradicted(drive: Drive, ratio: float, wheelbase: float) -> str:
    """Sentence on a steering angle whose sign or size the geometry of slow turns contradicts; empty if it fits."""
    factor = _angle_factor(drive, ratio, wheelbase)
    if math.isnan(factor):
        return ""
    said = []
    if factor < 0.0:
        said.append(f"{drive.angle} and yaw_rate have opposite signs in slow turns, one of them a wrong one")
    if not 1.0 / ELSEWHERE < abs(factor) < ELSEWHERE:
        said.append(
            f"{drive.angle} is {abs(factor):.2g} times what speed, yaw rate and the steering_ratio of the vehicle file "
            f"give in slow turns, so it is {_ELSEWHERE}"
        )
    return f"{drive.name}: {'; '.join(said)}: correct the channel map" if said else ""


def _lag(one: np.ndarray, other: np.ndarray) -> int:
    """Sample of the first series at which the second begins, by their largest cross-correlation; may be negative."""
    size = 1 << (len(one) + len(other) - 1).bit_length()
    product = np.fft.irfft(np.fft.rfft(one, size) * np.conj(np.fft.rfft(other, size)), size)
    best = int(np.argmax(product))
    return best if best < len(one) else best - size


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values * values)))
