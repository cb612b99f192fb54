"""Processes are kept from one lot of work to the next, and give what one process gives."""

import os

import pytest

from experiments.worker_tasks import do
from tierod.core.errors import InputError
from tierod.experiments.processes import in_processes, kept

PIDS = [("pid", 0.2), ("pid", 0.2)]


def test_one_process_is_this_one():
    assert in_processes(do, PIDS, 1, str) == 2 * [os.getpid()]


def test_processes_are_kept_and_results_come_in_order():
    with kept():
        assert in_processes(do, [("late", 0.3), ("square", 1), ("square", 2)], 2, str) == [0.3, 1, 4]
        first = set(in_processes(do, PIDS, 2, str))
        assert set(in_processes(do, PIDS, 2, str)) == first
    assert len(first - {os.getpid()}) == 2


def test_a_failure_names_what_failed():
    with kept(), pytest.raises(InputError, match="the drive 2 failed: 2 is no square"):
        in_processes(do, [("square", 1), ("refused", 2)], 2, lambda task: f"the drive {task[1]}")
