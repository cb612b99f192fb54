"""Sideslip of a passenger car at 9 to 35 km/h, compared with an optical sensor."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim
from tierod.core.content import Item, Table
from tierod.core.recording import Recording
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.sideslip import race_laps, rivals
from tierod_lab.papers.sideslip.calibration import beside_truth, with_parameters
from tierod_lab.papers.sideslip.real_recordings import GOAL, absent, claims, share_in_band

FILE, VEHICLE = ("revsted_slip_angle", "obd.csv"), "revsted-car"
FITTED = 5.0
"""Duration of the first part [s], to which steering ratio and sensor position are fitted; the rest is judged."""

RATE = 50.0
"""Sampling rate [Hz]."""

COMBINED = "combined: gyroscope and steering"

NOISES = (
    "yaw_rate_noise",
    "yaw_rate_drift",
    "lateral_acceleration_noise",
    "lateral_acceleration_wander",
    "lateral_acceleration_wander_time",
    "lateral_speed_drift",
)
"""Noise parameters that are taken from the vehicle file of the race car."""

TRIED = ("yaw_rate_drift", "lateral_acceleration_noise", "lateral_speed_drift", "road_wheel_angle_wander")
"""Noise parameters that are tried at half, once and twice their value."""

GYROSCOPE_NOISE = math.radians(1.28) / math.sqrt(12.0)
"""Standard deviation of the recorded yaw rate [rad/s]: quantisation in steps of 1.28 deg/s."""


def items(drive: Recording | None) -> Iterator[Item]:
    if drive is None:
        yield from absent("passenger-car", ("mean", "rms"))
        return
    car, until = load(VEHICLE), float(drive["yaw_rate"].time[0]) + FITTED
    fused, tried = with_rear_wheels(drive, until), settings(car)
    early = [beside_truth(drive, each, RATE).figures(stop=until).rms for each in tried]
    chosen = tried[int(np.argmin(early))]
    compared = {
        "sideslip of zero": rivals.nothing(drive),
        "geometry, gyroscope": rivals.geometric(drive, until),
        "geometry, gyroscope and rear wheels": rivals.geometric(fused, until),
        COMBINED: beside_truth(drive, chosen, RATE),
        "combined: gyroscope, rear wheels and steering": beside_truth(fused, chosen, RATE),
        "combined, noises of the race car as they are": beside_truth(drive, another(car), RATE),
        "combined, noises of this car's file": beside_truth(drive, car, RATE),
    }
    rows = [
        (name, str(each.figures(stop=until)), str(each.figures(until)), share_in_band(each, until))
        for name, each in compared.items()
    ]
    yield Table(
        "Passenger car below 37 km/h: mean absolute / root mean square error of the sideslip (degrees)",
        ("estimator", "first 5 s, fitted", "the other 15 s", "in the 95 % band"),
        tuple(rows),
        "At this speed sideslip is geometry: the rear distance times the curvature of the path, whatever the tyres. "
        "The combined estimator can gain nothing over it, nor the rear wheels over the gyroscope, and the recording "
        "says nothing of any estimator at speed. The optical sensor is 40 ms late and scatters by 0.1 degrees. The "
        "noises of this car's own file were chosen with the whole recording in view.",
    )
    note = (
        "Last 15 s. Steering ratio, its zero and place of the optical sensor are from the first 5 s; the noises are "
        f"those of the race car, of {len(tried)} settings about them the best on the first 5 s."
    )
    rest = compared[COMBINED].figures(until)
    yield from claims("passenger-car", "a passenger car with optical sensor", rest, (0.18, 0.22), note)
    yield _any_noises(drive, (*tried, *_scaled(car)), until)


def _any_noises(drive: Recording, cars: tuple[Vehicle, ...], until: float) -> Claim:
    found = [math.degrees(beside_truth(drive, each, RATE).figures(until).rms) for each in cars]
    return Claim(
        "cars.passenger-car-any-noises",
        "Root mean square error on the passenger car with the worst of many settings of the noises.",
        GOAL,
        None,
        max(found),
        None,
        "deg",
        f"Of {len(found)} settings about the noises of the race car and of the car's own file; the best has "
        f"{min(found):.3f}.",
    )


def another(car: Vehicle) -> Vehicle:
    """The vehicle file with the noises of the race car, which were not tuned on this recording."""
    other = load(race_laps.VEHICLE)
    return with_parameters(car, {name: other[name] for name in NOISES}, f"of {race_laps.VEHICLE}")


def settings(car: Vehicle) -> tuple[Vehicle, ...]:
    """The vehicle file with all combinations of scaled noises of the race car."""
    return _scaled(another(car))


def _scaled(car: Vehicle) -> tuple[Vehicle, ...]:
    made = []
    for factors in itertools.product((0.5, 1.0, 2.0), repeat=len(TRIED)):
        values = {name: factor * car[name] for name, factor in zip(TRIED, factors, strict=True)}
        made.append(with_parameters(car, values, "tried"))
    return tuple(made)


def with_rear_wheels(drive: Recording, until: float) -> Recording:
    """The drive with a yaw rate fused from gyroscope and rear wheel speeds, weighted by their inverse variances.

    Args:
        drive: recording
        until: end of the part [s] from which effective track width and noise of the rear wheels are estimated
    """
    gyroscope, *wheels = (drive[name] for name in ("yaw_rate", "wheel_speed_rear_right", "wheel_speed_rear_left"))
    right, left = (np.interp(gyroscope.time, each.time, each.values) for each in wheels)
    across, early = right - left, gyroscope.time < until
    track = float(across[early] @ gyroscope.values[early] / (gyroscope.values[early] @ gyroscope.values[early]))
    difference = float(np.var((across / track - gyroscope.values)[early]))
    # The variances of independent noises add up. The bound gives the gyroscope at least half the weight, also where the
    # difference is too small by chance.
    noise = max(difference - GYROSCOPE_NOISE**2, GYROSCOPE_NOISE**2)
    weight = noise / (noise + GYROSCOPE_NOISE**2)
    both = weight * gyroscope.values + (1.0 - weight) * across / track
    return drive.with_channels([dataclasses.replace(gyroscope, values=both)])
