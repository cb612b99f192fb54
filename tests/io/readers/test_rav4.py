"""The real RAV4 minute, decoded with the database and the map that tierod ships."""

from importlib.resources import files

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.io.signs import sign_warnings

pytest.importorskip("cantools")


@pytest.fixture(scope="module")
def minute() -> Recording:
    return complete(read(shared_data("rav4_highway_minute", "can.log"), dbc="rav4", channel_map="rav4"))


def test_every_signal_is_there_at_its_rate(minute):
    rates = {"driver_torque": 50, "motor_torque": 50, "steering_torque_request": 100, "yaw_rate": 83}
    for name, rate in rates.items():
        assert len(minute[name].time) == pytest.approx(60 * rate, rel=0.01)
    assert minute.metadata["frames"] == 66054
    assert minute.span == pytest.approx((0.0, 60.0), abs=0.05)


def test_torques_are_counts_and_say_so(minute):
    assert minute["driver_torque"].unit == minute["motor_torque"].unit == "count"
    assert "not calibrated" in minute["driver_torque"].note


def test_the_speed_is_that_of_the_reference(minute):
    reference = read(shared_data("rav4_highway_minute", "reference_speed.csv"))
    options = {"rate": 20.0, "start": 0.0, "stop": 59.0}
    ours = minute.align(["vehicle_speed"], **options).values
    theirs = reference.align(["vehicle_speed"], method="linear", **options).values
    difference = ours - theirs
    assert abs(np.nanmean(difference)) < 0.25
    assert np.nanstd(difference) < 0.1
    assert 7.0 < np.nanmin(ours) < np.nanmax(ours) < 21.0


def test_angles_stay_small(minute):
    assert np.degrees(np.abs(minute["steering_wheel_angle"].values)).max() < 5.1


def test_lateral_acceleration_is_turned_and_centred(minute):
    names = ["lateral_acceleration", "yaw_rate", "vehicle_speed"]
    lateral, yaw, speed = minute.align(names, 20.0).values.T
    offset = lateral - yaw * speed
    assert abs(np.nanmean(offset)) < 0.05
    assert "sign turned, offset -0.2" in minute["lateral_acceleration"].note
    assert sign_warnings(minute) == ()


def test_the_map_beside_the_database_is_used_without_asking(minute):
    beside = complete(read(shared_data("rav4_highway_minute", "can.log"), dbc="rav4"))
    assert beside.metadata["channel_map"].endswith("rav4.channels.toml")
    for name in ("lateral_acceleration", "steering_wheel_angle"):
        assert np.array_equal(beside[name].values, minute[name].values)


def test_without_the_map_the_wrong_sign_is_seen(tmp_path):
    alone = tmp_path / "alone.dbc"
    alone.write_bytes(files("tierod.vehicles").joinpath("rav4.dbc").read_bytes())
    raw = complete(read(shared_data("rav4_highway_minute", "can.log"), dbc=alone))
    assert "channel_map" not in raw.metadata
    (warning,) = sign_warnings(raw)
    assert warning.startswith("lateral_acceleration probably has the wrong sign (in turns")
