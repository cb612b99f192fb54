"""Parquet of others: calendar time, integers, nulls, units in the metadata of a field, damage."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tierod.errors import InputError
from tierod.readers import open_chunks, read


def saved(tmp_path, table, **options):
    path = tmp_path / "drive.parquet"
    pq.write_table(table, path, **options)
    return path


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_calendar_time(tmp_path, unit):
    per = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    stamps = pa.array([1_700_000_000 * per + k * per for k in range(5)], pa.timestamp(unit))
    recording = read(saved(tmp_path, pa.table({"timestamp": stamps, "yaw_rate": np.arange(5.0)})))
    assert recording["yaw_rate"].time.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert recording.metadata["origin"] == 1.7e9


def test_integers_truth_values_nulls_and_text(tmp_path):
    columns = {
        "time_ms": pa.array([0, 10, 20], pa.int32()),
        "speed_km_h": pa.array([36, None, 72], pa.int16()),
        "lane_keeping_active": pa.array([True, False, None]),
        "driver": ["a", "b", "c"],
    }
    recording = read(saved(tmp_path, pa.table(columns)))
    assert recording["vehicle_speed"].values == pytest.approx([10.0, np.nan, 20.0], nan_ok=True)
    assert recording["vehicle_speed"].time.tolist() == [0.0, 0.01, 0.02]
    assert recording["lane_keeping_active"].values == pytest.approx([1.0, 0.0, np.nan], nan_ok=True)
    assert "driver" not in recording


def test_a_unit_in_the_metadata_of_a_field(tmp_path):
    fields = [pa.field("time", pa.float64()), pa.field("yaw_rate", pa.float64(), metadata={"unit": "deg/s"})]
    table = pa.table([pa.array([0.0, 1.0]), pa.array([180.0, 0.0])], schema=pa.schema(fields))
    assert read(saved(tmp_path, table))["yaw_rate"].values[0] == pytest.approx(np.pi)


def test_a_missing_stamp_drops_its_sample(tmp_path):
    table = pa.table({"time": pa.array([0.0, None, 2.0]), "yaw_rate": [1.0, 2.0, 3.0]})
    assert read(saved(tmp_path, table))["yaw_rate"].values.tolist() == [1.0, 3.0]


def test_one_large_row_group_is_read_batch_by_batch(tmp_path):
    time = np.arange(0.0, 4000.0, 0.01)
    path = saved(tmp_path, pa.table({"time": time + 1.7e9, "yaw_rate": time}))
    slices = list(open_chunks(path, seconds=1000.0))
    assert [len(part["yaw_rate"].time) for part in slices] == pytest.approx([100_000] * 4, abs=1)
    assert np.array_equal(np.concatenate([part["yaw_rate"].values for part in slices]), time)
    assert {part.metadata["origin"] for part in slices} == {1.7e9}


def test_time_that_jumps_back_between_row_groups(tmp_path):
    time = np.concatenate((np.arange(0.0, 100.0), np.arange(0.0, 100.0)))
    path = saved(tmp_path, pa.table({"time": time, "yaw_rate": time}), row_group_size=100)
    for reading in (lambda: read(path), lambda: list(open_chunks(path, seconds=50.0))):
        with pytest.raises(InputError, match="jumps back from 99"):
            reading()


def test_damage_in_the_middle(tmp_path):
    noise = np.random.default_rng(0).normal(size=100_000)
    path = saved(tmp_path, pa.table({"time": np.arange(1e5), "yaw_rate": noise}))
    content = bytearray(path.read_bytes())
    content[2000:60000] = bytes(58000)
    path.write_bytes(content)
    for reading in (lambda: read(path), lambda: list(open_chunks(path))):
        with pytest.raises(InputError, match="is damaged"):
            reading()


def test_no_rows(tmp_path):
    with pytest.raises(InputError, match="holds columns but no samples"):
        read(saved(tmp_path, pa.table({"time": pa.array([], pa.float64()), "yaw_rate": pa.array([], pa.float64())})))
