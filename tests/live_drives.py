"""A drive as frames on a bus, and the database that describes them."""

from __future__ import annotations

import json
import queue
from pathlib import Path

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.live.clock import Frame
from tierod.live.drive import Drive
from tierod.live.events import Hub
from tierod.live.judge import Plan
from tierod.vehicles import load

CAR = load("midsize-eps")
START = 1_700_000_000.0
DBC = """VERSION ""
NS_ :
BS_:
BU_: ECU
BO_ 256 EPS: 8 ECU
 SG_ driver_torque : 0|16@1- (0.001,0) [-30|30] "N*m" ECU
 SG_ motor_torque : 16|16@1- (0.001,0) [-30|30] "N*m" ECU
 SG_ steering_wheel_angle : 39|16@0- (0.0005,0) [-15|15] "rad" ECU
 SG_ steering_wheel_rate : 48|16@1- (0.001,0) [-30|30] "rad/s" ECU

BO_ 512 ESP: 8 ECU
 SG_ yaw_rate : 0|16@1- (0.0001,0) [-3|3] "rad/s" ECU
 SG_ lateral_acceleration : 16|16@1- (0.001,0) [-30|30] "m/s**2" ECU
 SG_ vehicle_speed : 32|16@1+ (0.01,0) [0|100] "m/s" ECU
 SG_ ignition : 48|1@1+ (1,0) [0|1] "" ECU

BO_ 768 Never: 8 ECU
 SG_ brake_pressure : 0|16@1+ (1,0) [0|100] "bar" ECU
"""


def database_file(folder: Path) -> Path:
    """The database as a file."""
    path = folder / "car.dbc"
    path.write_text(DBC)
    return path


def messages(folder: Path):
    """The messages of the database."""
    from tierod.io.readers.dbc import load_databases

    return load_databases([database_file(folder)])


def drive(seconds: float = 12.0) -> Recording:
    """A weave at 20 m/s; the two messages come at 100 Hz with stamps of their own."""
    chance = np.random.default_rng(3)
    made = {}
    for shift, names in (
        (0.0021, ("driver_torque", "motor_torque", "steering_wheel_angle", "steering_wheel_rate")),
        (0.0067, ("yaw_rate", "lateral_acceleration", "vehicle_speed")),
    ):
        time = shift + np.arange(int(100 * seconds)) / 100.0 + chance.uniform(0.0, 4e-4, int(100 * seconds))
        sine, cosine = np.sin(1.5 * time), np.cos(1.5 * time)
        values = {
            "driver_torque": 2.5 * sine + 0.4 * np.sign(cosine),
            "motor_torque": 1.5 * sine,
            "steering_wheel_angle": 0.4 * sine,
            "steering_wheel_rate": 0.6 * cosine,
            "yaw_rate": 0.12 * sine,
            "lateral_acceleration": 2.4 * sine,
            "vehicle_speed": 20.0 + 0.2 * cosine,
        }
        units = {"driver_torque": "N*m", "motor_torque": "N*m", "steering_wheel_angle": "rad"}
        units |= {"steering_wheel_rate": "rad/s", "yaw_rate": "rad/s", "lateral_acceleration": "m/s**2"}
        for name in names:
            noise = 0.01 * chance.standard_normal(len(time))
            made[name] = Channel(name, time, values[name] + noise, units.get(name, "m/s"))
    return Recording(made, {"origin": START})


def frames_of_drive(folder: Path, seconds: float = 12.0) -> list[Frame]:
    """The frames of that drive, by the calendar."""
    from tierod.io.writers import write
    from tierod.live.encoding import encoded

    write(drive(seconds), folder / "drive.parquet")
    found = encoded(folder / "drive.parquet", messages(folder), None)
    return [frame._replace(time=START + 0.25 + frame.time) for frame in found]


def started(folder, outputs, memory=None, car=None, monitors=("friction",)):
    """A drive over that database with some monitors, its inbox, and the events that it says."""
    events = []
    hub = Hub()
    hub.add(lambda text: events.append(json.loads(text)))
    inbox = queue.SimpleQueue()
    plan = Plan(car or CAR, memory)
    return Drive([], inbox, messages(folder), None, list(monitors), plan, outputs, hub), inbox, events


def driven(drive, inbox, frames):
    """Let a drive take frames by the clock of their stamps."""
    for begin in range(0, len(frames), 40):
        for frame in frames[begin : begin + 40]:
            inbox.put(frame)
        drive.tick(frames[begin].time, frames[begin].time)
