"""Recordings whose findings are kept: simulated, real, tables, damaged and short ones."""

from __future__ import annotations

import csv
import dataclasses
import functools
import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from attack.semantic_drives import DRIVES
from shared_data import shared_data
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write
from tierod_lab.ground.scenarios import load as load_scenario

SEED = 5


class Kept(NamedTuple):
    """A recording and how it is judged.

    Args:
        vehicle: shipped vehicle, or a class and values for `tierod new`
        make: writes the recording into a folder and gives its path; skips where it is not to be had
        arguments: further arguments of `tierod diagnose`
    """

    vehicle: str
    make: Callable[[Path], Path]
    arguments: tuple[str, ...] = ("--monitor", "all")


def measured(recording: Recording) -> Recording:
    """The recording without truth."""
    return Recording({name: each for name, each in recording.channels.items() if not name.startswith("truth_")})


def _written(make: Callable[[], Recording]) -> Callable[[Path], Path]:
    def written(folder: Path) -> Path:
        path = folder / "drive.parquet"
        write(measured(make()), path)
        return path

    return written


def _scenario(name: str, seconds: float) -> Callable[[], Recording]:
    return lambda: load_scenario(name).with_run(seconds, SEED).run().recording


def _changed(seconds: float, name: str, change: Callable[[Channel], Channel]) -> Callable[[], Recording]:
    """A drive through town with one changed signal."""

    def make() -> Recording:
        drive = measured(_scenario("mixed-drive-healthy", seconds)())
        return drive.with_channels([change(drive[name])])

    return make


def _stuck(channel: Channel) -> Channel:
    late = channel.time > 40.0
    return dataclasses.replace(channel, values=np.where(late, channel.values[late][0], channel.values))


def _lost(channel: Channel) -> Channel:
    gone = (channel.time > 40.0) & (channel.time < 50.0)
    return dataclasses.replace(channel, values=np.where(gone, math.nan, channel.values))


def _table(folder: Path) -> Path:
    """A table at one rate in degrees and kilometres per hour, without torques and wheel speeds."""
    drive = measured(_scenario("mixed-drive-healthy", 90.0)())
    time = np.arange(0.0, 90.0, 0.02)
    columns = {
        "time [s]": time,
        "steering_wheel_angle [deg]": np.degrees(_at(drive, "steering_wheel_angle", time)),
        "yaw_rate [deg/s]": np.degrees(_at(drive, "yaw_rate", time)),
        "lateral_acceleration [m/s2]": _at(drive, "lateral_acceleration", time),
        "vehicle_speed [km/h]": 3.6 * _at(drive, "vehicle_speed", time),
    }
    path = folder / "logger.csv"
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(columns)
        table.writerows([f"{value:.6g}" for value in row] for row in zip(*columns.values(), strict=True))
    return path


def _at(recording: Recording, name: str, time: np.ndarray) -> np.ndarray:
    return np.interp(time, recording[name].time, recording[name].values)


def _real(*parts: str) -> Callable[[Path], Path]:
    return lambda folder: shared_data(*parts)


def _drives() -> dict[str, Kept]:
    """Drives of the semantic attack, by the monitor that they were made for."""
    kept = {}
    for each in DRIVES:
        chosen = ("--monitor", each.monitor, *(("--variant", each.variant) if each.variant else ()))
        make = _written(functools.partial(each.make, SEED))
        kept[f"{each.monitor}-{each.name}"] = Kept(each.vehicle, make, chosen)
    return kept


KEPT: dict[str, Kept] = {
    **_drives(),
    "friction-ramp": Kept("midsize-eps", _written(_scenario("country-drive-friction-ramp", 300.0))),
    "friction-step": Kept("midsize-eps", _written(_scenario("mixed-drive-friction-step", 600.0))),
    "hot-motor": Kept("midsize-eps", _written(_scenario("hot-motor-in-town", 60.0))),
    "lock-to-lock-ground": Kept("midsize-eps", _written(_scenario("lock-to-lock-on-ground", 60.0))),
    "parking": Kept("large mass=1980 wheelbase=3.0", _written(_scenario("parking-large-car", 55.0))),
    "rack-with-lash": Kept("midsize-eps", _written(_scenario("rack-with-lash", 120.0))),
    "slalom": Kept("midsize-eps", _written(_scenario("slalom-winter-tyres", 30.0))),
    "split-adhesion": Kept("midsize-eps", _written(_scenario("split-adhesion-in-crosswind", 20.0))),
    "steady-circle": Kept("midsize-eps", _written(_scenario("steady-circle", 60.0))),
    "lane-change": Kept("steer-by-wire", _written(_scenario("steer-by-wire-lane-change", 10.0))),
    "step-steer": Kept("midsize-eps", _written(_scenario("step-steer", 6.0))),
    "weave": Kept("small mass=1050 wheelbase=2.43", _written(_scenario("weave-small-car", 50.0))),
    "worn-sensors": Kept("midsize-eps", _written(_scenario("worn-sensors-in-town", 120.0))),
    "demonstrator-lap": Kept("smartload", _written(_scenario("demonstrator-lap", 60.0))),
    "active-front-steering": Kept("active-front-steering", _written(_scenario("active-front-steering-drive", 90.0))),
    "short": Kept("midsize-eps", _written(_scenario("mixed-drive-healthy", 3.0))),
    "stuck-yaw-rate": Kept("midsize-eps", _written(_changed(90.0, "yaw_rate", _stuck))),
    "lost-steering-angle": Kept("midsize-eps", _written(_changed(90.0, "steering_wheel_angle", _lost))),
    "stuck-driver-torque": Kept("midsize-eps", _written(_changed(90.0, "driver_torque", _stuck))),
    "foreign-units": Kept("midsize mass=1500 wheelbase=2.7", _table),
    "real-highway": Kept("rav4", _real("rav4_highway_minute", "can.log")),
    "real-race": Kept("ferrari-250lm", _real("ferrari_250lm_race", "laps.parquet")),
    "real-slip-angle": Kept("revsted-car", _real("revsted_slip_angle", "obd.csv")),
}
