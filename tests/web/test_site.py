"""Names lead to files that are served, and to no others."""

import os

import pytest

from tierod.core.errors import InputError
from tierod.web.errors import Absent
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


def test_folders_of_one_name_get_names_of_their_own(tmp_path):
    for name in ("a/x", "b/x", "c/x/ledger"):
        (tmp_path / name).mkdir(parents=True)
    recordings, results = roots_of([tmp_path / "a/x", tmp_path / "b/x", tmp_path / "c/x"])
    assert [each.name for each in recordings] == ["x", "x-2"]
    assert [each.name for each in results] == ["x-3"]
    with pytest.raises(InputError, match="there is no"):
        roots_of([tmp_path / "nowhere"])


def test_a_list_shows_names_and_hides_what_leads_outside(site):
    assert [each.name for each in listing(site, "").entries] == ["drives"]
    assert [each.name for each in listing(site, "drives").entries] == ["in", "inside"]
    found = listing(site, "", search="A.C")
    assert [each.file for each in found.entries] == ["drives/in/a.csv"]
    assert found.complete


def test_a_link_to_a_folder_above_is_searched_once(site, tree):
    (tree / "in" / "again").symlink_to(tree / "in")
    assert [each.name for each in listing(site, "", search="a.csv").entries] == ["a.csv"]


def test_a_folder_that_vanished_is_a_sentence(site, tree):
    (tree / "in" / "a.csv").unlink()
    (tree / "in").rmdir()
    with pytest.raises(Absent):
        listing(site, "drives/in")


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


def test_what_a_killed_process_left_is_swept(tmp_path):
    store = Store(tmp_path / "cache")
    left = tmp_path / "cache" / "series" / ".new-999999999-abc"
    left.mkdir()
    mine = store.begun("series")
    store.sweep(1 << 30)
    assert not left.exists()
    assert mine.exists()


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


def test_a_served_folder_that_vanished_is_named_and_not_listed(tmp_path):
    for name in ("here", "gone"):
        (tmp_path / name).mkdir()
    site = Site(roots_of([tmp_path / "here", tmp_path / "gone"])[0], (), tmp_path)
    assert listing(site, "").gone == []
    (tmp_path / "gone").rmdir()
    found = listing(site, "")
    assert [each.name for each in found.entries] == ["here"]
    assert found.gone == ["gone"]
    assert listing(site, "", search="x").gone == ["gone"]
