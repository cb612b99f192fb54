import subprocess
import sys
import threading

import pytest

from tierod.core import processes as locks
from tierod.core.errors import OutputError
from tierod.core.files import holding
from tierod.core.processes import alone


def test_one_at_a_time_and_whoever_waits_gets_its_turn(tmp_path):
    order = []

    def second():
        with alone(tmp_path) as held:
            order.append(("second", held))

    with alone(tmp_path) as held:
        waiting = threading.Thread(target=second)
        waiting.start()
        with pytest.raises(TimeoutError, match="another process holds"), alone(tmp_path, patience=0.05):
            pass
        order.append(("first", held))
    waiting.join()
    assert order == [("first", True), ("second", True)]


def test_the_lock_ends_with_its_process(tmp_path):
    code = (
        "import os, pathlib, sys; from tierod.core.processes import alone\n"
        "with alone(pathlib.Path(sys.argv[1])): os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", code, tmp_path], check=False).returncode == 9
    with alone(tmp_path, patience=0.0) as held:
        assert held


def test_what_is_gone_when_the_lock_is_free_is_not_held(tmp_path):
    place, found = tmp_path / "folder", []
    place.mkdir()

    def second():
        try:
            with alone(place):
                found.append("held")
        except FileNotFoundError:
            found.append("gone")

    with alone(place):
        waiting = threading.Thread(target=second)
        waiting.start()
        place.rmdir()
    waiting.join()
    assert found == ["gone"]


def test_what_was_made_anew_meanwhile_is_held_in_its_new_form(tmp_path):
    place, held = tmp_path / "file", threading.Event()
    place.write_text("old")

    def second():
        with alone(place):
            held.set()
            with pytest.raises(TimeoutError), alone(place, patience=0.0):
                pass

    with alone(place):
        waiting = threading.Thread(target=second)
        waiting.start()
        place.rename(tmp_path / "away")
        place.write_text("new")
    waiting.join()
    assert held.is_set()


def test_where_the_system_has_no_locks_work_goes_on(tmp_path, monkeypatch):
    import fcntl

    def refused(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refused)
    with alone(tmp_path) as held:
        assert not held


def test_a_file_that_is_held_without_end_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(locks.alone.__wrapped__, "__defaults__", (0.02,))
    with holding(tmp_path / "file") as place:
        assert place == tmp_path.resolve() / "file"
        with pytest.raises(OutputError, match="file cannot be written: another program has been writing in its folder"):
            holding(tmp_path / "other file").__enter__()
