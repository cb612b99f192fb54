"""Ordinary drives for the identification of a vehicle: required signals on one grid, each drive given once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.io.derive import complete, ingredients
from tierod.methods.identification.drive_model import SLOWEST
from tierod.vehicles import Vehicle

RATE = 50.0  # Sample rate [Hz]; yaw and roll of a car are below 5 Hz
HELD = 0.2  # Longest gap of a speed or an angle that is bridged [s]
LEAST_DRIVEN = 30.0  # Smallest time of a drive above the slowest speed [s]

SPEED, ALONG, LATERAL, YAW = "vehicle_speed", "longitudinal_acceleration", "lateral_acceleration", "yaw_rate"
ANGLES = ("road_wheel_angle", "steering_wheel_angle")
"""Candidates for the steering angle; the first one that a recording contains is used."""
SIGNALS = ingredients((SPEED, ALONG, *ANGLES, YAW, LATERAL))


class Drive(NamedTuple):
    """One drive, resampled for identification."""

    name: str
    samples: np.ndarray  # of `DriveSample`, (n, 5); inputs of the model are means since the sample before
    angle: str  # name of the signal of the steering angle
    driven: float  # time above the slowest speed with all signals [s]


def drive_of(name: str, recording: Recording) -> Drive:
    """Conversion of a recording to a drive.

    Args:
        recording: with speed or rear wheel speeds, steering angle and yaw rate, preferably with lateral acceleration

    Raises:
        InputError: a signal is missing, or the car hardly moves
    """
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
    seconds = _driven(samples)
    if seconds < LEAST_DRIVEN:
        raise InputError(
            f"{name} holds {seconds:.0f} s of driving above {SLOWEST:g} m/s with all signals; identification of a "
            f"vehicle needs {LEAST_DRIVEN:g} s, better ten minutes of town and country road"
        )
    return Drive(name, samples, angle, seconds)


def drives_of(recordings: Mapping[str, Recording]) -> list[Drive]:
    """All recordings as drives, in their order.

    Raises:
        InputError: as `drive_of`
    """
    return [drive_of(name, recording) for name, recording in recordings.items()]


def _driven(samples: np.ndarray) -> float:
    fast = np.nan_to_num(samples[:, 0]) > SLOWEST
    return float(np.count_nonzero(fast & np.isfinite(samples[:, 2]) & np.isfinite(samples[:, 3]))) / RATE


YAW_ALIKE, SPEED_ALIKE = 0.15, 0.02
"""Largest difference of two recordings of one drive [-]: of the yaw rates over their spread, of the speeds over their
mean, root mean squares. Rounding and resampling make a tenth of it; laps of one driver differ by 0.3 and 0.05."""
SHORTEST: Annotated[float, "s"] = 30.0  # Shortest common time of two recordings of one drive
SAME_ANGLE = 0.02  # Relative difference of two steering angles up to which they are one signal [-]
ELSEWHERE = 2.0
"""Factor by which the steering angle must be too large or too small to be one of another place [-]; ratios of a class
differ by a tenth, steering and road wheels by 12 and more."""
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
    """Refuse recordings of the same drive, whose evidence must count once, and angles of other places than stated.

    Args:
        vehicle: with wheelbase and steering ratio, from which an angle's size follows in slow turns

    Raises:
        InputError: two recordings hold the same drive, or a steering angle has a wrong sign or is measured at another
            place
    """
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
