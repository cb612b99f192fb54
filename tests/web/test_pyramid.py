"""Signals in levels: extremes stay at any zoom, and every sample is there at the finest one."""

from itertools import pairwise

import numpy as np
import pytest

from live_drives import drive
from tierod.core.recording import Channel, Recording
from tierod.io.derive import complete
from tierod.web.analysing import Derived
from tierod.web.errors import Absent
from tierod.web.series import SeriesReader, SeriesWriter


def kept(folder, channels, cuts=(0, None)):
    folder.mkdir(exist_ok=True)
    writer = SeriesWriter(folder)
    for first, last in pairwise(cuts):
        parts, stamps = [], {}
        for each in channels:
            time = stamps.setdefault(id(each.time), each.time[first:last])
            parts.append(Channel(each.name, time, each.values[first:last], each.unit))
        writer.add(parts)
    writer.finish({"path": "x"})
    return SeriesReader(folder)


@pytest.fixture
def noise():
    chance = np.random.default_rng(1)
    values = chance.normal(size=100_000).cumsum()
    values[20_000:21_000] = np.nan
    return Channel("a", np.arange(100_000) / 100.0, values, "N*m")


def test_every_sample_comes_back(tmp_path, noise):
    reader = kept(tmp_path / "s", [noise], (0, 33_333, 70_000, None))
    time, values = reader.samples("a")
    np.testing.assert_array_equal(time, noise.time)
    np.testing.assert_array_equal(values, noise.values)


@pytest.mark.parametrize(("start", "stop"), [(0.0, 1000.0), (3.0, 700.0), (195.0, 230.0), (500.0, 501.0)])
def test_a_picture_holds_lowest_and_highest(tmp_path, noise, start, stop):
    reader = kept(tmp_path / "s", [noise])
    found = reader.window("a", start, stop, 200)
    inside = noise.values[(noise.time >= start) & (noise.time <= stop)]
    assert np.nanmin(found.lower) <= np.nanmin(inside) + 1e-4
    assert np.nanmax(found.upper) >= np.nanmax(inside) - 1e-4
    assert (
        np.nanmin(found.lower) >= np.nanmin(noise.values[(noise.time >= start - 8) & (noise.time <= stop + 8)]) - 1e-4
    )
    assert len(found.time) <= 2 * 200 + 2
    assert found.exact == (stop - start <= 4.0)


def test_bins_follow_their_samples(tmp_path, noise):
    found = kept(tmp_path / "s", [noise]).window("a", 0.0, 999.99, 100)
    for at in range(0, len(found.time) - 1, 7):
        inside = (noise.time >= found.time[at]) & (noise.time < found.time[at + 1])
        part = noise.values[inside]
        if np.isnan(part).all():
            assert np.isnan(found.lower[at])
        else:
            assert found.lower[at] == pytest.approx(np.nanmin(part), rel=1e-6)
            assert found.upper[at] == pytest.approx(np.nanmax(part), rel=1e-6)


def test_a_stretch_shows_a_sample_before_and_behind_it(tmp_path, noise):
    found = kept(tmp_path / "s", [noise]).window("a", 10.001, 10.029, 100)
    np.testing.assert_allclose(found.time, [10.0, 10.01, 10.02, 10.03])


def test_signals_with_common_stamps_share_them_until_they_part(tmp_path):
    folder = tmp_path / "s"
    folder.mkdir()
    writer, first, second = SeriesWriter(folder), np.arange(5.0), np.arange(5.0, 10.0)
    writer.add([Channel("a", first, first, "s"), Channel("b", first, -first, "s")])
    assert writer.signals["a"].stamps == writer.signals["b"].stamps
    writer.add([Channel("a", second, second, "s"), Channel("b", second + 0.5, -second, "s")])
    writer.finish({})
    reader = SeriesReader(folder)
    np.testing.assert_array_equal(reader.samples("a")[0], np.arange(10.0))
    np.testing.assert_array_equal(reader.samples("b")[0], [*first, *(second + 0.5)])
    assert reader.span == (0.0, 9.5)


def test_a_signal_that_pauses_keeps_its_own_stamps(tmp_path):
    folder = tmp_path / "s"
    folder.mkdir()
    writer, first, second = SeriesWriter(folder), np.arange(5.0), np.arange(5.0, 10.0)
    writer.add([Channel("a", first, first, "s"), Channel("b", first, -first, "s")])
    writer.add([Channel("a", second, second, "s")])
    writer.add([Channel("b", second + 9.0, second, "s"), Channel("late", second + 9.0, second, "s")])
    writer.finish({})
    reader = SeriesReader(folder)
    np.testing.assert_array_equal(reader.samples("a")[0], np.arange(10.0))
    np.testing.assert_array_equal(reader.samples("b")[0], [*first, *(second + 9.0)])
    np.testing.assert_array_equal(reader.samples("late")[0], second + 9.0)


def test_what_is_gone_is_said_in_a_sentence(tmp_path, noise):
    reader = kept(tmp_path / "s", [noise])
    with pytest.raises(Absent, match="no signal 'b'"):
        reader.window("b", 0.0, 1.0, 10)
    for path in (tmp_path / "s").iterdir():
        path.unlink()
    with pytest.raises(Absent, match="open it again"):
        reader.window("a", 0.0, 1.0, 10)
    with pytest.raises(Absent, match="open it again"):
        SeriesReader(tmp_path / "s")


def test_derived_signals_are_the_same_in_slices_and_end_where_a_signal_is_recorded():
    whole = drive(9.0)
    whole = Recording({name: whole[name] for name in ("steering_wheel_angle", "yaw_rate")})
    derived, found = Derived(), []
    for start in (0.0, 3.0, 6.0):
        made, recorded = derived.of(whole.slice(start, start + 3.0))
        assert (len(made), recorded) == (1, [])
        found.append(made[0])
    expected = complete(whole)["steering_wheel_rate"]
    np.testing.assert_array_equal(np.concatenate([each.time for each in found]), expected.time)
    np.testing.assert_allclose(np.concatenate([each.values for each in found]), expected.values, rtol=1e-9)
    assert found[0].note == expected.note
    late = drive(12.0).slice(9.0, 12.0)
    made, recorded = derived.of(
        Recording({name: late[name] for name in ("steering_wheel_angle", "steering_wheel_rate")})
    )
    assert (made, recorded) == ([], ["steering_wheel_rate"])
