"""Campaigns that are run, killed and resumed; drives that fail in every way; files that are damaged."""

import hashlib
import json
import shutil
from dataclasses import replace

import pytest

from experiments.toy_scenario import FAULT, ToyScenario, plan
from tierod.work.pool import Executor
from tierod_lab.campaign.running import run
from tierod_lab.campaign.store import Store


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


def test_nothing_is_done_twice_and_only_what_changed_is_done_again(whole):
    before = contents(whole)
    assert [each.done for each in ran(whole, plan(*MIXED))] == [4]
    assert contents(whole) == before
    changed = [*MIXED[:3], replace(MIXED[3], duration=21.0)]
    assert [each.done for each in ran(whole, plan(*changed))] == [3, 4]
    after = contents(whole)
    assert before.items() < after.items()
    assert len(after) - len(before) == 3


def test_a_killed_campaign_goes_on_and_ends_as_if_nothing_had_been(whole):
    before = contents(whole)
    for kind, left in (("drives", 3), ("recordings", 2), ("verdicts", 1)):
        for path in sorted((whole.folder / kind).iterdir())[left:]:
            path.unlink()
    (whole.folder / "verdicts" / ".half.0123456789ab.json").write_text('{"schema": ')
    with whole.alone():
        ran(whole, plan(*MIXED))
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


KEY = "0123456789abcdef" * 4


@pytest.mark.parametrize("damage", [lambda text: text[:40], lambda text: "[]", lambda text: text.replace("e/1", "e/0")])
def test_a_damaged_record_does_not_count(store, damage):
    store.keep_drive("a", KEY, {"outcome": "driven"})
    assert store.drive("a", KEY)["outcome"] == "driven"
    path = next((store.folder / "drives").iterdir())
    path.write_text(damage(path.read_text()))
    assert store.drive("a", KEY) is None
