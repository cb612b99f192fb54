"""Recordings of two real cars, with their sensors, as far as they have those of the demonstrator."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tierod.core.errors import MissingExtra
from tierod.core.recording import Channel, Recording
from tierod.vehicles import Vehicle, load

DATA = "TIEROD_DATA"
"""Environment variable that names the folder of the real recordings; without it ../shared/data is looked into."""

RATE = 100.0
"""Of the grid [Hz]."""

SENSORS = ("wheel_speed_rear_left", "wheel_speed_rear_right", "yaw_rate", "steering_wheel_angle")
"""The judged sensors that production cars have."""

_LATERAL = "lateral_acceleration"
_ALONG = "longitudinal_acceleration"
_SMOOTHING = 0.2
"""Over this time the speed of the front wheels is smoothed where it gives the longitudinal acceleration [s]."""


@dataclass(frozen=True)
class RealCar:
    """A recording of a real car.

    Args:
        name: as people call it
        file: folder and name of the recording
        vehicle: its vehicle file
        dbc: database of its bus, if it needs one
        learning: so long from the beginning constants are chosen and accuracies are measured; what is later is judged
        starts: of the injected faults, on the clock of the recording
        lasting: how long each lasts
    """

    name: str
    file: tuple[str, str]
    vehicle: str
    dbc: str | None
    learning: Annotated[float, "s"]
    starts: tuple[float, ...]
    lasting: Annotated[float, "s"]

    @property
    def known(self) -> Vehicle:
        """Vehicle that the file of the car holds."""
        return load(self.vehicle)

    def recording(self) -> Recording | None:
        """The recording as it was made; None where it is absent or cannot be read with what is installed."""
        from tierod.io.derive import complete
        from tierod.io.readers import read

        path = Path(os.environ.get(DATA, "../shared/data")).joinpath(*self.file)
        if not path.exists():
            return None
        try:
            return complete(read(path, dbc=self.dbc, channel_map=self.known.channel_map))
        except MissingExtra:
            return None


def on_grid(made: Recording) -> Recording:
    """All signals that rules need at the same times, front wheels left aside; the acceleration from those if missing.

    Args:
        made: a recording of a real car
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
    """Longitudinal acceleration of the front wheels, which are not judged [m/s**2]."""
    names = ("wheel_speed_front_left", "wheel_speed_front_right")
    speed = sum(np.interp(time, made[name].time, made[name].values) for name in names) / 2.0
    count = round(_SMOOTHING * RATE)
    padded = np.pad(speed, count, mode="edge")
    smooth = np.convolve(padded, np.ones(count) / count, "same")[count:-count]
    return np.gradient(smooth, 1.0 / RATE)


CARS = (
    RealCar("RAV4", ("rav4_highway_minute", "can.log"), "rav4", "rav4", 30.0, (33.0, 42.0, 51.0), 6.0),
    RealCar("passenger car", ("revsted_slip_angle", "obd.csv"), "revsted-car", None, 9.0, (10.0, 13.5, 17.0), 2.0),
)
"""A minute of highway at 8 to 20 m/s, and 20 s of tight bends at 3 to 10 m/s."""
