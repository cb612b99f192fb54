"""Drives of studies: in order, kept from run to run, and made anew where something has changed."""

import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest

from experiments.worker_tasks import do, environment, noted
from tierod.core.errors import InputError
from tierod_lab.studies import effort as module
from tierod_lab.studies.effort import Effort, Results

PIDS = [("pid", 0.2), ("pid", 0.2)]


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "results"


def test_processes_are_kept_and_results_come_in_order():
    with Effort(processes=2).kept(None) as effort:
        assert effort.made(do, [("late", 0.3), ("square", 1), ("square", 2)]) == [0.3, 1, 4]
        first = set(effort.made(do, PIDS))
        assert set(effort.made(do, PIDS)) == first
    assert len(first - {os.getpid()}) == 2


def test_a_failure_names_what_failed():
    with pytest.raises(InputError, match="the drive 2 failed: 2 is no square"):
        Effort(processes=2).made(do, [("square", 1), ("refused", 2)], lambda task: f"the drive {task[1]}")


def noting(tmp_path, numbers, effort):
    """What is made of the numbers, and the numbers that were worked on."""
    log = tmp_path / "log"
    log.write_text("")
    return effort.made(partial(noted, str(log)), numbers), sorted(map(int, log.read_text().split()))


def test_only_what_is_missing_is_made(tmp_path, folder):
    with Effort(processes=2).kept(folder) as effort:
        assert noting(tmp_path, [1, 2], effort) == ([1, 4], [1, 2])
    with Effort(processes=1).kept(folder) as effort:
        assert noting(tmp_path, [3, 2, 1], effort) == ([9, 4, 1], [3])


def test_what_fails_or_is_damaged_is_made_again(tmp_path, folder):
    with Effort(processes=1).kept(folder) as effort:
        assert noting(tmp_path, [5], effort) == ([25], [5])
        (kept,) = folder.iterdir()
        kept.write_bytes(kept.read_bytes()[:-1] + b"x")
        assert noting(tmp_path, [5], effort) == ([25], [5])
        for _ in range(2):
            with pytest.raises(InputError):
                effort.made(do, [("refused", 2)])


def test_changed_code_makes_all_anew(tmp_path, folder, monkeypatch):
    with Effort(processes=1).kept(folder) as effort:
        noting(tmp_path, [5], effort)
    monkeypatch.setattr(module, "work_code", lambda name: "other")
    with Effort(processes=1).kept(folder) as effort, pytest.raises(InputError, match="has changed since the study"):
        noting(tmp_path, [5], effort)


def test_a_folder_that_others_may_write_is_not_used(tmp_path, folder):
    folder.mkdir()
    folder.chmod(0o777)
    assert not Results(folder).usable
    with Effort(processes=1).kept(folder) as effort:
        assert noting(tmp_path, [5], effort) == ([25], [5])
    assert list(folder.iterdir()) == []


TASKS = 30

SCRIPT = f"""
import sys
from functools import partial
from pathlib import Path
from experiments.worker_tasks import noted
from tierod_lab.studies.effort import Effort

if __name__ == "__main__":
    with Effort(processes=2).kept(Path(sys.argv[1])) as effort:
        effort.made(partial(noted, sys.argv[2], pause=0.05), list(range({TASKS})))
"""


@pytest.mark.slow
def test_a_study_that_is_killed_goes_on_where_it_was(tmp_path, folder):
    script, log = tmp_path / "study.py", tmp_path / "log"
    script.write_text(SCRIPT)
    process = subprocess.Popen([sys.executable, script, folder, log], env=environment())
    deadline = time.monotonic() + 60.0
    while (not folder.is_dir() or len(list(folder.glob("result-*"))) < 10) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    left = len(list(folder.glob("result-*.kernel")))
    assert 10 <= left < TASKS
    time.sleep(0.5)  # the workers see that their parent is gone
    log.unlink()
    with Effort(processes=1).kept(folder) as effort:
        assert effort.made(partial(noted, str(log), pause=0.05), list(range(TASKS))) == [n * n for n in range(TASKS)]
    assert len(log.read_text().split()) == TASKS - left
