"""Comparison of the virtual car's chassis with recordings of real cars: figures for tests and lists of claims."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.core.series import runs
from tierod.vehicles import load
from tierod_lab.ground.chassis import Axle, TwoTrack, Tyre
from tierod_lab.ground.parts import Wheels
from tierod_lab.ground.powertrain import Powertrain
from tierod_lab.papers.friction.plant_agreement import Agreement, agreement
from tierod_lab.papers.friction.plant_checks import STEP, courses
from tierod_lab.papers.friction.plant_replay import Replay

STEERING_ZERO = -0.0029
"""Steering offset of the race laps [rad], fitted with the cornering stiffnesses; it drifts by 1 mrad within minutes."""
LINEAR = 4.0  # Lateral acceleration up to which tyres and car are regarded as linear [m/s**2]
SETTLING = 0.5  # Time at the start of every part that is excluded from the comparison [s]


def _at(recording: Recording, names: tuple[str, ...], time: np.ndarray) -> list[np.ndarray]:
    return [np.interp(time, recording[name].time, recording[name].values) for name in names]


def rav4_agreement(recording: Recording) -> Agreement:
    """Compare the chassis, with the parameters of the RAV4's vehicle file, with the recorded yaw rate of one minute.

    The recording does not contain the offset of the gyroscope, so the mean difference is removed.

    Args:
        recording: the minute, with steering-wheel angle, speed, yaw rate and lateral acceleration
    """
    car = load("rav4")
    chassis = TwoTrack(
        mass=car["mass"],
        yaw_inertia=car["yaw_inertia"],
        front_distance=car["front_distance"],
        rear_distance=car["rear_distance"],
    ).with_axle_stiffness(car["front_cornering_stiffness"], car["rear_cornering_stiffness"])
    first, last = recording["steering_wheel_angle"].time[[0, -1]]
    time = np.arange(first + 0.1, last - 0.1, STEP)
    names = ("steering_wheel_angle", "vehicle_speed", "yaw_rate", "lateral_acceleration")
    angle, speed, yaw, lateral = _at(recording, names, time)
    out = scan(Replay(chassis, start_speed=float(speed[0])), courses(car["steering_ratio"] * angle, speed))
    ours = np.column_stack([out["yaw_rate"], out["lateral_acceleration"]])
    theirs = np.column_stack([yaw, lateral])
    return agreement(ours - np.mean(ours - theirs, axis=0), theirs)


def ferrari() -> TwoTrack:
    """The Ferrari 250 LM of the public race laps.

    Masses and distances are published with the laps; cornering stiffnesses are fitted to yaw rate and sideslip in the
    linear parts, up to 5 m/s**2, of their first half; all other parameters are assumed.
    """
    tyre = Tyre(nominal_load=2500.0, friction=1.3, load_sensitivity=-0.05, trail=0.02, lateral_relaxation=0.3)
    return TwoTrack(
        mass=982.0,
        yaw_inertia=1400.0,
        front_distance=1.33,
        rear_distance=1.07,
        centre_height=0.42,
        roll_inertia=250.0,
        front=Axle(1.35, 0.05, 60e3, 2500.0, 0.0, 1.0, tyre),
        rear=Axle(1.35, 0.10, 50e3, 2500.0, 0.0, 1.2, replace(tyre, cornering_stiffness=40.0)),
    ).with_axle_stiffness(83e3, 145e3)


def ferrari_agreement(recording: Recording, second_half: bool = True) -> Agreement:
    """Compare the chassis with the Ferrari's yaw rate and speed times yaw rate, in the linear parts of the race laps.

    Every part of 1.5 s or more is simulated separately from the recorded state of motion, since an open loop at the
    limit of adhesion does not stay where the driver kept the car.

    Args:
        recording: the laps, with road-wheel angle, speed, lateral speed and yaw rate
        second_half: whether to judge the half that was not used for fitting, or the other one
    """
    first, last = recording["vehicle_speed"].time[[0, -1]]
    time = np.arange(first, last, STEP)
    names = ("road_wheel_angle", "vehicle_speed", "lateral_speed", "yaw_rate")
    series = _at(recording, names, time)
    ours, theirs = [], []
    for start, stop in _linear_parts(time, series[1] * series[3]):
        if (start > len(time) / 2) == second_half:
            steer, speed, across, yaw = (values[start:stop] for values in series)
            out = _driven_from(ferrari(), steer - STEERING_ZERO, speed, float(across[0]), float(yaw[0]))
            judged = slice(round(SETTLING / STEP), None)
            ours.append(np.column_stack([out["yaw_rate"], out["speed"] * out["yaw_rate"]])[judged])
            theirs.append(np.column_stack([yaw, speed * yaw])[judged])
    return agreement(np.concatenate(ours), np.concatenate(theirs))


def _linear_parts(time: np.ndarray, lateral: np.ndarray) -> list[tuple[int, int]]:
    """Start and end index of every part; a glitch of the steering sensor at 207.27 s is excluded."""
    width = round(0.4 / STEP)
    smooth = np.convolve(lateral, np.ones(width) / width, "same")
    fit = (np.abs(smooth) < LINEAR) & (np.abs(time - 207.27) > 1.5)
    begins, ends = runs(fit)
    parts = zip(begins.tolist(), ends.tolist(), strict=True)
    return [(start, stop) for start, stop in parts if stop - start > round(1.5 / STEP)]


def _driven_from(chassis: TwoTrack, steer: np.ndarray, speed: np.ndarray, across: float, yaw: float) -> Any:
    replay = Replay(
        chassis, Powertrain(front_share=0.0, greatest_power=400e3, greatest_speed=100.0), start_speed=float(speed[0])
    )
    front_slip = float(steer[0]) - (across + chassis.front_distance * yaw) / float(speed[0])
    rear_slip = -(across - chassis.rear_distance * yaw) / float(speed[0])
    front = front_slip * chassis.front.tyre.lateral_relaxation
    rear = rear_slip * chassis.rear.tyre.lateral_relaxation
    begin = replay.init()._replace(lateral_speed=across, yaw_rate=yaw, lateral=Wheels(front, front, rear, rear))
    return scan(replay, courses(steer, speed), begin)
