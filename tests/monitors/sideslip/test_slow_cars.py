"""Small slow cars: tight turns at walking pace, creeping, backing out; the headline says what the band proves."""

import dataclasses
import math

import numpy as np
import pytest

from monitors.condition.small_car import EVERY, QUADRICYCLE, STEP, backs_out, driven, recordings
from said import said
from tierod.core.findings import Status
from tierod.monitors.diagnose import diagnose
from tierod_lab.papers.own_car.brochure import brochure_car

BAND = 1.96
SEED = 14
"""Noises and offsets of the sensors; the zero of the steering angle is small, so that it is not the subject."""


@pytest.fixture(scope="module")
def car():
    """Vehicle file with distances and steering ratio as measured, and the usual tyres of the class."""
    vehicle = brochure_car("small", "quadricycle", QUADRICYCLE.mass, QUADRICYCLE.front + QUADRICYCLE.rear)
    known = {"steering_ratio": QUADRICYCLE.ratio, "track_width": QUADRICYCLE.track}
    known |= {"rear_distance": QUADRICYCLE.rear, "front_distance": QUADRICYCLE.front}
    measured = {
        name: dataclasses.replace(vehicle.parameters[name], value=value, standard_deviation=0.03 * value)
        for name, value in known.items()
    }
    return dataclasses.replace(vehicle, parameters={**vehicle.parameters, **measured})


def tight(fastest, seconds=50.0):
    """Halts and turns to 30 degrees of the road wheels, at walking pace and up to a speed [m/s] with wider turns."""
    time = np.arange(0.0, seconds, STEP)
    speed = np.interp(time, [0, 2, 4, 14, 16, 18, 22, 40, 44, 50], [0, 0, 0.5, 1.5, 0, 0, 2.5, fastest, fastest, 0.4])
    bound = np.minimum(math.radians(30.0), np.arctan(2.5 * 1.7 / np.maximum(speed, 0.5) ** 2))
    return speed, bound * np.sin(0.9 * time)


@pytest.fixture(scope="module")
def drives():
    """Recordings with their states: slow, at walking pace alone, out of a parking space backwards and forwards."""
    cars = [tight(7.0), tuple(each[: int(15.0 / STEP)] for each in tight(7.0)), backs_out(), backs_out(-1.0)]
    length = max(len(speed) for speed, _ in cars)
    padded = [tuple(np.pad(each, (0, length - len(each)), "edge") for each in both) for both in cars]
    courses = [(QUADRICYCLE, each) for each in padded]
    return recordings(courses, SEED, unsigned=True), driven(courses)


def true_sideslip(states, k):
    along, across = states[0, :, k], states[1, :, k]
    return np.arange(len(along)) * STEP * EVERY, np.arctan2(across, np.maximum(along, 0.1))


def test_the_headline_is_a_sample_of_the_course_with_its_own_deviation_and_holds_the_truth(car, drives):
    recorded, states = drives
    found = diagnose(recorded[0], car, "sideslip")
    estimate = found.findings[0].estimate
    course, band = (found.traces[f"sideslip_angle{end}"] for end in ("", "_standard_deviation"))
    at = int(np.nanargmin(np.abs(course.mean - estimate.value)))
    assert estimate.value == pytest.approx(course.mean[at], rel=0.02)
    assert estimate.standard_deviation == pytest.approx(band.mean[at], rel=0.1)
    time, truth = true_sideslip(states, 0)
    assert abs(estimate.value - np.interp(course.time[at], time, truth)) < BAND * estimate.standard_deviation
    assert "most of it is the geometry of a tight turn" in said(found.findings[0])
    assert found.findings[0].evidence["limit_announced_s"] == 0.0
    assert "largest force" not in said(found.findings[0])


def test_walking_pace_alone_gives_neither_a_value_nor_a_limit(car, drives):
    finding = diagnose(drives[0][1], car, "sideslip").findings[0]
    assert finding.status is Status.NOT_ENABLED
    assert finding.estimate is None
    assert "walking pace" in said(finding)
    assert "largest force" not in said(finding)


def test_what_a_car_with_unsigned_speeds_does_in_reverse_is_neither_its_largest_sideslip_nor_a_limit(car, drives):
    back, out = (diagnose(each, car, "sideslip").findings[0] for each in drives[0][2:])
    (said,) = (each for each in back.warnings if each.startswith("the car reversed"))
    assert said == "the car reversed from 4.4 s to 9.0 s; its speeds have no sign"
    assert abs(abs(back.estimate.value) - abs(out.estimate.value)) < 2.0 * out.estimate.standard_deviation
    assert back.evidence["limit_announced_s"] == 0.0
    assert not any("revers" in each for each in out.warnings)


@pytest.fixture(scope="module")
def steady():
    """A slow weave."""
    time = np.arange(0.0, 40.0, STEP)
    (made,) = recordings([(QUADRICYCLE, (6.0 + 1.5 * np.sin(0.3 * time), 0.07 * np.sin(0.7 * time)))], SEED)
    return made.slice(6.0)


@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_an_offset_of_the_yaw_rate_is_named_by_the_wheels_despite_a_wave_on_the_speed(car, steady, offset):
    yaw_rate, read = steady["yaw_rate"], steady["vehicle_speed"]
    wave = read.values + (0.8 + 0.8 * np.sin(0.2 * read.time) if offset else 0.0)
    made = steady.with_channels(
        [dataclasses.replace(yaw_rate, values=yaw_rate.values + offset), dataclasses.replace(read, values=wave)]
    )
    finding = diagnose(made, car, "sideslip", spread=False).findings[0]
    assert ("offset of" in f"{said(finding)} {finding.cause}") is bool(offset)
    assert finding.status.exit_code == (1 if offset else 0)
