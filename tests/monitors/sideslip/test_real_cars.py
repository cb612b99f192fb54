"""Sideslip of two real cars, from their files to the finding; skipped where the recordings are absent."""

import math

import numpy as np
import pytest

from exact_vehicle import diagnose
from shared_data import shared_data
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.vehicles import load
from tierod_lab.papers.sideslip.calibration import beside_truth

RACE = ("ferrari_250lm_race", "laps.parquet")
PARK = ("revsted_slip_angle", "obd.csv")


def recording(parts, car):
    return complete(read(shared_data(*parts), channel_map=load(car).channel_map))


@pytest.fixture(scope="module")
def laps():
    return recording(RACE, "ferrari-250lm")


@pytest.fixture(scope="module")
def judged(laps):
    """First and last time of the laps, and from when nothing was fitted."""
    first, last = laps["sideslip_angle"].time[[0, -1]]
    return first + 1.0, first + 0.6 * (last - first)


def degrees(figures):
    return math.degrees(figures.mean_absolute), math.degrees(figures.rms)


def test_race_laps_to_which_nothing_was_fitted(laps, judged):
    seen = beside_truth(laps, load("ferrari-250lm"))
    rest = seen.figures(judged[1])
    assert degrees(rest)[0] <= 0.15
    assert degrees(rest)[1] <= 0.20
    assert 0.9 <= rest.coverage <= 0.995
    assert np.isfinite(seen.estimate).all()


def test_the_passenger_car_with_an_optical_sensor():
    car = recording(PARK, "revsted-car")
    begin = car["yaw_rate"].time[0]
    rest = beside_truth(car, load("revsted-car"), 50.0).figures(begin + 5.0)
    assert degrees(rest)[0] <= 0.18
    assert degrees(rest)[1] <= 0.22
    assert rest.coverage >= 0.9


@pytest.mark.parametrize(("parts", "car", "most"), [(RACE, "ferrari-250lm", 0.2), (PARK, "revsted-car", 0.22)])
def test_from_the_file_to_the_finding(parts, car, most):
    found = diagnose(shared_data(*parts), car, "sideslip")
    (finding,) = found.findings
    assert finding.status.quiet
    assert math.degrees(finding.evidence["error_against_truth_rms_rad"]) < most
    assert finding.evidence["truth_within_band_share"] > 0.9
    assert "sideslip_angle_standard_deviation" in found.traces
    assert "true_sideslip_angle" in found.traces


def test_a_wrong_sign_of_the_lateral_acceleration_is_named_from_the_data(tmp_path):
    car = load("revsted-car")
    text = car.channel_map.read_text(encoding="utf-8").replace("sign = -1\n", "")
    trap = tmp_path / "trap.channels.toml"
    trap.write_text(text, encoding="utf-8")
    (finding,) = diagnose(shared_data(*PARK), car, "sideslip", channel_map=trap).findings
    assert finding.status is Status.NOT_TESTABLE
    assert "lateral acceleration" in finding.cause
    assert "sign" in finding.action


def test_a_file_of_another_car_gives_no_value():
    recording = read(shared_data(*PARK), channel_map=load("revsted-car").channel_map)
    bare = Recording({name: each for name, each in recording.channels.items() if name != "sideslip_angle"})
    found = diagnose(bare, "midsize-eps", "sideslip")
    (finding,) = found.findings
    assert finding.status is Status.INCONSISTENT
    assert finding.estimate is None
    assert finding.headline == "Sideslip: inconsistent, the vehicle file does not fit this car"
    assert "accelerometer" in finding.cause
    assert "track" in finding.cause
    assert "sideslip_angle" not in found.traces
