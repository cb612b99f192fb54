"""The ratio of the motor's torque by ordinary drives: found where assist shares the load, kept where it cannot be."""

import dataclasses

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod.monitors.own_car import MODEL_ERROR, DriveRatio, _judged, identify_own_car, ratio_of_drives
from tierod_lab.papers.own_car.cars import drawn
from tierod_lab.papers.own_car.judging import driven, without_truth

SEED = 77002


@pytest.fixture(scope="module")
def car():
    return drawn(1, SEED)


@pytest.fixture(scope="module")
def drive(car):
    return without_truth(driven(car, 7.0, SEED))


def test_a_drive_shows_the_ratio_whatever_the_file_says(car, drive):
    found = ratio_of_drives({"a": drive}, car.brochure)
    assert found.value == pytest.approx(car.true["motor_ratio"], rel=MODEL_ERROR)
    assert found.deviation >= MODEL_ERROR * found.value


def test_a_gain_of_the_motor_torque_moves_the_ratio_by_as_much(car, drive):
    motor = drive["motor_torque"]
    weaker = drive.with_channels([Channel("motor_torque", motor.time, 0.8 * motor.values, motor.unit)])
    found = [ratio_of_drives({"a": each}, car.brochure).value for each in (drive, weaker)]
    assert found[1] / found[0] == pytest.approx(1.25, rel=0.02)


def test_without_torques_or_with_too_little_driving_nothing_is_found(car, drive):
    bare = Recording({name: each for name, each in drive.channels.items() if name != "motor_torque"})
    assert ratio_of_drives({"a": bare}, car.brochure) is None
    assert ratio_of_drives({"a": drive.slice(stop=200.0)}, car.brochure) is None


@pytest.mark.slow
def test_it_goes_into_what_is_written_beside_the_motion(car, drive):
    found = identify_own_car({"a": drive}, car.brochure)
    assert not found.doubt
    (own,) = [each for each in found.found if each.name == "motor_ratio"]
    before = car.brochure.parameters["motor_ratio"]
    assert own.deviation < 0.75 * before.standard_deviation
    true = car.true["motor_ratio"]
    assert abs(own.value - true) <= max(abs(before.value - true), 0.05 * true)


def test_file_and_drives_are_weighed_and_contradictions_said(car):
    before = car.brochure.parameters["motor_ratio"]
    spread = before.standard_deviation
    both = _judged(car.brochure, DriveRatio(before.value + spread, 2.0 * spread, 0.02))
    assert both.kind == "not seen"
    both = _judged(car.brochure, DriveRatio(before.value + spread, 0.5 * spread, 0.02))
    assert both.value == pytest.approx(before.value + 0.8 * spread)
    assert both.deviation == pytest.approx(spread * np.sqrt(0.2))
    far = _judged(car.brochure, DriveRatio(before.value + 9.0 * spread, 0.5 * spread, 0.02))
    assert (far.kind, far.value) == ("not seen", before.value)
    assert "σ from the file" in far.text


def test_a_ratio_that_is_known_exactly_is_left_alone(car, drive, monkeypatch):
    monkeypatch.setattr("tierod.monitors.own_car.ratio_of_drives", lambda *given: pytest.fail("looked for it"))
    exact = dataclasses.replace(car.brochure.parameters["motor_ratio"], standard_deviation=0.0)
    known = dataclasses.replace(car.brochure, parameters={**car.brochure.parameters, "motor_ratio": exact})
    short = drive.slice(stop=45.0)
    assert all(each.name != "motor_ratio" for each in identify_own_car({"a": short}, known).judged)
