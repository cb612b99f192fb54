"""The unit of the time: respected where it is given, refused where it is in doubt, never converted in silence."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io

from tierod.core.errors import InputError
from tierod.io.readers import open_chunks, parse_channel_map, read
from tierod.io.readers.clocks import require_plausible_rate

PER_SECOND = {"ms": 1e3, "us": 1e6, "ns": 1e9}
FORMATS = ("csv", "parquet", "mat")


def saved(folder, kind, columns):
    path = folder / f"drive.{kind}"
    if kind == "csv":
        rows = zip(*(np.asarray(values).tolist() for values in columns.values()), strict=True)
        path.write_text("\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n")
    elif kind == "parquet":
        pq.write_table(pa.table(columns), path)
    else:
        scipy.io.savemat(path, columns)
    return path


def drive(unit, rate=100.0, begin=0.0, count=200):
    return {
        "timestamp": (begin + np.arange(count) * PER_SECOND.get(unit, 1.0) / rate).astype(np.int64),
        "yaw_rate": np.sin(np.arange(count)),
    }


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("unit", PER_SECOND)
@pytest.mark.parametrize("begin", [0.0, 3600.0, 5e4])
def test_stamps_that_count_in_another_unit_are_refused_with_the_unit_to_give(tmp_path, kind, unit, begin):
    path = saved(tmp_path, kind, drive(unit, begin=begin * PER_SECOND[unit]))
    with pytest.raises(InputError, match=rf"'timestamp' has no unit; .* 100 Hz in {unit}: .*unit = \"{unit}\" .*--map"):
        read(path)
    with pytest.raises(InputError, match="has no unit"):
        next(iter(open_chunks(path)))


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("unit", PER_SECOND)
def test_the_unit_of_the_channel_map_is_respected(tmp_path, kind, unit):
    path = saved(tmp_path, kind, drive(unit))
    mapped = parse_channel_map({"time": {"column": "timestamp", "unit": unit}})
    assert read(path, channel_map=mapped)["yaw_rate"].time == pytest.approx(0.01 * np.arange(200))
    pieces = [piece["yaw_rate"].time for piece in open_chunks(path, channel_map=mapped, seconds=0.5)]
    assert np.concatenate(pieces) == pytest.approx(0.01 * np.arange(200))


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_the_unit_of_a_title_is_respected(tmp_path, kind):
    columns = drive("ms")
    path = saved(tmp_path, kind, {"timestamp [ms]": columns["timestamp"], "yaw_rate": columns["yaw_rate"]})
    assert read(path)["yaw_rate"].time == pytest.approx(0.01 * np.arange(200))


@pytest.mark.parametrize("kind", FORMATS)
def test_a_slow_recording_is_read_where_its_unit_is_given(tmp_path, kind):
    path = saved(tmp_path, kind, drive("s", rate=0.1))
    with pytest.raises(InputError, match="in s its samples come at 0.1 Hz, but at 100 Hz in ms"):
        read(path)
    assert read(path, channel_map=parse_channel_map({"time": {"unit": "s"}}))["yaw_rate"].time[-1] == 1990.0


@pytest.mark.parametrize("kind", FORMATS)
def test_the_map_chooses_among_several_time_columns(tmp_path, kind):
    columns = {"time": np.arange(200) * 0.02, "stamp": np.arange(200) * 10, "yaw_rate": np.sin(np.arange(200))}
    path = saved(tmp_path, kind, columns)
    assert read(path)["yaw_rate"].time[-1] == pytest.approx(3.98)
    mapped = parse_channel_map({"time": {"column": "stamp", "unit": "ms"}})
    assert read(path, channel_map=mapped)["yaw_rate"].time[-1] == pytest.approx(1.99)
    with pytest.raises(InputError, match="names the time.* 'stomp', but no"):
        read(path, channel_map=parse_channel_map({"time": {"column": "stomp"}}))


@pytest.mark.parametrize("begin", [1.7e12, 1.7e15, 1.7e18])
def test_stamps_of_a_calendar_are_recognised_by_their_magnitude(tmp_path, begin):
    unit = {1.7e12: "ms", 1.7e15: "us", 1.7e18: "ns"}[begin]
    recording = read(saved(tmp_path, "parquet", drive(unit, begin=begin)))
    assert recording["yaw_rate"].time[-1] == pytest.approx(1.99, abs=1e-6)
    assert f"taken as {unit} since 1970" in recording["yaw_rate"].note


@pytest.mark.parametrize(("begin", "unit"), [(5e13, "ns"), (2e14, "ns"), (2e11, "us")])
def test_a_clock_that_counts_since_the_start_of_a_computer_is_no_calendar(tmp_path, begin, unit):
    with pytest.raises(InputError, match=f"100 Hz in {unit}"):
        read(saved(tmp_path, "csv", drive(unit, begin=begin)))


def test_a_file_that_tierod_wrote_needs_no_map(tmp_path):
    from tierod.core.recording import Channel, Recording
    from tierod.io.writers import write

    slow = Recording({"yaw_rate": Channel("yaw_rate", 10.0 * np.arange(50), np.arange(50.0) % 3, "rad/s")})
    mapped = parse_channel_map({"time": {"column": "stamp", "unit": "ms"}})
    for ending in ("csv", "parquet"):
        write(slow, tmp_path / f"a.{ending}")
        assert read(tmp_path / f"a.{ending}", channel_map=mapped)["yaw_rate"].time[-1] == 490.0


def test_a_slow_clock_beside_a_fast_one_is_in_no_doubt():
    slow, fast = 10.0 * np.arange(50), 0.01 * np.arange(50)
    require_plausible_rate([("time", "", slow), ("time.2", "", fast)])
    with pytest.raises(InputError, match=r"'time' has no unit.* 100 Hz in ms"):
        require_plausible_rate([("time", "", slow), ("time.2", "", 2.0 * slow)])


@pytest.mark.parametrize("stamps", [[], [0.0, 10.0, 20.0], np.full(50, np.nan), 1e12 * np.arange(50)])
def test_stamps_that_say_nothing_are_in_no_doubt(stamps):
    require_plausible_rate([("time", "", np.asarray(stamps))])


@pytest.mark.parametrize(
    ("time", "words"),
    [
        ({"unit": "deg"}, r"\[time\] .*'deg' cannot become 's'"),
        ({"unit": "parsnips"}, r"\[time\] the unit 'parsnips' is not known"),
        ({"clock": "t"}, r"\[time\] the key 'clock' is not known"),
        ({"unit": 3}, r"\[time\] must be a table"),
        ("ms", r"\[time\] must be a table"),
        ({}, r"\[time\] must be a table"),
    ],
)
def test_slips_in_the_entry_of_the_time(time, words):
    with pytest.raises(InputError, match=words):
        parse_channel_map({"time": time})


@pytest.mark.parametrize(
    ("begin", "step", "sentence"),
    [(20240513090500.0, 0.05, "a date as digits"), (45413.4, 0.05 / 86400, "days as spreadsheets count them")],
)
def test_dates_as_one_number_are_no_seconds(tmp_path, begin, step, sentence):
    path = saved(tmp_path, "csv", {"time": begin + step * np.arange(200), "yaw_rate": np.ones(200)})
    with pytest.raises(InputError, match=f"{sentence}.*; give seconds, or dates that read"):
        read(path)


def test_seconds_that_could_be_digits_of_a_day_for_a_while_are_seconds(tmp_path):
    time = 12000.0 + np.arange(0.0, 150.0, 0.02)
    recording = read(saved(tmp_path, "csv", {"time": time, "yaw_rate": np.sin(time)}))
    assert recording["yaw_rate"].time[-1] - recording["yaw_rate"].time[0] == pytest.approx(149.98, abs=1e-3)
