"""Parameters matched on slow circles, against those that the car was given."""

from __future__ import annotations

import numpy as np
import pytest

from tierod_lab.papers.sideslip.estimators import INVERSION, MODEL, NAMES, courses, error
from tierod_lab.papers.sideslip.matching import from_file, matched_to
from tierod_lab.papers.sideslip.setting import FAST, brush_car, driven, neutral, virtual_car


@pytest.fixture(scope="module")
def small():
    return matched_to(brush_car(), 25.0, 0.8)


def test_small_circles_find_the_stiffnesses_of_brush_tyres(small):
    assert small.front_cornering_stiffness == pytest.approx(100e3, rel=0.08)
    assert small.rear_cornering_stiffness == pytest.approx(140e3, rel=0.08)


def test_small_circles_find_the_trail(small):
    assert small.mechanical_trail + small.pneumatic_trail == pytest.approx(0.023 + 0.09 / 3.0, rel=0.12)


def test_a_neutral_car_is_matched_as_neutral():
    p = matched_to(neutral(brush_car()), 25.0, 0.8)
    ratio = p.rear_cornering_stiffness * p.rear_distance / (p.front_cornering_stiffness * p.front_distance)
    assert ratio == pytest.approx(1.0, abs=0.06)


def test_the_rest_comes_from_the_vehicle_file(small):
    assert small.mass == from_file().mass
    assert small.road_wheel_friction == from_file().road_wheel_friction


def test_every_estimator_follows_a_drive_and_feedback_helps_the_torque():
    p = matched_to(virtual_car(), FAST.speed, FAST.steer)
    drive = driven(virtual_car(), FAST.course(), 3)
    errors = {name: error(course, drive) for name, course in courses(p, drive).items()}
    assert tuple(errors) == NAMES
    assert errors["two-stage, Kalman"] < errors[MODEL] < errors[INVERSION]
    assert errors["conventional, Kalman"] < 0.09
    assert np.degrees(drive.truths["sideslip_angle"][drive.judged].std()) > 0.5
