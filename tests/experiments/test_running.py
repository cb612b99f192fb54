"""Campaigns that are run, killed and resumed; drives that fail in every way."""

import hashlib
import importlib
import json
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace

import pytest

from experiments.toy_scenario import FAULT, ToyScenario, plan
from experiments.worker_tasks import environment
from tierod.core.errors import OutputError
from tierod.core.files import write_text
from tierod.work.pool import Executor
from tierod_lab.campaign import running
from tierod_lab.campaign.matrix import Point
from tierod_lab.campaign.plan import Cell
from tierod_lab.campaign.running import run
from tierod_lab.campaign.store import Store
from tierod_lab.ground.faults import AtTime, Fault, Step
from tierod_lab.ground.scenarios import load


@pytest.fixture
def store(tmp_path):
    return prepared(tmp_path / "runs")


def prepared(folder):
    store = Store(folder)
    store.prepare()
    return store


def contents(store):
    """Name -> hash of every file that a campaign has made."""
    return {
        path.relative_to(store.folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(store.folder.rglob("*"))
        if path.is_file() and path.name != ".lock"
    }


class Kept(Executor):
    """Goes on from one campaign to the next."""

    def __exit__(self, *_):
        pass


ONE = Kept(1)


@pytest.fixture(scope="module", autouse=True)
def ended():
    yield
    ONE.close()


def ran(store, planned, processes=1):
    """Reports of the progress."""
    reports = []
    run(planned, store, ONE if processes == 1 else Executor(processes), reports.append)
    return reports


def drives(store):
    return [json.loads(path.read_text()) for path in sorted((store.folder / "drives").glob("*.json"))]


MIXED = [ToyScenario(seed=n, faults=(FAULT,) if n % 2 else ()) for n in range(4)]


@pytest.fixture(scope="module")
def ran_once(tmp_path_factory):
    """Results of two workers for MIXED, and their reports of progress."""
    store = prepared(tmp_path_factory.mktemp("whole") / "runs")
    return store, ran(store, plan(*MIXED), processes=2)


@pytest.fixture
def whole(ran_once, tmp_path):
    """A copy of it."""
    shutil.copytree(ran_once[0].folder, tmp_path / "whole")
    return Store(tmp_path / "whole")


def test_every_cell_gives_a_drive_a_recording_and_a_verdict(ran_once):
    store, reports = ran_once
    assert [each.done for each in reports] == list(range(5))
    assert {each.outcome for each in reports[1:]} == {"driven"}
    for kind in ("drives", "recordings", "verdicts"):
        assert len(list((store.folder / kind).iterdir())) == 4
    record = next(drive for drive in drives(store) if drive["place"]["fault"] == "step")
    assert record["provenance"]["scenario"] == {"course": "well", "seed": 1}
    assert record["windows"] == [{"name": "step", "start": 10.0, "end": 20.0}]
    verdict = json.loads(next((store.folder / "verdicts").iterdir()).read_text())
    assert verdict["judged"]["status"] == "not ready"


def test_the_result_depends_neither_on_the_number_of_workers_nor_on_the_order(whole, store):
    planned = plan(*MIXED)
    ran(store, replace(planned, cells=planned.cells[::-1]), processes=1)
    assert contents(store) == contents(whole)
    assert len(contents(store)) == 12


def test_nothing_is_done_twice_and_only_what_changed_is_done_again(whole):
    before = contents(whole)
    assert [each.done for each in ran(whole, plan(*MIXED))] == [4]
    assert contents(whole) == before
    changed = [*MIXED[:3], replace(MIXED[3], duration=21.0)]
    assert [each.done for each in ran(whole, plan(*changed))] == [3, 4]
    after = contents(whole)
    assert before.items() < after.items()
    assert len(after) - len(before) == 3


def test_another_monitor_judges_the_drives_that_are_there(whole):
    before = contents(whole)
    assert len(ran(whole, plan(*MIXED, variant="refined"))) == 5
    new = [name for name in contents(whole) if name not in before]
    assert len(new) == 4
    assert all(name.startswith("verdicts/") for name in new)


def test_judging_a_kept_drive_is_judging_the_drive(whole):
    before = contents(whole)
    for path in (whole.folder / "verdicts").iterdir():
        path.unlink()
    ran(whole, plan(*MIXED))
    assert contents(whole) == before


def test_recordings_are_kept_only_where_they_are_wanted(store):
    ran(store, plan(*MIXED[:2], keep=False))
    assert not list((store.folder / "recordings").iterdir())
    assert len(ran(store, plan(*MIXED[:2], keep=False))) == 1
    assert len(ran(store, plan(*MIXED[:2]))) == 3
    assert len(list((store.folder / "recordings").iterdir())) == 2


def test_a_lost_recording_is_driven_again(whole):
    before = contents(whole)
    next((whole.folder / "recordings").iterdir()).unlink()
    assert len(ran(whole, plan(*MIXED))) == 2
    assert contents(whole) == before


def test_failed_drives_are_reported_and_stop_nothing(store):
    kinds = ["well", "diverges", "refused", "defect", "killed", "poor"]
    scenarios = [ToyScenario(course=kind) for kind in kinds]
    reports = ran(store, plan(*scenarios))
    assert reports[-1].done == 6
    found = {drive["provenance"]["scenario"]["course"]: drive for drive in drives(store)}
    assert {kind: found[kind]["outcome"] for kind in kinds} == {
        "well": "driven", "diverges": "diverged", "refused": "failed", "defect": "failed", "killed": "failed",
        "poor": "driven",
    }  # fmt: skip
    assert found["diverges"]["last_good_s"] == 10.0
    assert "last good time is 10 s" in found["diverges"]["reason"]
    assert found["diverges"]["recording"] is not None
    assert found["refused"]["reason"] == "the toy has no wheels; give it some"
    assert "ZeroDivisionError" in found["defect"]["reason"]
    assert "signal 9" in found["killed"]["reason"]
    verdicts = [json.loads(path.read_text()) for path in (store.folder / "verdicts").iterdir()]
    assert len(verdicts) == 2
    assert any("needs lateral_acceleration" in verdict["reason"] for verdict in verdicts)
    # Only what may have been chance is tried again.
    assert [each.name for each in ran(store, plan(*scenarios))[1:]] == ["fault-free_0_4"]


def test_a_full_disk_stops_the_campaign_and_leaves_what_is_finished(whole, store):
    done = []

    def filling(progress):
        done.append(progress.name)
        if len(done) == 2:
            (store.folder / "verdicts").rename(store.folder / "gone")

    with pytest.raises(OutputError, match="cannot be written"):
        run(plan(*MIXED), store, Executor(1), filling)
    (store.folder / "gone").rename(store.folder / "verdicts")
    left = contents(store)
    assert left.items() < contents(whole).items()
    ran(store, plan(*MIXED))
    assert contents(store) == contents(whole)


def test_reference_drives_come_first_and_later_ones_know_that_they_gave_nothing(store):
    scenarios = [replace(each, seed=number) for number, each in enumerate([MIXED[1], MIXED[0], MIXED[3]])]
    reports = ran(store, plan(*scenarios, learns=True), processes=1)
    assert [each.name for each in reports[1:]] == ["fault-free_0_1", "step_0_0", "step_0_2"]
    verdicts = {
        path.name[:8].strip("-"): json.loads(path.read_text()) for path in (store.folder / "verdicts").iterdir()
    }
    assert verdicts["fault-fr"]["judged"]["status"] == "not ready"
    assert verdicts["step_0_0"]["judged"] is None
    assert verdicts["step_0_0"]["reason"].endswith("set no baseline: it was judged 'not ready'")


def test_drives_are_judged_once_their_reference_could_be(store, monkeypatch):
    scenarios = [ToyScenario(course="killed"), replace(MIXED[1], seed=2)]
    ran(store, plan(*scenarios, learns=True))
    (verdict,) = (json.loads(path.read_text()) for path in (store.folder / "verdicts").iterdir())
    assert verdict["reason"].endswith("set no baseline: it was failed")
    assert not verdict["lasting"]
    assert len(ran(store, plan(*scenarios, learns=True))) == 3
    diverged = [ToyScenario(course="diverges"), replace(MIXED[1], seed=3)]
    assert len(ran(store, plan(*diverged, learns=True))) == 3
    assert len(ran(store, plan(*diverged, learns=True))) == 1


def test_code_that_changes_under_a_campaign_fails_its_drives_for_now(store, monkeypatch):
    monkeypatch.setattr(running, "code", lambda: ("other", "code"))
    reports = ran(store, plan(*MIXED[:2]))
    assert [each.outcome for each in reports[1:]] == ["failed"] * 2
    assert "has changed since the campaign began" in drives(store)[0]["reason"]
    monkeypatch.undo()
    assert [each.outcome for each in ran(store, plan(*MIXED[:2]))[1:]] == ["driven"] * 2


SCRIPT = """
import sys
from pathlib import Path
from experiments.toy_scenario import FAULT, ToyScenario, plan
from tierod.work.pool import Executor
from tierod_lab.campaign.running import run
from tierod_lab.campaign.store import Store

if __name__ == "__main__":
    store = Store(Path(sys.argv[1]))
    store.prepare()
    with store.alone():
        scenarios = [ToyScenario(seed=n, faults=(FAULT,) if n % 2 else (), duration=40.0) for n in range(8)]
        run(plan(*scenarios), store, Executor(1))
"""


def started(script, folder):
    return subprocess.Popen([sys.executable, script, folder], env=environment())


def finished(store):
    return [path for path in store.folder.glob("verdicts/*.json") if not path.name.startswith(".")]


def test_a_campaign_that_is_killed_again_and_again_ends_as_if_nothing_had_been(tmp_path):
    script = tmp_path / "campaign.py"
    script.write_text(SCRIPT)
    scenarios = [ToyScenario(seed=n, faults=(FAULT,) if n % 2 else (), duration=40.0) for n in range(8)]
    undisturbed = prepared(tmp_path / "whole")
    ran(undisturbed, plan(*scenarios))
    whole = contents(undisturbed)
    assert len(whole) == 24
    broken = Store(tmp_path / "broken")
    for kills in range(1, 3):
        process = started(script, broken.folder)
        deadline = time.monotonic() + 60.0
        while len(finished(broken)) < 2 * kills and time.monotonic() < deadline:
            time.sleep(0.005)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert 4 <= len(finished(broken)) < 8
    left = broken.folder / "verdicts" / ".half.0123456789ab.json"
    write_text(left, '{"schema": ')
    time.sleep(0.5)  # the worker sees that its parent is gone
    broken.prepare()
    with broken.alone():
        ran(broken, plan(*scenarios))
    assert contents(broken) == whole


def test_kernels_are_compiled_once_before_the_workers_start(monkeypatch):
    driven = []
    monkeypatch.setattr(ToyScenario, "run", lambda self, **_: driven.append(self.duration))
    planned = plan(*MIXED)
    running.compile_once(planned.cells, planned.judges)
    assert driven == [running.TASTE] * 2


def test_what_faults_vary_is_compiled_too_although_they_come_late(monkeypatch):
    base = load("mixed-drive-healthy")
    fault = Fault("steering.friction.level", Step(8.0), AtTime(390.0))
    varied = replace(base, faults=(fault,))
    made = []
    home = importlib.import_module("tierod_lab.ground.run")
    known = home.kernel
    monkeypatch.setattr(home, "kernel", lambda block: made.append(type(block).__name__) or known(block))
    cells = [Cell(Point({}, (), 1), scenario, str(n), None) for n, scenario in enumerate((base, varied, varied))]
    running.compile_once(cells, [])
    assert made == [type(base.car).__name__, "Varied"]
