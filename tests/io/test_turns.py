"""Units of speed, yaw rate and lateral acceleration, seen in turns."""

import dataclasses

import numpy as np
import pytest

from exact_vehicle import diagnose
from shared_data import shared_data
from tierod.core.recording import Channel, Recording
from tierod.io.readers import read
from tierod.io.signs import NAMES, turn_warnings
from tierod_lab.ground import drive


@pytest.fixture(scope="module")
def fault_free():
    return drive(minutes=4.0, seed=2)


def scaled(recording: Recording, name: str, factor: float) -> Recording:
    return recording.with_channels([dataclasses.replace(recording[name], values=factor * recording[name].values)])


@pytest.mark.parametrize("factor", [1.0, -1.0, 0.8, 1.25])
@pytest.mark.parametrize("name", NAMES)
def test_signs_and_gains_are_no_matter_of_units(fault_free, name, factor):
    assert turn_warnings(scaled(fault_free, name, factor)) == ()


@pytest.mark.parametrize(
    ("name", "factor", "sentence"),
    [
        ("vehicle_speed", 3.6, "vehicle_speed looks like km/h taken for m/s"),
        ("vehicle_speed", 1.0 / 3.6, "vehicle_speed looks converted twice"),
        ("yaw_rate", 57.3, "at least one of them has a wrong unit"),
        ("lateral_acceleration", 1.0 / 9.81, "at least one of them has a wrong unit"),
    ],
)
def test_a_wrong_unit_is_reported(fault_free, name, factor, sentence):
    (warning,) = turn_warnings(scaled(fault_free, name, factor))
    assert sentence in warning


def test_a_wrong_unit_stands_beside_the_verdict(fault_free):
    finding = diagnose(scaled(fault_free, "vehicle_speed", 3.6), "midsize-eps").findings[0]
    assert [warning for warning in finding.warnings if "km/h taken for m/s" in warning]


def test_where_nothing_turns_or_is_known_nothing_is_said(fault_free):
    straight = {
        name: dataclasses.replace(fault_free[name], values=0.01 * fault_free[name].values) for name in NAMES[1:]
    }
    assert turn_warnings(fault_free.with_channels(straight.values())) == ()
    assert turn_warnings(fault_free.slice(0.0, 5.0)) == ()
    assert turn_warnings(fault_free.slice(0.0, 0.5)) == ()
    assert turn_warnings(Recording({"yaw_rate": fault_free["yaw_rate"]})) == ()
    rng = np.random.default_rng(1)
    noise = fault_free["yaw_rate"]
    unrelated = Channel("yaw_rate", noise.time, rng.normal(0.0, 10.0, len(noise.time)), "rad/s")
    assert turn_warnings(fault_free.with_channels([unrelated])) == ()


def test_a_car_with_unknown_units():
    recording = read(shared_data("revsted_slip_angle", "obd.csv"))
    (warning,) = turn_warnings(recording)
    ratio = float(warning.split("is ")[1].split(" times")[0])
    assert ratio == pytest.approx(np.pi / 180.0 / 3.6, rel=0.2), "degrees and km/h, taken for rad and m/s"
