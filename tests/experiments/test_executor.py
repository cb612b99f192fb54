"""Worker processes: results, failures that cost one task, and an end with their parent."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from experiments.worker_tasks import do, environment, linger
from tierod.core.errors import OutputError
from tierod.work.pool import Failure, run


def test_every_task_gives_its_result_whatever_the_number_of_processes():
    tasks = [("square", n) for n in range(7)]
    for processes in (1, 2, 20):
        assert sorted(run(do, tasks, processes)) == [(n, n * n) for n in range(7)]


def test_no_task_needs_no_process():
    assert list(run(do, [], 2)) == []


def test_a_failure_costs_one_task_and_says_why():
    tasks = [("killed", 0), ("square", 3), ("refused", 5), ("defect", 0), ("hungry", 0), ("square", 4)]
    found = dict(run(do, tasks, 2))
    assert (found[1], found[5]) == (9, 16)
    assert found[0] == Failure("the process was ended by signal 9 (Killed); if memory was short, run with fewer "
                               "--workers", lasting=False)  # fmt: skip
    assert found[2] == Failure("5 is no square", lasting=True)
    assert found[3].reason.startswith("a defect of tierod itself: ZeroDivisionError")
    assert not found[4].lasting


@pytest.mark.parametrize(("ours", "error"), [(True, OutputError), (False, OSError)])
def test_what_the_disk_refuses_ends_all(ours, error):
    with pytest.raises(error):
        list(run(do, [("square", 1), ("full", ours), ("late", 30.0)], 2))


def test_processes_under_way_are_ended_without_a_reader():
    tasks = run(do, [("square", 1), ("late", 60.0)], 2)
    began = time.monotonic()
    assert next(tasks) == (0, 1)
    tasks.close()
    assert time.monotonic() - began < 30.0


def test_workers_compute_with_one_thread_and_the_parent_as_before(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    assert list(run(do, [("threads", "OMP_NUM_THREADS")], 1)) == [(0, "1")]
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


PARENT = """
import sys
from experiments.worker_tasks import linger
from tierod.work.pool import run
if __name__ == "__main__":
    list(run(linger, [sys.argv[1]], 1))
"""


def test_no_worker_outlives_a_parent_that_is_killed(tmp_path):
    assert linger is not None
    script, seen = tmp_path / "parent.py", tmp_path / "pid"
    script.write_text(PARENT)
    parent = subprocess.Popen([sys.executable, script, seen], env=environment())
    pid = int(waited(lambda: seen.exists() and seen.read_text()))
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    waited(lambda: not alive(pid))


def test_a_script_without_a_guard_is_reported_what_to_do(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text("from experiments.worker_tasks import do\nfrom tierod.work.pool import run\n"
                      "print(list(run(do, [('square', 2)], 1)))\n")  # fmt: skip
    done = subprocess.run([sys.executable, script], env=environment(), capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "guard it with if __name__ == '__main__':" in done.stderr.splitlines()[-1]


def waited(condition, seconds=60.0):
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return found


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False
