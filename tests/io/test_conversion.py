"""Round trips between the formats, several files of one drive, and what a format cannot hold."""

from dataclasses import replace

import numpy as np
import pytest

from foreign_files import COUNT, START, TIME, YAW, mcap_file
from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.io.conversion import convert
from tierod.io.readers import read
from tierod.io.writers import write

SLOW = np.arange(0.05, 3.0, 0.1)


def drive():
    values = YAW.copy()
    values[7] = np.nan
    channels = [
        Channel("yaw_rate", TIME, values, "rad/s", "ESP.Yaw", "sign turned"),
        Channel("lateral_acceleration", TIME, 0.1 + YAW / 3.0, "m/s**2"),
        Channel("vehicle_speed", SLOW, 15.0 + SLOW / 7.0, "m/s"),
    ]
    return Recording({each.name: each for each in channels}, {"origin": float(START), "title": "a weave"})


@pytest.mark.parametrize("ending", ["mf4", "mcap", "parquet", "csv"])
def test_values_units_stamps_and_notes_come_back(tmp_path, ending):
    write(drive(), tmp_path / "in.parquet")
    convert([tmp_path / "in.parquet"], tmp_path / f"out.{ending}")
    again = read(tmp_path / f"out.{ending}")
    for name, channel in drive().channels.items():
        np.testing.assert_array_equal(again[name].values, channel.values)
        np.testing.assert_allclose(again[name].time, channel.time, rtol=0, atol=0 if ending != "mcap" else 5e-10)
        assert (again[name].unit, again[name].source or name) == (channel.unit, channel.source or name)
    assert again["yaw_rate"].note.startswith("sign turned")
    assert again.metadata["origin"] == START
    assert again.metadata["title"] == "a weave"


def test_matlab_holds_values_stamps_and_units(tmp_path):
    from scipy.io import loadmat

    write(drive(), tmp_path / "in.parquet")
    done = convert([tmp_path / "in.parquet"], tmp_path / "out.mat")
    assert any("but no sources" in sentence for sentence in done.lost)
    other = loadmat(tmp_path / "out.mat", squeeze_me=True, struct_as_record=False)
    np.testing.assert_array_equal(other["group1"].time, TIME)
    np.testing.assert_array_equal(other["group2"].vehicle_speed, 15.0 + SLOW / 7.0)
    assert other["units"].yaw_rate == "rad/s"
    again = read(tmp_path / "out.mat")
    np.testing.assert_array_equal(again["yaw_rate"].values, drive()["yaw_rate"].values)
    assert again["yaw_rate"].unit == "rad/s"
    assert "unit not given" not in again["yaw_rate"].note


def test_one_clock_gives_plain_vectors(tmp_path):
    from scipy.io import loadmat

    whole = Recording({"odd name": Channel("odd name", TIME, YAW, "V")})
    write(whole, tmp_path / "out.mat")
    other = loadmat(tmp_path / "out.mat", squeeze_me=True)
    np.testing.assert_array_equal(other["odd_name"], YAW)


def test_names_and_units_stay_as_recorded_unless_asked(tmp_path):
    table = Recording({"Speed": Channel("Speed", TIME, YAW + 50.0, "km/h")})
    write(table, tmp_path / "in.csv")
    convert([tmp_path / "in.csv"], tmp_path / "out.parquet")
    import pyarrow.parquet as pq

    assert pq.read_schema(tmp_path / "out.parquet").names == ["time", "Speed"]
    convert([tmp_path / "in.csv"], tmp_path / "si.parquet", canonical=True)
    assert pq.read_schema(tmp_path / "si.parquet").names == ["time", "vehicle_speed"]


def test_parts_of_one_drive_are_joined_by_their_calendar_time(tmp_path):
    whole = drive()
    for number, (first, last) in enumerate([(1.2, 3.1), (0.0, 1.2)]):
        part = whole.slice(first, last)
        moved = {name: replace(each, time=each.time - first) for name, each in part.channels.items()}
        write(Recording(moved, {"origin": START + first}), tmp_path / f"part{number}.mf4")
    convert([tmp_path / "part0.mf4", tmp_path / "part1.mf4"], tmp_path / "whole.parquet")
    again = read(tmp_path / "whole.parquet")
    np.testing.assert_array_equal(again["yaw_rate"].values, whole["yaw_rate"].values)
    np.testing.assert_allclose(again["yaw_rate"].time, TIME, atol=1e-6)
    joined = read(tmp_path)  # a folder with parts of one drive is a recording too
    assert len(joined["yaw_rate"].time) == COUNT


def test_parts_that_overlap_are_refused(tmp_path):
    for name in ("a", "b"):
        write(drive(), tmp_path / f"{name}.parquet")
    with pytest.raises(InputError, match="begins before the part ahead of it ends"):
        convert([tmp_path / "a.parquet", tmp_path / "b.parquet"], tmp_path / "out.csv")
    assert not (tmp_path / "out.csv").exists()


def test_parts_without_a_common_time_are_refused(tmp_path):
    mcap_file(tmp_path / "a.mcap")
    write(Recording({"yaw_rate": Channel("yaw_rate", TIME, YAW, "rad/s")}), tmp_path / "b.csv")
    with pytest.raises(InputError, match="not timed alike"):
        convert([tmp_path / "a.mcap", tmp_path / "b.csv"], tmp_path / "out.csv")


def test_a_recording_that_begins_late_does_so_in_mcap(tmp_path):
    time = 149.0 + np.arange(5) / 100.0
    write(Recording({"yaw_rate": Channel("yaw_rate", time, np.ones(5), "rad/s")}), tmp_path / "late.mcap")
    again = read(tmp_path / "late.mcap")
    np.testing.assert_allclose(again["yaw_rate"].time, time, rtol=0, atol=5e-10)
    assert again.metadata.get("origin", 0.0) == 0.0


def test_text_columns_and_samples_put_in_order_are_said(tmp_path):
    rows = [f"{0.01 * place:.2f},{place % 7},auto,{place}" for place in range(200)]
    rows[50], rows[52] = rows[52], rows[50]
    (tmp_path / "in.csv").write_text("\n".join(["time [s],speed [m/s],gear,count", *rows]))
    done = convert([tmp_path / "in.csv"], tmp_path / "out.mf4")
    assert any("hold text: gear" in each for each in done.warnings), done.warnings
    assert any("order" in each and "(2 channels)" in each for each in done.warnings), done.warnings


def test_text_in_messages_and_tables_is_said(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table({"time": pa.array(TIME), "yaw_rate": pa.array(YAW), "driver": pa.array(["x"] * len(TIME))})
    pq.write_table(table, tmp_path / "in.parquet")
    for path, name in ((tmp_path / "in.parquet", "driver"), (mcap_file(tmp_path / "in.mcap"), "state.name")):
        done = convert([path], tmp_path / f"{path.suffix[1:]}.csv")
        assert any(each == f"not converted, since they hold text: {name}" for each in done.warnings), done.warnings
