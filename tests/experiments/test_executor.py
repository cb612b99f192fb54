"""Worker processes: results, failures that cost one task, and drives of studies that are kept from run to run."""

import subprocess
import sys
from functools import partial

import pytest

from experiments.worker_tasks import do, environment, noted
from tierod.core.errors import InputError
from tierod.work.pool import Failure, run
from tierod_lab.studies import effort as module
from tierod_lab.studies.effort import Effort


def test_a_failure_costs_one_task_and_says_why():
    tasks = [("killed", 0), ("square", 3), ("refused", 5), ("defect", 0), ("hungry", 0), ("square", 4)]
    found = dict(run(do, tasks, 2))
    assert (found[1], found[5]) == (9, 16)
    assert found[0] == Failure("the process was ended by signal 9 (Killed); if memory was short, run with fewer "
                               "--workers", lasting=False)  # fmt: skip
    assert found[2] == Failure("5 is no square", lasting=True)
    assert found[3].reason.startswith("a defect of tierod itself: ZeroDivisionError")
    assert not found[4].lasting


def test_a_script_without_a_guard_is_reported_what_to_do(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text("from experiments.worker_tasks import do\nfrom tierod.work.pool import run\n"
                      "print(list(run(do, [('square', 2)], 1)))\n")  # fmt: skip
    done = subprocess.run([sys.executable, script], env=environment(), capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "guard it with if __name__ == '__main__':" in done.stderr.splitlines()[-1]


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "results"


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
