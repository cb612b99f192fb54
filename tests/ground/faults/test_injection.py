"""Faults put into recordings: the same as in a run, on the recording's clock, of its signals alone."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.recording import Channel, Recording
from tierod_lab.ground.cars.demonstrator_car import DemonstratorCar
from tierod_lab.ground.courses.catalogue import load
from tierod_lab.ground.faults import Delay, Drift, Fault, Noise, Offset, Outlier, Stuck, TotalLoss, injected
from tierod_lab.ground.faults.fault import AtTime, When
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet


@pytest.mark.parametrize("behaviour", [TotalLoss(), Stuck(), Offset("5 deg/s"), Drift(0.1), Noise(0.2), Delay(0.1)])
def test_a_recording_with_an_injected_fault_is_that_of_a_run_with_the_fault(behaviour):
    car, course, sensors = DemonstratorCar(), load("short-round"), SensorSet.production()
    fault = Fault("sensor.yaw_rate", behaviour, AtTime(1.5), 1.0)
    healthy = run(car, course, 3.0, 5, sensors).recording
    faulty = run(car, course, 3.0, 5, sensors, [fault]).recording
    made = injected(healthy, [fault], sensors, 5)
    for name in healthy.names:
        np.testing.assert_array_equal(made[name].values, faulty[name].values)
    assert np.any(made["yaw_rate"].values != healthy["yaw_rate"].values)


def _recording() -> Recording:
    time = 100.0 + np.arange(500) / 50.0
    return Recording(
        {
            "yaw_rate": Channel("yaw_rate", time, np.sin(time), "rad/s"),
            "Brake_Light": Channel("Brake_Light", time, 0.0 * time, ""),
        }
    )


def test_times_are_those_of_the_recording_and_an_outlier_lasts_a_second():
    before = _recording()
    after = injected(before, [Fault("yaw_rate", Outlier(3.0), AtTime(104.0))])
    time, factor = before["yaw_rate"].time, after["yaw_rate"].values / before["yaw_rate"].values
    np.testing.assert_allclose(factor, np.where((time >= 104.0) & (time < 105.0), 3.0, 1.0))


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (Fault("steering_wheel_angle", Offset(0.1)), "steering_wheel_angle"),
        (Fault("Brake_Light", Offset(0.1)), "Brake_Light"),
        (Fault("yaw_rate", Offset(0.1), AtTime(200.0)), "begin earlier"),
    ],
)
def test_what_is_not_recorded_cannot_fail(fault, said):
    with pytest.raises(ParameterError, match=said):
        injected(_recording(), [fault])


def test_a_condition_is_not_waited_for():
    fault = Fault("yaw_rate", Offset(0.1), When("yaw_rate > 0.5 rad/s"))
    with pytest.raises(ParameterError, match="does not wait"):
        injected(_recording(), [fault])
