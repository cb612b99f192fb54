"""Limits of a car that is judged by its motion: from wheel speeds, yaw rate and steering angle alone."""

import numpy as np
import pytest

from tierod.cli import main
from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.calibration import _no_wider, calibrate_motion
from tierod.monitors.condition.definition import CONDITION, condition_monitor, rolling_limits
from tierod.monitors.condition.limits import limits_of
from tierod.monitors.condition.signals import OF_CARS, hypotheses_of_cars
from tierod.report.identification import identify
from tierod.vehicles import load
from tierod_lab.papers.own_car.cars import drawn
from tierod_lab.papers.own_car.judging import driven

FRONT = "wheel_speed_front_left"
COUNT = len(hypotheses_of_cars()) - 1


@pytest.fixture(scope="module")
def car():
    return drawn(0, 88002)


@pytest.fixture(scope="module")
def drive(car):
    whole = driven(car, 4.0, 88002)
    return Recording({name: whole[name] for name in OF_CARS})


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr("tierod.monitors.condition.limits.LEAST_HOURS", 0.04)


def test_limits_are_found_written_and_read_by_the_monitor(car, drive, tmp_path):
    path = tmp_path / "mine.toml"
    values = [f"{name}={car.brochure[name]:g}" for name in ("mass", "wheelbase")]
    assert main(["new", str(path), "--class", "midsize", *values]) == 0
    begun = load(path)
    assert condition_monitor(begun).judge.decision.weighing.limits == rolling_limits()
    found = identify("thresholds", {"a": drive}, begun)
    assert not found.doubt
    found.write_vehicle(path)
    kept = load(path)
    own = limits_of(kept, hypotheses_of_cars())
    assert own.fast == pytest.approx(found.result.designed.limits.fast, rel=1e-4)
    assert condition_monitor(kept).judge.decision.weighing.limits == own
    assert own != rolling_limits()
    notes = CONDITION.variants["bank"].open(kept, 100.0, None)._car.notes
    assert "its own drives" in notes[0]


def test_no_limit_is_wider_than_those_of_any_car_unless_its_own_driving_comes_near():
    usual = rolling_limits()
    wide = usual.__class__((25.0,) * COUNT, (25.0,) * COUNT, usual.gap, usual.margin)
    quiet = np.full((4, 2 * COUNT), -1.0)
    limits, lowered = _no_wider(wide, quiet)
    assert (limits.fast, limits.slow, lowered) == (usual.fast, usual.slow, 2 * COUNT)
    rough = quiet.copy()
    rough[2, 0] = 20.0
    limits, lowered = _no_wider(wide, rough)
    assert (limits.fast[0], lowered) == (25.0, 2 * COUNT - 1)


@pytest.mark.parametrize("name", [FRONT, "yaw_rate"])
def test_a_drive_with_a_fault_is_named_and_nothing_may_be_used(car, drive, name):
    given = drive[name]
    wrong = (given.time > 100.0) & (given.time < 110.0)
    values = np.where(wrong, given.values + (2.0 if name == FRONT else 0.3), given.values)
    bad = drive.with_channels([Channel(name, given.time, values, given.unit)])
    assert f"b: {name}" in calibrate_motion({"a": drive.slice(stop=90.0), "b": bad}, car.brochure).doubt


def test_too_few_sensors_and_too_little_driving_are_refused(car, drive, monkeypatch):
    few = Recording({name: drive[name] for name in OF_CARS if not name.startswith("wheel_speed_rear")})
    few = few.slice(stop=100.0)
    assert len(few.names) == 4
    with pytest.raises(InputError, match="rear"):
        calibrate_motion({"a": few}, car.brochure)
    fewer = Recording({name: drive[name] for name in ("yaw_rate", FRONT, "wheel_speed_rear_left")})
    with pytest.raises(InputError, match="3 of the sensors.*it lacks.*steering_wheel_angle"):
        calibrate_motion({"a": fewer}, car.brochure)
    with pytest.raises(InputError, match="better an hour"):
        calibrate_motion({"a": drive.slice(stop=60.0)}, car.brochure)
