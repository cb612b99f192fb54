"""Playing a recording: what is encoded is decoded again, and what goes wrong follows from the seed."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from live_drives import drive, frames_of_drive, messages
from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.io.readers.channel_map import parse_channel_map
from tierod.io.writers import write
from tierod.live.clock import frames_of
from tierod.live.decoding import Decoder
from tierod.live.encoding import Differences, encoded
from tierod.live.log import FrameLog
from tierod.live.replay import Disturbance, Played, disturbed, frames_of_file

pytest.importorskip("cantools")
can = pytest.importorskip("can")


def decoded(folder, frames, name):
    decoder = Decoder(messages(folder))
    arrays = frames_of(frames, 0.0)
    decoder.hear(arrays)
    (channel,) = decoder.channels(arrays, [name])
    return channel


@pytest.mark.parametrize(
    ("column", "name", "step"),
    [("EPS.steering_wheel_angle", "steering_wheel_angle", 5e-4), ("ESP.yaw_rate", "yaw_rate", 1e-4)],
)
def test_signals_come_back_within_half_a_step_of_their_bits(tmp_path, column, name, step):
    frames = frames_of_drive(tmp_path, 3.0)
    found = decoded(tmp_path, frames, column)
    np.testing.assert_allclose(found.values, drive(3.0)[name].values, atol=0.51 * step)
    times = drive(3.0)[name].time - min(each.time[0] for each in drive(3.0).channels.values())
    np.testing.assert_allclose(found.time - frames[0].time, times, atol=1e-6)


def test_a_channel_map_is_undone(tmp_path):
    entry = {"source": "ESP.lateral_acceleration", "sign": -1, "factor": 2.0, "unit": "m/s**2"}
    chosen = parse_channel_map({"signals": {"longitudinal_acceleration": entry}}, "map")
    values = drive(1.0)["lateral_acceleration"]
    recording = Recording({"longitudinal_acceleration": replace(values, name="longitudinal_acceleration")})
    write(recording, tmp_path / "one.parquet")
    frames = list(encoded(tmp_path / "one.parquet", messages(tmp_path), chosen))
    found = decoded(tmp_path, frames, "ESP.lateral_acceleration")
    np.testing.assert_allclose(found.values, values.values / -2.0, atol=6e-4)


DEGREES = """VERSION ""
BU_: ECU
BO_ 256 STEER: 8 ECU
 SG_ steering_wheel_angle : 0|16@1- (0.1,0) [-800|800] "deg" ECU
 SG_ vehicle_speed : 16|16@1+ (0.01,0) [0|300] "km/h" ECU
 SG_ temperature : 32|8@1+ (1,-40) [-40|215] "degC" ECU
 SG_ bare : 40|8@1+ (1,0) [0|255] "" ECU
"""

TIME = np.arange(200) / 100.0


def in_degrees(folder):
    from tierod.io.readers.dbc import load_databases

    (folder / "deg.dbc").write_text(DEGREES)
    return load_databases([folder / "deg.dbc"])


def on_the_bus(folder, header, values, chosen=None):
    """What a receiver with the same database decodes, and what the frames do not carry."""
    if isinstance(header, Recording):
        path = folder / "drive.parquet"
        write(header, path)
    else:
        path = folder / "drive.csv"
        cells = (
            ",".join("" if value != value else repr(float(value)) for value in row) for row in zip(*values, strict=True)
        )
        path.write_text(
            "time," + header + "\n" + "\n".join(f"{t},{row}" for t, row in zip(TIME, cells, strict=True)) + "\n"
        )
    differences = Differences()
    frames = list(encoded(path, in_degrees(folder), chosen, differences))
    decoder = Decoder(in_degrees(folder))
    arrays = frames_of(frames, 0.0)
    decoder.hear(arrays)
    names = ["STEER.steering_wheel_angle", "STEER.vehicle_speed", "STEER.temperature", "STEER.bare"]
    return {each.name: each for each in decoder.channels(arrays, names)}, differences


@pytest.mark.parametrize(
    ("header", "factors"),
    [
        ("steering_wheel_angle [rad],vehicle_speed [m/s],temperature [K],bare", (np.pi / 180.0, 1 / 3.6, 273.15)),
        ("STEER.steering_wheel_angle [deg],STEER.vehicle_speed [kph],STEER.temperature [°C],bare", (1.0, 1.0, 0.0)),
        ("steering_wheel_angle [turns],vehicle_speed [mph],temperature [degC],bare", (1 / 360.0, 1 / 1.609344, 0.0)),
    ],
)
def test_columns_are_sent_in_the_unit_of_the_database(tmp_path, header, factors):
    angle, speed, temperature = 275.2 * np.sin(TIME), 129.7 + 0 * TIME, 21.0 + 0 * TIME
    columns = [angle * factors[0], speed * factors[1], temperature + factors[2], 7.0 + 0 * TIME]
    found, differences = on_the_bus(tmp_path, header, columns)
    np.testing.assert_allclose(found["STEER.steering_wheel_angle"].values, angle, atol=0.051)
    np.testing.assert_allclose(found["STEER.vehicle_speed"].values, speed, atol=0.0051)
    np.testing.assert_allclose(found["STEER.temperature"].values, temperature, atol=0.51)
    np.testing.assert_array_equal(found["STEER.bare"].values, 7.0)
    assert differences.sentences() == ()


def test_a_sign_with_a_signal_of_its_own_is_sent_beside_the_magnitude(tmp_path):
    entry = {"source": "STEER.vehicle_speed", "sign_from": "STEER.bare"}
    chosen = parse_channel_map({"signals": {"wheel_speed_rear_left": entry}}, "map")
    values = 8.0 * np.cos(5.0 * TIME)
    recording = Recording({"wheel_speed_rear_left": Channel("wheel_speed_rear_left", TIME, values, "m/s")})
    found, _ = on_the_bus(tmp_path, recording, (), chosen)
    np.testing.assert_allclose(found["STEER.vehicle_speed"].values, 3.6 * np.abs(values), atol=0.0051)
    np.testing.assert_array_equal(found["STEER.bare"].values, values < 0.0)


@pytest.mark.parametrize(
    ("header", "sentence"),
    [
        ("steering_wheel_angle", r"drive.csv: the column 'steering_wheel_angle' has no unit, and "
         r"STEER.steering_wheel_angle is sent in deg; write .*'steering_wheel_angle \[deg\]', or name .*--map"),
        ("steering_wheel_angle [Nm]", "sent as STEER.steering_wheel_angle: the unit 'N.m' cannot become 'deg'"),
        ("steering_wheel_angle [blah]", "the unit 'blah' is not known"),
        ("bare [rad]", "the database gives STEER.bare no unit, and the column 'bare' is in rad"),
    ],
)  # fmt: skip
def test_a_column_whose_unit_is_not_known_is_refused_with_a_cure(tmp_path, header, sentence):
    with pytest.raises(InputError, match=sentence):
        on_the_bus(tmp_path, header, [np.sin(TIME)])


def test_values_beyond_the_bits_are_limited_and_counted(tmp_path):
    speed = np.where(TIME < 0.1, -5.0, np.where(TIME > 1.895, 1e300, 50.0))
    found, differences = on_the_bus(tmp_path, "vehicle_speed [km/h]", [speed])
    assert found["STEER.vehicle_speed"].values[[0, 100, -1]] == pytest.approx([0.0, 50.0, 655.35])
    assert differences.sentences()[0] == "20 values beyond the range of STEER.vehicle_speed were sent as its limit"


def test_no_value_is_sent_for_one_that_is_missing(tmp_path):
    angle = np.where((TIME >= 0.5) & (TIME < 0.75), np.nan, 100.0)
    found, differences = on_the_bus(tmp_path, "steering_wheel_angle [deg],vehicle_speed [km/h]", [angle, 50.0 + TIME])
    arrived = found["STEER.steering_wheel_angle"]
    assert arrived.values == pytest.approx(np.full(175, 100.0))
    assert np.diff(arrived.time).max() == pytest.approx(0.26, abs=1e-3)
    assert "25 frames were not sent, since STEER.steering_wheel_angle is missing there" in differences.sentences()
    assert (
        "constant on the bus, since the recording lacks them: STEER.temperature, STEER.bare" in differences.sentences()
    )


def test_a_rare_signal_is_held_and_not_sent_before_its_first_sample(tmp_path):
    fast = np.arange(4000) / 100.0
    channels = [
        Channel("steering_wheel_angle", fast, np.sin(fast), "rad"),
        Channel("vehicle_speed", np.array([1.0, 21.0]), np.array([10.0, 20.0]), "m/s"),
    ]
    found, differences = on_the_bus(tmp_path, Recording({each.name: each for each in channels}), None)
    speed = found["STEER.vehicle_speed"].values
    assert len(speed) == 3900
    assert speed[[0, 1500, 1999, 2000, -1]] == pytest.approx([36.0, 36.0, 36.0, 72.0, 72.0])
    assert differences.missing == {"STEER.vehicle_speed": 100}


def test_a_bus_log_is_played_as_it_is(tmp_path):
    frames = frames_of_drive(tmp_path, 1.0)
    log = FrameLog(tmp_path / "log.mf4", 0.0)
    log.append(frames)
    log.finish()
    again = list(frames_of_file(tmp_path / "log.mf4", [], None))
    assert [(each.identifier, each.data) for each in again] == [(each.identifier, each.data) for each in frames]
    assert again[0].time == 0.0


def test_the_same_seed_gives_the_same_disturbance(tmp_path):
    frames = frames_of_drive(tmp_path, 10.0)
    how = Disturbance(7, loss=0.05, doubled=0.02, jitter=0.001, reordered=0.03, bus_off=20.0)
    first, second, third = Played(), Played(), Played()
    one = list(disturbed(iter(frames), how, first))
    assert one == list(disturbed(iter(frames), how, second))
    assert first == second
    other = list(disturbed(iter(frames), Disturbance(8, 0.05, 0.02, 0.001, 0.03, 20.0), third))
    assert other != one
    assert len(one) == len(frames) - first.lost + first.doubled
    assert first.off >= 1
    assert 0.01 * len(frames) < first.held < 0.05 * len(frames)
    assert [each.time for each in one] == sorted(each.time for each in one)
    kept = Counter(each.data for each in frames)
    assert all(each.data in kept for each in one)
