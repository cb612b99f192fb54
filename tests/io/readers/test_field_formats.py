"""Bags, MCAP, HDF5, MATLAB 7.3, Feather and CarMaker files of other libraries, whole and damaged."""

import shutil

import numpy as np
import pytest

from foreign_files import COUNT, SPEED, START, TIME, YAW, erg_file, feather_file, hdf5_file, mcap_file, ros_bag
from shared_data import shared_data
from tierod.core.errors import InputError
from tierod.io.readers import parse_channel_map, read


def test_mcap_of_the_library_of_foxglove(tmp_path):
    recording = read(mcap_file(tmp_path / "drive.mcap"))
    np.testing.assert_array_equal(recording["yaw_rate"].values, YAW)
    np.testing.assert_array_equal(recording["state.wheel.speeds[0]"].values, SPEED)
    np.testing.assert_allclose(recording["yaw_rate"].time, TIME, atol=1e-9)
    assert recording.metadata["origin"] == START
    assert any("flatbuffer" in warning for warning in recording.warnings)


def test_mcap_that_was_cut_off_gives_what_stands_before(tmp_path):
    path = mcap_file(tmp_path / "drive.mcap")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    recording = read(path)
    assert 50 < len(recording["yaw_rate"].time) < COUNT
    assert any("cut off" in warning for warning in recording.warnings)


@pytest.mark.parametrize("first", [True, False])
def test_bags_of_ros(tmp_path, first):
    recording = read(ros_bag(tmp_path / ("drive.bag" if first else "bag"), first))
    values = recording["imu/rate.vector.z"]
    np.testing.assert_array_equal(values.values, YAW)
    np.testing.assert_allclose(values.time, TIME + 0.002, atol=1e-9)
    assert recording.metadata["origin"] == START


def test_the_time_of_a_bag_can_be_that_of_the_sensor(tmp_path):
    chosen = parse_channel_map({"time": {"column": "header.stamp"}, "signals": {}}, "map")
    recording = read(ros_bag(tmp_path / "bag", False), channel_map=chosen)
    np.testing.assert_allclose(recording["imu/rate.vector.z"].time, TIME, atol=1e-6)


@pytest.mark.parametrize("matlab", [False, True])
def test_hdf5_and_matlab_73(tmp_path, matlab):
    recording = read(hdf5_file(tmp_path / ("drive.mat" if matlab else "drive.h5"), matlab))
    np.testing.assert_array_equal(recording["yaw_rate"].values, YAW)
    np.testing.assert_array_equal(recording["vehicle_speed"].values, SPEED[::10])
    np.testing.assert_array_equal(recording["vehicle_speed"].time, np.arange(COUNT // 10) / 10.0)
    assert recording["yaw_rate"].unit == "rad/s"


def test_a_table_in_hdf5(tmp_path):
    import h5py

    table = np.zeros(COUNT, dtype=[("time", "f8"), ("yaw_rate", "f4"), ("label", "S3")])
    table["time"], table["yaw_rate"] = TIME, YAW
    with h5py.File(tmp_path / "t.h5", "w") as file:
        file["log/table"] = table
    recording = read(tmp_path / "t.h5")
    assert recording.names == ("yaw_rate",)
    np.testing.assert_array_equal(recording["yaw_rate"].values, YAW.astype("f4"))


@pytest.mark.parametrize("stream", [False, True])
def test_feather_and_arrow_streams(tmp_path, stream):
    recording = read(feather_file(tmp_path / "drive.feather", stream))
    np.testing.assert_array_equal(recording["vehicle_speed"].values, SPEED)
    np.testing.assert_allclose(recording["yaw_rate"].time, TIME, atol=1e-6)
    assert recording.metadata["origin"] == START


def test_an_arrow_stream_that_was_cut_off(tmp_path):
    path = feather_file(tmp_path / "drive.arrows", True)
    path.write_bytes(path.read_bytes()[:-1500])
    recording = read(path)
    assert 100 < len(recording["yaw_rate"].time) < COUNT
    assert any("cut off" in warning for warning in recording.warnings)


def test_carmaker_as_its_own_reader_sees_it(tmp_path):
    cmerg = pytest.importorskip("cmerg")
    path = erg_file(tmp_path / "drive.erg")
    recording = read(path)
    other = cmerg.ERG(str(path))
    np.testing.assert_array_equal(recording["yaw_rate"].values, other.signals["Car.YawRate"].data.astype(float))
    np.testing.assert_array_equal(recording["yaw_rate"].time, other.signals["Time"].data)
    assert recording["yaw_rate"].unit == "rad/s"
    assert recording.names == ("yaw_rate", "Car.Gear")


def test_carmaker_without_its_description(tmp_path):
    path = erg_file(tmp_path / "drive.erg")
    path.with_name("drive.erg.info").unlink()
    with pytest.raises(InputError, match=r"drive\.erg\.info, which is missing; copy both"):
        read(path)


@pytest.mark.parametrize("name", ["drive.mcap", "drive.bag", "drive.h5", "drive.feather", "drive.db3"])
def test_damaged_files_give_one_sentence(tmp_path, name):
    made = {
        "drive.mcap": lambda path: mcap_file(path),
        "drive.bag": lambda path: ros_bag(path, True),
        "drive.h5": lambda path: hdf5_file(path),
        "drive.feather": lambda path: feather_file(path),
        "drive.db3": lambda path: shutil.copy(next(ros_bag(tmp_path / "bag", False).glob("*.db3")), path),
    }
    path = tmp_path / name
    made[name](path)
    data = path.read_bytes()
    path.write_bytes(data[:120] + bytes(200) + data[320:400])
    with pytest.raises(InputError, match=name.replace(".", r"\.")):
        read(path)


def test_an_hdf5_file_that_unfolds_to_too_much_is_refused(tmp_path):
    import h5py

    with h5py.File(tmp_path / "bomb.h5", "w") as file:
        for name in ("time", "yaw_rate"):
            file.create_dataset(name, shape=(10**9,), dtype="f8", chunks=(1 << 16,), compression="gzip")
    assert (tmp_path / "bomb.h5").stat().st_size < 10_000
    with pytest.raises(InputError, match="unpacks to more than"):
        read(tmp_path / "bomb.h5")


def test_a_link_to_another_file_is_not_followed(tmp_path):
    import h5py

    hdf5_file(tmp_path / "secret.h5")
    path = hdf5_file(tmp_path / "drive.h5")
    with h5py.File(path, "a") as file:
        file["fast/stolen"] = h5py.ExternalLink("secret.h5", "/fast/yaw_rate")
    assert "stolen" not in " ".join(read(path).names)


@pytest.mark.parametrize(
    ("name", "channel", "count"),
    [
        ("tilt_laser.bag", "yaw_rate", 356),
        ("example.bag", "turtle1/pose.theta", 1344),
        ("rosbag2_test_0.db3", "pose.pose.position.x", 1565),
        ("", "pose.pose.position.x", 1565),
    ],
)
def test_bags_of_plotjuggler(name, channel, count):
    recording = read(shared_data("reader_samples", "rosbag_plotjuggler", name))
    assert len(recording[channel].time) == count


def test_fields_that_come_in_later_messages_are_read(tmp_path):
    """The second message of a JSON topic has more fields than the first, and an array grows; one comes too late."""
    import json

    from mcap.writer import Writer

    path = tmp_path / "grows.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        topic = writer.register_channel("/state", "json", writer.register_schema("s", "jsonschema", b"{}"))
        for place in range(1000):
            fields = {"a": place, "list": [1.0] * (1 + (place > 2))} | ({"b": 2.0 * place} if place > 1 else {})
            fields |= {"late": 1.0} if place > 900 else {}
            stamp = START * 10**9 + place * 10_000_000
            writer.add_message(topic, stamp, json.dumps(fields).encode(), stamp)
        writer.finish()
    recording = read(path)
    assert {"state.a", "state.b", "state.list[0]", "state.list[1]"} <= set(recording.names)
    assert np.isnan(recording["state.b"].values[1])
    assert recording["state.b"].values[500] == 1000.0
    assert "state.late" not in recording.names
    assert any("fields of /state that came only later were left out: late" in each for each in recording.warnings)


def test_recordings_beside_the_data_of_a_ros_2_bag_are_named(tmp_path):
    folder = ros_bag(tmp_path / "bag", False)
    assert not any("beside" in each for each in read(folder).warnings)
    (folder / "other.bag").write_bytes(b"#ROSBAG V2.0\n")
    assert any("other.bag beside it was not read" in each for each in read(folder).warnings)
