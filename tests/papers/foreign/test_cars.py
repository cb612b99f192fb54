import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.condition import real_cars
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


def test_every_sensor_has_six_faults_and_the_worst_kind_comes_first(monkeypatch):
    assert len(cars.faults_of("yaw_rate", 33.0, 6.0)) == 6

    class Isolated:
        right, ambiguous = 0.5, 0.0

    class Known:
        delays_shown, not_testable, wrong = (), 0, 0.0

        def __init__(self, found):
            self.missed = sum(found)

    class Score:
        def __init__(self, kind):
            self.drive = type("Drive", (), {"injected": [type("Fault", (), {"kind": kind})]})

        def __radd__(self, other):
            return other + (self.drive.injected[0].kind == "drift")

    monkeypatch.setattr(cars, "summary", Known)
    monkeypatch.setattr(cars, "isolated", lambda found: Isolated)
    monkeypatch.setattr(cars.tables, "named", lambda title, found: Table(title, ("a",), (("b",),)))
    quiet = type("Quiet", (), {"false_alarms": 0})
    items = list(cars.shown(real_cars.Judged(quiet, [Score("loss"), Score("drift")], [], [])))
    table = next(each for each in items if isinstance(each, Table))
    assert [row[0] for row in table.rows] == ["drift", "loss"]
    claims = {each.id: each for each in items if isinstance(each, Claim)}
    assert claims["cars.multibody-missed"].measured == 1.0
    assert claims["cars.multibody-named"].met is False
    assert claims["cars.multibody-alarms"].met
