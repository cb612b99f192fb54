"""Ordinary drives for the identification of a vehicle: required signals, resampled to one grid."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.io.derive import complete, ingredients
from tierod.methods.identification.drive_likelihood import SLOWEST

RATE = 50.0
"""Sample rate [Hz]; yaw and roll of a car are below 5 Hz."""
HELD = 0.2
"""Longest gap of a speed or an angle that is bridged [s]."""
LEAST_DRIVEN = 30.0
"""Smallest time of a drive above the slowest speed [s]."""

SPEED, ALONG, LATERAL, YAW = "vehicle_speed", "longitudinal_acceleration", "lateral_acceleration", "yaw_rate"
ANGLES = ("road_wheel_angle", "steering_wheel_angle")
"""Candidates for the steering angle; the first one that a recording contains is used."""
SIGNALS = ingredients((SPEED, ALONG, *ANGLES, YAW, LATERAL))


class Drive(NamedTuple):
    """One drive, resampled for identification.

    Args:
        samples: of `DriveSample`, (n, 5); inputs of the model are means since the sample before
        angle: name of the signal of the steering angle
        driven: time above the slowest speed with all signals [s]
    """

    name: str
    samples: np.ndarray
    angle: str
    driven: float


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
