import numpy as np
import pytest

from tierod_lab.papers.foreign import cars
from tierod_lab.papers.foreign.multibody_car import NOISES, STEERING_RATIO, MultibodyCar, multibody_drive


@pytest.fixture(scope="module")
def drive():
    pytest.importorskip("vehiclemodels")
    return multibody_drive(3, 12.0)


def test_the_car_turns_as_rolling_and_steering_say(drive):
    values = {name: drive[name].values[100:] for name in NOISES}
    track = MultibodyCar("car", ("", ""), "rav4", None, 30.0, (), 6.0).known["track_width"]
    apart = values["wheel_speed_rear_right"] - values["wheel_speed_rear_left"]
    slope = np.polyfit(values["yaw_rate"], apart, 1)[0]
    assert slope == pytest.approx(track, rel=0.1)
    speed = 0.5 * (values["wheel_speed_rear_right"] + values["wheel_speed_rear_left"])
    away = values["lateral_acceleration"] - speed * values["yaw_rate"]
    assert np.std(away) < 0.2 * np.std(values["lateral_acceleration"])
    assert np.corrcoef(values["steering_wheel_angle"], values["yaw_rate"])[0, 1] > 0.9


def test_its_vehicle_file_is_that_of_the_simulator():
    given = pytest.importorskip("vehiclemodels.parameters_vehicle2").parameters_vehicle2()
    known = MultibodyCar("car", ("", ""), "rav4", None, 30.0, (), 6.0).known
    assert known["mass"] == given.m
    assert known["front_distance"] + known["rear_distance"] == pytest.approx(given.a + given.b)
    assert known["steering_ratio"] == STEERING_RATIO


def test_every_sensor_has_six_faults():
    assert len(cars.faults_of("yaw_rate", 33.0, 6.0)) == 6
