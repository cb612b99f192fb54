"""Recordings of two real cars, with those of the demonstrator's sensors that they have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.real_data import recorded

RATE = 100.0  # Sampling rate of the grid [Hz]

SENSORS = ("wheel_speed_rear_left", "wheel_speed_rear_right", "yaw_rate", "steering_wheel_angle")
"""Judged sensors that production cars have."""

_LATERAL = "lateral_acceleration"
_ALONG = "longitudinal_acceleration"
_SMOOTHING = 0.2  # Window of the moving average of the front wheel speed before it is differentiated [s]


@dataclass(frozen=True)
class RealCar:
    """A recording of a real car."""

    name: str  # name of the car for tables
    file: tuple[str, str]  # folder and file name of the recording
    vehicle: str  # name of its vehicle file
    dbc: str | None  # bus database, if the recording needs one
    # duration of the first part, on which constants and accuracies are determined; the rest is judged
    learning: Annotated[float, "s"]
    starts: tuple[float, ...]  # beginnings of the injected faults on the clock of the recording [s]
    lasting: Annotated[float, "s"]  # duration of each fault

    @property
    def known(self) -> Vehicle:
        """Vehicle file of the car."""
        return load(self.vehicle)

    def recording(self) -> Recording | None:
        """The original recording; None where it or the library of its reader is missing."""
        return recorded(*self.file, dbc=self.dbc, channel_map=self.known.channel_map)


def on_grid(made: Recording) -> Recording:
    """All signals that the rules need, on one time grid.

    A missing longitudinal acceleration is derived from the front wheel speeds, which the rules do not use.
    """
    wanted = (*SENSORS, _LATERAL, *([_ALONG] if _ALONG in made else []))
    first = max(made[name].time[0] for name in wanted)
    last = min(made[name].time[-1] for name in wanted)
    time = np.arange(np.ceil(first * RATE), np.floor(last * RATE)) / RATE
    values = {name: np.interp(time, made[name].time, made[name].values) for name in wanted}
    if _ALONG not in values:
        values[_ALONG] = _from_front_wheels(made, time)
    units: Mapping[str, str] = {name: made[name].unit for name in wanted} | {_ALONG: "m/s**2"}
    return Recording({name: Channel(name, time, each, units[name]) for name, each in values.items()})


def _from_front_wheels(made: Recording, time: np.ndarray) -> np.ndarray:
    """Longitudinal acceleration from the front wheel speeds [m/s**2]."""
    names = ("wheel_speed_front_left", "wheel_speed_front_right")
    speed = sum(np.interp(time, made[name].time, made[name].values) for name in names) / 2.0
    count = round(_SMOOTHING * RATE)
    # `convolve` pads with zeros, which would look like hard braking at both ends.
    padded = np.pad(speed, count, mode="edge")
    smooth = np.convolve(padded, np.ones(count) / count, "same")[count:-count]
    return np.gradient(smooth, 1.0 / RATE)


CARS = (
    RealCar("RAV4", ("rav4_highway_minute", "can.log"), "rav4", "rav4", 30.0, (33.0, 42.0, 51.0), 6.0),
    RealCar("passenger car", ("revsted_slip_angle", "obd.csv"), "revsted-car", None, 9.0, (10.0, 13.5, 17.0), 2.0),
)
"""The recordings: a minute of highway at 8 to 20 m/s, and 20 s of tight bends at 3 to 10 m/s."""
