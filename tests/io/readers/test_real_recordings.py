"""Real recordings: vendor headers, bursts, MATLAB structures, a wrong sign, and the RAV4 with its shipped database."""

import csv
from importlib.resources import files

import numpy as np
import pytest

from can_logs import stored, together
from shared_data import shared_data
from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.io.quality import channel_quality
from tierod.io.readers import parse_channel_map, read
from tierod.io.readers.vendor_can import frames_of
from tierod.io.signs import sign_warnings


def test_passenger_car_with_a_wrong_sign():
    units = {"steering_wheel_angle": ("SW_pos_obd", "deg"), "yaw_rate": ("yaw_rate", "deg/s")}
    table = {name: {"source": source, "unit": unit} for name, (source, unit) in units.items()}
    speed = {"vehicle_speed": {"source": "speedo_obd", "unit": "km/h"}}
    path = shared_data("revsted_slip_angle", "obd.csv")
    recording = read(path, channel_map=parse_channel_map({"signals": table | speed}))
    assert recording.metadata["origin"] == pytest.approx(1716990839.85)
    assert np.degrees(recording["steering_wheel_angle"].values[0]) == pytest.approx(54.863)
    (warning,) = sign_warnings(recording)
    assert warning.startswith("lateral_acceleration probably has the wrong sign")


def test_a_database_with_orphaned_entries_is_read_without_them():
    pytest.importorskip("cantools")
    folder = shared_data("dacia_lock_to_lock")
    recording = read(folder / "candump.log", dbc=folder / "logan.dbc")
    assert {"steering_wheel_angle", "steering_wheel_rate"} <= set(recording.names)
    assert np.degrees(recording["steering_wheel_angle"].values) == pytest.approx(-5.6, abs=0.6)


def test_race_car():
    recording = read(shared_data("ferrari_250lm_race", "laps.parquet"))
    wanted = {
        "road_wheel_angle",
        "vehicle_speed",
        "lateral_speed",
        "sideslip_angle",
        "yaw_rate",
        "lateral_acceleration",
    }
    assert wanted <= set(recording.names)
    assert len(recording["yaw_rate"].time) == 27500
    assert sign_warnings(recording) == ()


def test_bursts_are_paced(tmp_path):
    pytest.importorskip("cantools")
    folder = shared_data("dacia_lock_to_lock")
    rows = csv.DictReader((folder / "steering.csv").read_text().splitlines())
    log = tmp_path / "steering.log"
    log.write_text("".join(f"({row['timestamp']}) can0 {row['can_id']}#{row['data_str']}\n" for row in rows))
    recording = read(log, dbc=folder / "logan.dbc", names=["steering_wheel_angle"])
    angle = recording["steering_wheel_angle"]
    assert np.degrees([angle.values.min(), angle.values.max()]) == pytest.approx([-578.0, 573.0], abs=2.0)
    assert "arrive in bursts" in " ".join(channel_quality(recording["steering_wheel_angle"]).remarks)
    again = recording.retime(0.01)["steering_wheel_angle"]
    steps = np.diff(again.time)
    assert np.median(steps) == pytest.approx(0.01, abs=1e-6)
    assert np.abs(steps - 0.01).max() < 1e-3
    assert np.abs(again.time - angle.time).max() < 0.1


@pytest.mark.parametrize(("name", "channels", "period"), [("a3NI.csv", 2, 0.0005), ("a3MR.csv", 15, 0.000666666)])
def test_headers_of_vendors(name, channels, period):
    recording = read(shared_data("rack_and_pinion_friction", name))
    assert len(recording.names) == channels
    assert np.median(np.diff(recording[recording.names[0]].time)) == pytest.approx(period, rel=1e-4)


def test_structures_of_matlab():
    recording = read(shared_data("pmsm_drive", "SigRecSaveE.mat"))
    assert recording["motor_current_alpha"].values[0] == pytest.approx(-7.33495522)
    assert recording["motor_current_alpha"].time[1] == pytest.approx(0.0016)
    assert {"motor_current_beta", "motor_voltage_alpha", "motor_voltage_beta"} <= set(recording.names)


@pytest.mark.parametrize("name", ["NeckEncoderResolution", "RecordPosRslt", "RecordSpeedRslt", "SigRecSave1"])
def test_every_matlab_file_opens(name):
    assert len(read(shared_data("pmsm_drive", f"{name}.mat")).names) >= 3


def test_a_bus_log_that_is_cut_off_prints_nothing(tmp_path, capsys):
    pytest.importorskip("asammdf")
    whole = next(shared_data("reader_samples", "mf4_css").glob("*2F6913DB*5CD.MF4")).read_bytes()
    half = tmp_path / "half.mf4"
    half.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="damaged or cut off"):
        read(half)
    assert capsys.readouterr() == ("", "")


def test_a_blf_log_that_is_cut_off_is_said_to_be(tmp_path):
    pytest.importorskip("can")
    whole = shared_data("reader_samples", "python_can", "test", "data", "issue_1905.blf").read_bytes()
    every = together(frames_of(stored(tmp_path, whole), "blf"))
    half = together(frames_of(stored(tmp_path, whole[: len(whole) // 2]), "blf"))
    assert every.notes == ()
    assert 0 < len(half) < len(every)
    assert "cut off" in half.notes[0]


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
