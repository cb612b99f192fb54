"""Worker processes: results, failures that cost one task, and drives of studies that are kept from run to run."""

import os
import subprocess
import sys
from functools import partial

import pytest

from experiments.worker_tasks import do, environment, noted
from tierod.core.errors import InputError
from tierod.work.pool import Failure, run
from tierod_lab.studies import effort as module
from tierod_lab.studies.effort import Effort


def test_every_task_gives_its_result_whatever_the_number_of_processes():
    tasks = [("square", n) for n in range(7)]
    for processes in (1, 2, 20):
        assert sorted(run(do, tasks, processes)) == [(n, n * n) for n in range(7)]


def test_a_failure_costs_one_task_and_says_why():
    tasks = [("killed", 0), ("square", 3), ("refused", 5), ("defect", 0), ("hungry", 0), ("square", 4)]
    found = dict(run(do, tasks, 2))
    assert (found[1], found[5]) == (9, 16)
    assert found[0] == Failure("the process was ended by signal 9 (Killed); if memory was short, run with fewer "
                               "--workers", lasting=False)  # fmt: skip
    assert found[2] == Failure("5 is no square", lasting=True)
    assert found[3].reason.startswith("a defect of tierod itself: ZeroDivisionError")
    assert not found[4].lasting


def test_workers_compute_with_one_thread_and_the_parent_as_before(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    assert list(run(do, [("threads", "OMP_NUM_THREADS")], 1)) == [(0, "1")]
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


def test_a_script_without_a_guard_is_reported_what_to_do(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text("from experiments.worker_tasks import do\nfrom tierod.work.pool import run\n"
                      "print(list(run(do, [('square', 2)], 1)))\n")  # fmt: skip
    done = subprocess.run([sys.executable, script], env=environment(), capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "guard it with if __name__ == '__main__':" in done.stderr.splitlines()[-1]


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


def test_changed_code_makes_all_anew(tmp_path, folder, monkeypatch):
    with Effort(processes=1).kept(folder) as effort:
        noting(tmp_path, [5], effort)
    monkeypatch.setattr(module, "work_code", lambda name: "other")
    with Effort(processes=1).kept(folder) as effort, pytest.raises(InputError, match="has changed since the study"):
        noting(tmp_path, [5], effort)
