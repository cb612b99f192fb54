"""Parquet of others: calendar time, integers, nulls, units in the metadata of a field, damage."""

from datetime import time
from decimal import Decimal

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.io.readers import open_chunks, read, tables
from tierod.io.writers import write


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


@pytest.mark.parametrize("kind", [pa.decimal128(12, 3), pa.decimal256(50, 3)])
def test_decimals(tmp_path, kind):
    numbers = [Decimal("0.125"), None, Decimal("-2.5")]
    columns = {"time": pa.array(map(Decimal, ("0", "0.25", "0.5")), kind), "yaw_rate": pa.array(numbers, kind)}
    recording = read(saved(tmp_path, pa.table(columns)))
    assert recording["yaw_rate"].values == pytest.approx([0.125, np.nan, -2.5], nan_ok=True)
    assert recording["yaw_rate"].time.tolist() == [0.0, 0.25, 0.5]


@pytest.mark.parametrize("other", ["yaw_rate", "lap_time"])
@pytest.mark.parametrize(
    ("stamps", "kind"), [(["2024-05-29 13:53:59", "2024-05-29 13:54:00"], "string"), ([time(1), time(2)], "time64.us.")]
)
def test_a_time_column_that_holds_no_time_stamps(tmp_path, other, stamps, kind):
    path = saved(tmp_path, pa.table({"time": stamps, other: [1.0, 2.0]}))
    with pytest.raises(InputError, match=f"drive.parquet: the time column 'time' holds values of type {kind}; write"):
        read(path)


def test_text_beside_a_time_does_no_harm(tmp_path):
    table = pa.table({"date": ["29.05.2024"] * 2, "time zone": ["UTC"] * 2, "lap_time": [0.0, 1.0], "yaw_rate": [1, 2]})
    assert read(saved(tmp_path, table)).names == ("yaw_rate",)


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


@pytest.mark.parametrize("lie", [0, -3000, 3000])
def test_padding_of_a_slow_clock_is_not_unpacked_and_statistics_are_not_trusted_alone(tmp_path, monkeypatch, lie):
    fast, slow = np.arange(120_000) / 1000.0, np.arange(12_000) / 100.0
    channels = {"motor_angle": Channel("motor_angle", fast, np.sin(fast), "rad"),
                "yaw_rate": Channel("yaw_rate", slow, np.cos(slow), "rad/s")}  # fmt: skip
    write(Recording(channels), tmp_path / "drive.parquet")
    file = pq.ParquetFile(tmp_path / "drive.parquet")
    true = tables._padding(file, "time.2")
    assert true == [54_000, 54_000]
    monkeypatch.setattr(tables, "_padding", lambda file, clock: [each + lie for each in true] if "2" in clock else [0])
    batches = tables._batches(tmp_path / "drive.parquet", file, ["time.2", "yaw_rate"], 1 << 17)
    unpacked = sum(batch.num_rows for batch, _ in batches)
    assert unpacked == (12_002 if lie == 0 else 120_000)
    assert np.array_equal(read(tmp_path / "drive.parquet")["yaw_rate"].values, np.cos(slow))


def test_damage_in_the_middle(tmp_path):
    noise = np.random.default_rng(0).normal(size=100_000)
    path = saved(tmp_path, pa.table({"time": np.arange(1e5), "yaw_rate": noise}))
    content = bytearray(path.read_bytes())
    content[2000:60000] = bytes(58000)
    path.write_bytes(content)
    for reading in (lambda: read(path), lambda: list(open_chunks(path))):
        with pytest.raises(InputError, match="is damaged"):
            reading()


def test_a_few_bytes_that_changed_are_found_in_a_file_of_ours(tmp_path):
    time, noise = np.arange(0.0, 300.0, 0.01), np.random.default_rng(1).normal(size=30_000)
    path = tmp_path / "drive.parquet"
    write(Recording({"yaw_rate": Channel("yaw_rate", time, noise, "rad/s")}), path)
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 400] = bytes(400)
    path.write_bytes(content)
    with pytest.raises(InputError, match="is damaged"):
        read(path)


@pytest.mark.parametrize("columns", [{"a": ["x", "y"], "b": ["k", "l"]}, {"time": [0.0, 0.01], "a": ["x", "y"]}])
def test_a_file_of_text_is_refused(tmp_path, columns):
    path = saved(tmp_path, pa.table({name: values * 400 for name, values in columns.items()}))
    with pytest.raises(InputError, match="no columns? (of|holds) numbers"):
        read(path, names=("yaw_rate",))


def test_no_rows(tmp_path):
    with pytest.raises(InputError, match="holds columns but no samples"):
        read(saved(tmp_path, pa.table({"time": pa.array([], pa.float64()), "yaw_rate": pa.array([], pa.float64())})))


@pytest.mark.parametrize(("unit", "per"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_dates_as_large_integers_are_distinguished_from_seconds(tmp_path, unit, per):
    time = 0.25 * np.arange(5)
    table = pa.table({"timestamp": ((1.7e9 + time) * per).astype(np.int64), "yaw_rate": np.arange(5.0)})
    recording = read(saved(tmp_path, table))
    assert recording["yaw_rate"].time == pytest.approx(time, abs=1e-6)
    assert recording.metadata["origin"] == pytest.approx(1.7e9)
    assert f"time stamps taken as {unit} since 1970" in recording["yaw_rate"].note


def test_large_stamps_with_a_unit_are_accepted(tmp_path):
    table = pa.table({"time_s": 1.0e12 + np.arange(5.0), "yaw_rate": np.arange(5.0)})
    assert read(saved(tmp_path, table)).span == (0.0, 4.0)


@pytest.fixture
def ours(tmp_path):
    """A table as tierod writes it, with two clocks or one."""

    def table(clocks=2):
        times = [np.arange(6.0), np.arange(0.0, 6.0, 2.0)][:clocks]
        names = ("yaw_rate", "driver_torque")
        channels = [Channel(name, time, 0.1 * time, "count") for name, time in zip(names, times, strict=False)]
        write(Recording({channel.name: channel for channel in channels}), tmp_path / "ours.parquet")
        return pq.read_table(tmp_path / "ours.parquet")

    return table


def test_a_column_that_was_added_to_our_own_file_is_read(tmp_path, ours):
    table = ours(1).append_column("lateral_acceleration", pa.array(np.arange(6.0)))
    assert read(saved(tmp_path, table))["lateral_acceleration"].values.tolist() == list(range(6))


def test_a_column_without_a_clock_is_reported(tmp_path, ours):
    recording = read(saved(tmp_path, ours().append_column("lateral_acceleration", pa.array(np.arange(6.0)))))
    assert recording.names == ("yaw_rate", "driver_torque")
    assert any("'lateral_acceleration' added to a file" in warning for warning in recording.warnings)


@pytest.mark.parametrize(
    "layout", [b"no JSON", b"[]", b'{"layout": 2}', b'{"layout": 1, "clocks": [{"time": "gone"}]}']
)
def test_a_layout_that_does_not_fit_is_left_aside(tmp_path, ours, layout):
    recording = read(saved(tmp_path, ours().replace_schema_metadata({b"tierod": layout})))
    assert set(recording.names) == {"yaw_rate", "driver_torque"}


def test_our_own_file_without_its_clock(tmp_path, ours):
    with pytest.raises(InputError, match="there is no time column"):
        read(saved(tmp_path, ours().select(["yaw_rate", "driver_torque"])))
