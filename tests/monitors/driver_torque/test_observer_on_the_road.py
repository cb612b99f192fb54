"""The observer on the virtual EPS car: two inertias, a road that turns the pinion, angles without a set zero."""

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import rms
from tierod.core.graph import scan
from tierod.monitors.driver_torque.block import ColumnSigns, wrong_signs
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod.vehicles import load
from tierod_lab.ground import SensorSet, run
from tierod_lab.ground.cars import catalogue as cars
from tierod_lab.ground.courses import catalogue as courses
from tierod_lab.papers.column.swept_bench import NOISE

CHANNELS = ("motor_torque", "steering_wheel_angle", "motor_angle_mechanical", "driver_torque")


@pytest.fixture(scope="module")
def drive():
    """What is measured at 1 kHz with noise and an offset of the motor's angle, and the true torque of the hands."""
    sensors = SensorSet.ideal(1000.0).only(CHANNELS)
    recording = run(cars.load("midsize-eps").block, courses.load("mixed"), 60.0, 3, sensors).recording
    time = recording["steering_wheel_angle"].time
    random = np.random.default_rng(1)
    columns = [recording[name].values + random.normal(0.0, NOISE.get(name, 1e-9), len(time)) for name in CHANNELS]
    columns[2] = columns[2] + np.radians(5.0)
    truth = recording["truth_hand_torque"]
    return np.column_stack(columns), np.interp(time, truth.time, truth.values)


def test_it_estimates_the_hands_better_than_the_bar(drive):
    measured, hands = drive
    found = scan(ColumnObserver.of_vehicle(load("midsize-eps")), measured)
    used = np.arange(len(hands)) > 5_000
    bar = rms((measured[:, 3] - hands)[used])
    assert rms((found["hand_torque"] - hands)[used]) < 0.3 * bar
    assert rms((found["hand_torque"] - hands)[used]) < 0.037
    assert found["offset"][-1] == pytest.approx(np.radians(5.0), rel=0.1)
    assert found["nis"][used].mean() == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize("wrong", [None, 0, 1, 2, 3])
def test_signs_are_reported_on_the_road(drive, wrong):
    measured = drive[0].copy()
    if wrong is not None:
        measured[:, wrong] *= -1.0
    verdict = scan(ColumnSigns(20.0), measured).at(-1)
    expected = [] if wrong is None else [CHANNELS[wrong]]
    assert [sentence.split()[0] for sentence in wrong_signs(verdict)] == expected
