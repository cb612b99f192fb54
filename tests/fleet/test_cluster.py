"""A Dask cluster behind the one door: results, failures, kills, and clusters that cannot be used."""

import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest

from experiments.worker_tasks import do, environment
from fleet.drives import DAY, NOVEMBER, judged, written
from tierod.core.errors import ParameterError
from tierod.fleet.results import findings_of, ledger_of
from tierod.work import cluster
from tierod.work.cluster import Cluster, workers_of
from tierod.work.pool import Executor, Failure

pytest.importorskip("distributed", reason="distributed is not installed")


class Processes:
    """A scheduler and two workers as processes of their own, as a cluster has them."""

    def __init__(self, folder, path=None):
        self.folder, self.environment = folder, environment()
        if path is not None:
            self.environment["PYTHONPATH"] = str(path)
        self.workers = []
        self.start_scheduler()

    def start_scheduler(self, port=0):
        file = self.folder / f"scheduler-{time.time_ns()}.json"
        self.scheduler = self._started("dask_scheduler", "--host", "127.0.0.1", "--port", str(port),
                                       "--scheduler-file", str(file), "--no-dashboard")  # fmt: skip
        end = time.monotonic() + 60.0
        while not (file.exists() and file.read_text().endswith("}")):
            assert time.monotonic() < end
            time.sleep(0.05)
        self.address = json.loads(file.read_text())["address"]

    def start_worker(self):
        self.workers.append(self._started("dask_worker", self.address, "--nthreads", "1", "--no-nanny",
                                          "--no-dashboard", "--local-directory", str(self.folder)))  # fmt: skip

    def _started(self, name, *arguments):
        command = [sys.executable, "-m", f"distributed.cli.{name}", *arguments]
        return subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def end(self):
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def processes(tmp_path_factory):
    made = Processes(tmp_path_factory.mktemp("cluster"))
    for _ in range(2):
        made.start_worker()
    yield made
    made.end()


def test_tasks_and_failures_are_those_of_local_processes(processes):
    tasks = [("square", 3), ("refused", 5), ("defect", 0), ("square", 4)]
    with workers_of(None, processes.address) as there:
        found = dict(there.run(do, tasks))
        assert list(there.run(do, [])) == []
    with Executor(2) as here:
        local = dict(here.run(do, tasks))
    assert {at: (each.reason, each.lasting) if isinstance(each, Failure) else each for at, each in found.items()} == {
        at: (each.reason, each.lasting) if isinstance(each, Failure) else each for at, each in local.items()
    }


def test_a_fleet_is_judged_as_on_this_machine(processes, tmp_path):
    for seed in (1, 2):
        written(tmp_path / f"drives/{seed}.parquet", seed=seed, start=NOVEMBER + seed * DAY)
    judged(tmp_path / "drives", tmp_path / "there", workers=Cluster(processes.address))
    judged(tmp_path / "drives", tmp_path / "here")
    assert findings_of(tmp_path / "there").equals(findings_of(tmp_path / "here"))


def test_a_cluster_of_another_tierod_is_one_sentence(processes, monkeypatch):
    monkeypatch.setattr(cluster, "__version__", "99.0")
    with pytest.raises(ParameterError, match=r"there is tierod .* on the Dask worker tcp://.*; install tierod 99.0"):
        Cluster(processes.address).__enter__()
    monkeypatch.undo()
    monkeypatch.setattr(cluster, "installed_code", lambda: "changed")
    with pytest.raises(ParameterError, match=r"there is another tierod .*, changed on the Dask worker"):
        Cluster(processes.address).__enter__()


def test_a_scheduler_that_does_not_answer_or_has_no_workers_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with pytest.raises(ParameterError, match=r"the Dask scheduler tcp://127.0.0.1:1 does not answer"):
        Cluster("tcp://127.0.0.1:1").__enter__()
    monkeypatch.setattr(cluster, "PATIENCE", 1.0)
    lonely = Processes(tmp_path)
    try:
        with pytest.raises(ParameterError, match="has no workers; start some with: dask worker"):
            Cluster(lonely.address).__enter__()
    finally:
        lonely.end()


CLIENT = """
import sys
from fleet.drives import judged
from tierod.work.cluster import Cluster
if __name__ == "__main__":
    judged(sys.argv[1], sys.argv[2], workers=Cluster(sys.argv[3]))
"""


def killed_at_random(folder, drives, kills, seed):
    """A run on a cluster of which worker, scheduler or client is killed again and again; how many runs it took."""
    chance = random.Random(seed)
    (folder / "client.py").write_text(CLIENT)
    made = Processes(folder)
    runs = 0
    try:
        while True:
            made.workers = [each for each in made.workers if each.poll() is None]
            while len(made.workers) < 2:
                made.start_worker()
            client = subprocess.Popen(
                [sys.executable, folder / "client.py", drives, folder / "results", made.address],
                env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            runs += 1
            while client.poll() is None and kills:
                try:
                    client.wait(chance.uniform(0.5, 5.0))
                except subprocess.TimeoutExpired:
                    kills -= 1
                    victim = chance.choice(("worker", "worker", "scheduler", "client"))
                    if victim == "worker":
                        os.kill(chance.choice(made.workers).pid, signal.SIGKILL)
                        made.workers = [each for each in made.workers if each.poll() is None]
                        made.start_worker()
                    elif victim == "client":
                        client.kill()
                    else:
                        made.end()
                        made.start_scheduler()
                        made.workers = []
                        for _ in range(2):
                            made.start_worker()
            if client.wait() == 0 and not kills:
                return runs
            if client.returncode == 0:
                kills -= 1  # there was nothing left to kill
    finally:
        made.end()


@pytest.mark.slow
def test_sixty_kills_of_worker_scheduler_and_client_cost_and_double_no_result(tmp_path):
    for number in range(100):
        written(tmp_path / f"drives/{number}.parquet", seed=1 + number % 5, start=NOVEMBER + number * DAY)
    killed_at_random(tmp_path, tmp_path / "drives", kills=60, seed=11)
    judged(tmp_path / "drives", tmp_path / "undisturbed")
    found, undisturbed = findings_of(tmp_path / "results"), findings_of(tmp_path / "undisturbed")
    assert len(found) == 100
    assert found.equals(undisturbed)
    assert [row["outcome"] for row in ledger_of(tmp_path / "results").to_pylist()] == ["judged"] * 100
    assert len(list((tmp_path / "results/parts").rglob("*.arrow"))) == 100
    assert not list((tmp_path / "results/findings").rglob(".*"))
