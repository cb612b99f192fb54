"""Cars whose assist is not that of the vehicle file: in steps of speed, or by the map of another car."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from tierod.core.findings import Finding
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab.ground import drive

RATIO, BAR = 20.0, 140.0
"""Motor turns per turn of the column, and stiffness of the torsion bar [N*m/rad], as in midsize-eps."""

STEPS = (((10.0, 16.0, 22.0), (3.0, 2.2, 1.3, 0.8)), ((13.0, 19.0), (3.2, 1.6, 0.7)), ((15.0,), (3.0, 1.2)))
"""Speeds at which the gain of the assist steps [m/s], and its value in each range of speed."""


def with_steps(recording: Recording, speeds: tuple[float, ...], gains: tuple[float, ...]) -> Recording:
    """The same motion by another assist: driver and motor together give the torque that they gave before."""
    time, driver = recording["driver_torque"].time, recording["driver_torque"].values
    whole = driver + RATIO * np.interp(time, recording["motor_torque"].time, recording["motor_torque"].values)
    speed = np.interp(time, recording["vehicle_speed"].time, recording["vehicle_speed"].values)
    # A ramp of 0.5 m/s in place of each step, as assist tables are interpolated.
    knots = [place for each in speeds for place in (each - 0.25, each + 0.25)]
    gain = np.interp(speed, knots, [value for pair in itertools.pairwise(gains) for value in pair])
    # Solves T + gain (T + 0.5 T |T|) = whole for the driver's torque T.
    linear, square = 1.0 + gain, 0.5 * gain
    own = np.sign(whole) * (np.sqrt(linear**2 + 4.0 * square * np.abs(whole)) - linear) / (2.0 * square)
    twist = (own - driver) / BAR
    return recording.with_channels(
        [
            dataclasses.replace(recording["driver_torque"], values=own),
            moved(recording, "motor_torque", time, (driver - own) / RATIO),
            moved(recording, "steering_wheel_angle", time, twist),
            moved(recording, "steering_wheel_rate", time, np.gradient(twist, time)),
        ]
    )


def moved(recording: Recording, name: str, time: np.ndarray, by: np.ndarray):
    channel = recording[name]
    return dataclasses.replace(channel, values=channel.values + np.interp(channel.time, time, by))


def judged(recording: Recording, vehicle="midsize-eps") -> Finding:
    return diagnose(recording, vehicle, "friction").findings[0]


@pytest.fixture(scope="module")
def fault_free() -> Recording:
    return drive(minutes=6.0, friction=4.0, seed=41)


@pytest.fixture(scope="module")
def worn() -> Recording:
    return drive(minutes=6.0, friction=12.5, seed=42)


@pytest.mark.parametrize("steps", STEPS)
def test_an_assist_in_steps_of_speed_is_no_defect_and_hides_no_fault(fault_free, worn, steps):
    found = judged(with_steps(fault_free, *steps))
    assert found.status is Status.HEALTHY
    assert judged(with_steps(worn, *steps)).status is Status.FAULT
    assert any(
        "depends on vehicle_speed otherwise than the assist map of the vehicle file" in each for each in found.warnings
    )


@pytest.mark.parametrize(("linear", "quadratic", "half"), [(0.3, 30.0, 8.0), (0.7, 3.4, 8.7), (8.7, 2.0, 8.1)])
def test_the_assist_map_of_another_car_accuses_no_torque(fault_free, linear, quadratic, half):
    values = {"assist_linear_gain": linear, "assist_quadratic_gain": quadratic, "assist_half_speed": half}
    car = load("midsize-eps")
    others = {name: dataclasses.replace(car.parameters[name], value=value) for name, value in values.items()}
    found = judged(fault_free, dataclasses.replace(car, parameters={**car.parameters, **others}))
    said = f"{found.headline} {found.cause}"
    assert "times the right gain" not in said
    if found.status is not Status.HEALTHY:
        assert "the assist map of the vehicle file contradict each other" in said
