"""Sideslip of a passenger car at 9 to 35 km/h, beside an optical sensor."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np

from tierod.monitors.sideslip.beside_truth import beside_truth
from tierod.recording import Recording
from tierod.studies.content import Item, Table
from tierod.studies.sideslip import rivals
from tierod.studies.sideslip.real_recordings import absent, claims, share_in_band
from tierod.vehicles import load

FILE, VEHICLE = ("revsted_slip_angle", "obd.csv"), "revsted-car"
FITTED = 5.0
"""Seconds that the steering ratio and the place of the sensor were fitted to; the rest is judged."""

RATE = 50.0
"""Of the recording [Hz]."""

COMBINED = "combined: gyroscope and steering"

GYROSCOPE_NOISE = math.radians(1.28) / math.sqrt(12.0)
"""Of the recorded yaw rate [rad/s]: what its step leaves open."""


def items(drive: Recording | None) -> Iterator[Item]:
    """The passenger car beside its optical sensor, 9 to 35 km/h."""
    if drive is None:
        yield from absent("passenger-car", ("mean", "rms"))
        return
    car, until = load(VEHICLE), float(drive["yaw_rate"].time[0]) + FITTED
    fused = with_rear_wheels(drive, until)
    compared = {
        "sideslip of zero": rivals.nothing(drive),
        "geometry, gyroscope": rivals.geometric(drive, until),
        "geometry, gyroscope and rear wheels": rivals.geometric(fused, until),
        COMBINED: beside_truth(drive, car, RATE),
        "combined: gyroscope, rear wheels and steering": beside_truth(fused, car, RATE),
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
        "says nothing of any estimator at speed. The optical sensor is 40 ms late and scatters by 0.1 degrees.",
    )
    note = "Last 15 s. Steering ratio and place of the optical sensor are from the first 5 s, all else is assumed."
    rest = compared[COMBINED].figures(until)
    yield from claims("passenger-car", "a passenger car with optical sensor", rest, (0.18, 0.22), note)


def with_rear_wheels(drive: Recording, until: float) -> Recording:
    """The drive with a yaw rate of the gyroscope and the rear wheels, each weighed by its variance.

    Args:
        drive: recording
        until: end of the part [s] that the track at which the wheels tell the yaw rate, and their noise, are from
    """
    gyroscope, *wheels = (drive[name] for name in ("yaw_rate", "wheel_speed_rear_right", "wheel_speed_rear_left"))
    right, left = (np.interp(gyroscope.time, each.time, each.values) for each in wheels)
    across, early = right - left, gyroscope.time < until
    track = float(across[early] @ gyroscope.values[early] / (gyroscope.values[early] @ gyroscope.values[early]))
    difference = float(np.var((across / track - gyroscope.values)[early]))
    noise = max(difference - GYROSCOPE_NOISE**2, GYROSCOPE_NOISE**2)
    weight = noise / (noise + GYROSCOPE_NOISE**2)
    both = weight * gyroscope.values + (1.0 - weight) * across / track
    return drive.with_channels([dataclasses.replace(gyroscope, values=both)])
