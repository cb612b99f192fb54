"""Names lead to files that are served, and to no others."""

import os
from itertools import pairwise

import numpy as np
import pytest

from live_drives import drive
from tierod.core.recording import Channel, Recording
from tierod.io.derive import complete
from tierod.web.analysing import Derived
from tierod.web.errors import Absent
from tierod.web.series import SeriesReader, SeriesWriter
from tierod.web.site import Site, listing, roots_of
from tierod.web.store import Store, stamp_of


@pytest.fixture
def tree(tmp_path):
    drives, secret = tmp_path / "drives", tmp_path / "secret"
    (drives / "in").mkdir(parents=True)
    secret.mkdir()
    (drives / "in" / "a.csv").write_text("time,a\n0,1\n")
    (drives / ".hidden.csv").write_text("x")
    (secret / "key").write_text("secret")
    (drives / "out").symlink_to(secret)
    (drives / "key").symlink_to(secret / "key")
    (drives / "inside").symlink_to(drives / "in" / "a.csv")
    (drives / "loop").symlink_to(drives / "loop")
    os.mkfifo(drives / "pipe")
    return drives


@pytest.fixture
def site(tree, tmp_path):
    recordings, results = roots_of([tree])
    return Site(recordings, results, tmp_path / "cache")


OUTSIDE = [
    "", ".", "..", "/", "/etc/passwd", "drives/../secret/key", "drives/out/key", "drives/key", "drives//etc/passwd",
    "drives/in/../../secret/key", "drives\\..\\secret", "drives/in/a.csv\0.txt", "drives/pipe", "drives/loop",
    "other/a", "drives/" + "a/" * 3000, "drives/" + "x" * 5000, "~", "drives/~root", "drives/in/a.csv/..",
    "file:///etc/passwd",
    "drives/%2e%2e/secret/key", "drives/in/b.csv", "\ud800", "drives/\ud800",
    "/\ud800", "/\0", "/" + "x" * 5000,
]  # fmt: skip


@pytest.mark.parametrize("name", OUTSIDE)
def test_no_name_leads_outside(site, name):
    with pytest.raises(Absent):
        site.file(name)


def test_names_lead_to_files_and_back(site, tree):
    assert site.file("drives/in/a.csv") == tree / "in" / "a.csv"
    assert site.file("drives/inside") == tree / "in" / "a.csv"
    assert site.name_of(tree / "in" / "a.csv") == "drives/in/a.csv"
    assert site.name_of(tree.parent / "secret" / "key") == ""
    with pytest.raises(Absent, match="not a folder"):
        site.folder("drives/in/a.csv")
    with pytest.raises(Absent, match="here its name is 'drives/in/a.csv'"):
        site.file(str(tree / "in" / "a.csv"))
    with pytest.raises(Absent, match="there is no"):
        site.file(str(tree / "out" / "key"))


def test_one_file_is_served_alone(tree, tmp_path):
    (tree / "in" / "b.csv").write_text("b")
    recordings, _ = roots_of([tree / "in" / "a.csv"])
    site = Site(recordings, (), tmp_path)
    assert site.file("in/a.csv").name == "a.csv"
    with pytest.raises(Absent):
        site.file("in/b.csv")
    assert [each.name for each in listing(site, "in").entries] == ["a.csv"]


def test_a_list_shows_names_and_hides_what_leads_outside(site):
    assert [each.name for each in listing(site, "").entries] == ["drives"]
    assert [each.name for each in listing(site, "drives").entries] == ["in", "inside"]
    found = listing(site, "", search="A.C")
    assert [each.file for each in found.entries] == ["drives/in/a.csv"]
    assert found.complete


def test_the_list_is_sorted_and_cut(tmp_path):
    folder = tmp_path / "many"
    folder.mkdir()
    for number in range(30):
        (folder / f"{number:02}.csv").write_text("x" * number)
    site = Site(roots_of([folder])[0], (), tmp_path)
    assert [each.name for each in listing(site, "many", sort="bytes", count=2).entries] == ["29.csv", "28.csv"]
    assert [each.name for each in listing(site, "many", offset=28).entries] == ["28.csv", "29.csv"]
    assert listing(site, "many", count=1).total == 30


def test_the_store_keeps_whole_results_and_forgets_the_oldest(tmp_path):
    store, keys = Store(tmp_path / "cache"), ["a" * 64, "b" * 64]
    for age, key in enumerate(keys):
        folder = store.begun("series")
        (folder / "t0.f8").write_bytes(b"x" * 1000)
        path = store.settled(folder, "series", key)
        os.utime(path, (age, age))
    assert not list((tmp_path / "cache" / "series").glob(".new-*"))
    store.sweep(1500)
    assert not store.path("series", keys[0]).exists()
    assert store.holds("series", keys[1])
    for wrong in ("", "../" * 20, "a" * 63, "A" * 64, "a" * 64 + "/.."):
        with pytest.raises(Absent):
            store.path("series", wrong)


def test_a_file_is_known_until_it_changes(tmp_path):
    store, path = Store(tmp_path / "cache"), tmp_path / "a.csv"
    path.write_text("1")
    store.remember(stamp_of(path), {"series": "s"})
    assert Store(tmp_path / "cache").known(stamp_of(path))["series"] == "s"
    path.write_text("12")
    assert store.known(stamp_of(path)) == {}
    path.unlink()
    with pytest.raises(Absent, match="gone"):
        stamp_of(path)


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


def test_a_stretch_shows_a_sample_before_and_behind_it(tmp_path, noise):
    found = kept(tmp_path / "s", [noise]).window("a", 10.001, 10.029, 100)
    np.testing.assert_allclose(found.time, [10.0, 10.01, 10.02, 10.03])


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
