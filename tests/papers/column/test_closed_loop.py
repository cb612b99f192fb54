"""The bench under position control: what the study measures with, and that it does what it says."""

import math

import numpy as np
import pytest

from tierod_lab.ground.cars.benches import ColumnBench
from tierod_lab.papers.column.charts import differences
from tierod_lab.papers.column.closed_loop import (
    BEGIN,
    NOISE,
    SAMPLE_TIME,
    belief,
    error,
    followed,
    run,
    sine,
)
from tierod_lab.papers.column.control.reference import Sweep
from tierod_lab.papers.column.hand_datasets import loops

KNOWN = belief()


@pytest.fixture(scope="module")
def loop():
    return loops()["printed, mechanical"]


@pytest.fixture(scope="module")
def slow(loop):
    return run(loop, Sweep(start=1.0, stop=1.0), 5.0, 1)


def test_belief_and_plant_have_the_same_numbers_and_share_no_object():
    bench, column = ColumnBench(), KNOWN.column
    assert column.steering_wheel_inertia == bench.wheel_inertia
    assert column.gear_stiffness == bench.gear_stiffness
    assert KNOWN.friction == bench.friction.level


def test_the_torque_found_from_a_sample_acts_from_the_next_one_on(slow):
    asked, acting = slow.signals["control.motor_torque"], slow.signals["plant.motor_target_torque"]
    np.testing.assert_array_equal(acting[1:], asked[:-1])


def test_sensors_have_the_noise_they_are_said_to_have(slow):
    for name, deviation in NOISE._asdict().items():
        noise = slow.signals[f"measured.{name}"] - slow.signals[f"plant.{name}"]
        assert noise.std() == pytest.approx(deviation, rel=0.05)


def test_the_shaft_follows(loop, slow):
    assert followed(slow, BEGIN + 1.0).rms < 0.25
    found = sine(loop, 3.0, 2, quick=True)
    assert found.rms < 0.25
    assert abs(found.phase) < 1.0


def test_the_figures_of_a_known_lag(slow):
    late = slow._replace(
        reference=slow.reference._replace(angle=np.sin(2.0 * math.pi * slow.time)),
        signals={
            "plant.truth_gear_angle": 1.01 * np.sin(2.0 * math.pi * slow.time - 0.02),
        },
    )
    found = followed(late, 3.0, 5.0, 1.0)
    assert found.phase == pytest.approx(-math.degrees(0.02), rel=1e-6)
    apart = math.degrees(abs(1.01 * np.exp(-0.02j) - 1.0))
    assert found.rms == pytest.approx(apart / math.sqrt(2.0), rel=1e-3)
    assert np.abs(error(late)).max() == pytest.approx(apart, rel=1e-3)


def test_hands_off_the_wheel_are_on_it_with_no_torque(slow):
    assert np.abs(slow.signals["plant.truth_hand_torque"]).max() < 1e-9


def test_differences_are_late_by_nothing():
    time = np.arange(0.0, 2.0, SAMPLE_TIME)
    rate = differences(np.sin(6.0 * time))
    np.testing.assert_allclose(rate[50:-50], 6.0 * np.cos(6.0 * time[50:-50]), atol=6e-3)
