"""A run over the recordings of a fleet: every recording has a row, none costs another, and nothing is done twice."""

import datetime as dt
import errno
import os
import shutil
import time
from dataclasses import replace

import fsspec
import pytest

from fleet.drives import DAY, FRICTION, NOVEMBER, SIGNALS, Here, judged, written
from tierod.core.errors import InputError, OutputError
from tierod.fleet import fleet_file, levels, running
from tierod.fleet.judging import Asked
from tierod.fleet.places import Place
from tierod.fleet.results import findings_of, ledger_of
from tierod.io.readers import read
from tierod.io.writers import write
from tierod.monitors.diagnose import diagnose
from tierod.monitors.runner import Chosen


def reasons(results):
    return {
        os.path.basename(row["recording_name"]): (row["outcome"], row["reason"])
        for row in ledger_of(results).to_pylist()
    }


def test_findings_are_those_of_diagnose(tmp_path):
    path = written(tmp_path / "drives/a.parquet")
    found = judged(tmp_path / "drives", tmp_path / "results")
    assert (found.exit_code, dict(found.outcomes)) == (0, {"judged": 1})
    (row,) = findings_of(tmp_path / "results").to_pylist()
    (alone,) = diagnose(path, "midsize-eps", "friction").findings
    assert (row["monitor"], row["variant"], row["status"], row["cause"]) == (
        "friction", "pre-sliding", str(alone.status), alone.cause)  # fmt: skip
    assert row["start"] == dt.datetime(2025, 11, 1, tzinfo=dt.UTC)
    assert row["duration_s"] == pytest.approx(40.0, abs=0.02)
    assert row["vehicle"] == "midsize-eps"
    assert row["recording_name"] == str(path)


def test_every_recording_has_a_row_with_its_reason_and_costs_itself_alone(tmp_path):
    drives = tmp_path / "drives"
    good = written(drives / "good.parquet")
    shutil.copy(good, drives / "same.parquet")
    written(drives / "short.parquet", seconds=10.0)
    written(drives / "future.parquet", start=time.time() + 30 * DAY)
    (drives / "torn.parquet").write_bytes(good.read_bytes()[:4000])
    (drives / "other.csv").write_text("time,rain\n" + "".join(f"{0.01 * n},1.5\n" for n in range(9000)))
    os.symlink(drives / "nowhere", drives / "gone.parquet")
    judged(drives, tmp_path / "results")
    found = reasons(tmp_path / "results")
    assert found["good.parquet"] == ("judged", "")
    for name, outcome, words in (
        ("same.parquet", "skipped", "it is the same drive as"),
        ("short.parquet", "skipped", "less than 30 s are not judged"),
        ("future.parquet", "skipped", "in the future"),
        ("torn.parquet", "failed", "damaged or cut off"),
        ("other.csv", "failed", "holds none of"),
        ("gone.parquet", "failed", "no such file"),
    ):
        assert found[name][0] == outcome, name
        assert words in found[name][1], name
    assert len(found) == 7
    assert len(findings_of(tmp_path / "results")) == 1


def test_a_second_run_does_only_what_is_new(tmp_path):
    drives, results = tmp_path / "drives", tmp_path / "results"
    written(drives / "a.parquet")
    (drives / "torn.parquet").write_bytes(b"PAR1 torn PAR1")
    judged(drives, results)
    kept = {path: path.stat().st_mtime_ns for path in results.rglob("*.parquet") if "ledger" not in path.parts}
    written(drives / "b.parquet", seed=2, start=NOVEMBER + DAY)
    workers = Here()
    found = judged(drives, results, workers=workers)
    assert workers.tasks == [str(drives / "b.parquet")]
    assert (found.kept, found.outcomes["judged"]) == (2, 2)
    assert all(path.stat().st_mtime_ns == before for path, before in kept.items() if "levels" in path.parts)
    again = Here()
    judged(drives, results, workers=again, again=True)
    assert again.tasks == [str(drives / "torn.parquet")]


def test_a_result_is_found_by_its_content(tmp_path, monkeypatch):
    drives, results = tmp_path / "drives", tmp_path / "results"
    path = written(drives / "a.parquet")
    judged(drives, results)
    before = findings_of(results)
    shutil.rmtree(results / "ledger")
    shutil.rmtree(results / "findings")
    path.rename(drives / "renamed.parquet")
    monkeypatch.setattr("tierod.fleet.task.judge", lambda *_: pytest.fail("judged again"))
    judged(drives, results)
    after = findings_of(results)
    assert after["recording_name"].to_pylist() == [str(drives / "renamed.parquet")]
    assert after.drop_columns("recording_name").equals(before.drop_columns("recording_name"))


def test_what_the_fleet_file_says_is_changed_without_judging_again(tmp_path, monkeypatch):
    drives, results = tmp_path / "drives", tmp_path / "results"
    written(drives / "a.parquet")
    fleet = tmp_path / "fleet.toml"
    text = (
        '[[recordings]]\nvehicle = "car 1"\nparameters = "midsize-eps"\ncohort = {{batch = "{}"}}\nmileage = "12 km"\n'
    )
    fleet.write_text(text.format("A"))
    judged(drives, results, fleet_file.load(fleet))
    fleet.write_text(text.format("B"))
    monkeypatch.setattr("tierod.fleet.task.judge", lambda *_: pytest.fail("judged again"))
    judged(drives, results, fleet_file.load(fleet))
    (row,) = findings_of(results).to_pylist()
    assert (row["vehicle"], row["cohort"], row["mileage_m"]) == ("car 1", [("batch", "B")], 12000.0)


def test_a_full_disk_is_one_sentence_and_nothing_done_is_lost(tmp_path, monkeypatch):
    drives, results = tmp_path / "drives", tmp_path / "results"
    for seed in (1, 2, 3):
        written(drives / f"{seed}.parquet", seed=seed, start=NOVEMBER + seed * DAY)
    replace, count = os.replace, []

    def full(source, target):
        count.append(str(target))
        if len([name for name in count if "/parts/" in name]) > 1 and "/parts/" in str(target):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OutputError, match=r"cannot be written \(No space left on device\); make room"):
        judged(drives, results)
    monkeypatch.setattr(os, "replace", replace)
    assert [row["outcome"] for row in ledger_of(results).to_pylist()] == ["judged"]
    assert not [path for path in results.rglob(".*") if path.name != ".try"]
    workers = Here()
    judged(drives, results, workers=workers)
    assert len(workers.tasks) == 2
    assert len(findings_of(results)) == 3


def test_two_runs_do_not_write_to_one_folder(tmp_path):
    written(tmp_path / "drives/a.parquet")
    judged(tmp_path / "drives", tmp_path / "results")
    with running._held(Place(str(tmp_path / "results"))), pytest.raises(OutputError, match="another run"):
        judged(tmp_path / "drives", tmp_path / "results")


def test_a_folder_of_something_else_and_a_pattern_without_a_match_are_refused(tmp_path):
    written(tmp_path / "drives/a.parquet")
    with pytest.raises(InputError, match="no recording matches"):
        judged(tmp_path / "drives/*.mf4", tmp_path / "results")
    (tmp_path / "about.json").write_text('{"name": "mine"}')
    with pytest.raises(InputError, match="is not of 'tierod fleet'"):
        judged(tmp_path / "drives", tmp_path)


def test_spans_of_a_long_recording_carry_the_state_on(tmp_path):
    path = written(tmp_path / "drives/a.parquet", seconds=100.0)
    judged(path, tmp_path / "results", asked=replace(FRICTION, span=40.0))
    rows = findings_of(tmp_path / "results").to_pylist()
    assert [row["span"] for row in rows] == [0, 1, 2]
    assert [round(row["duration_s"]) for row in rows] == [40, 80, 100]
    judged(path, tmp_path / "whole")
    (whole,) = findings_of(tmp_path / "whole").to_pylist()
    assert {key: rows[-1][key] for key in ("status", "estimate", "cause")} == {
        key: whole[key] for key in ("status", "estimate", "cause")}  # fmt: skip


def test_drives_of_one_vehicle_that_overlap_are_remarked(tmp_path):
    written(tmp_path / "drives/a.parquet")
    written(tmp_path / "drives/b.parquet", seed=2, start=NOVEMBER + 20.0)
    judged(tmp_path / "drives", tmp_path / "results")
    first, second = ledger_of(tmp_path / "results").to_pylist()
    assert first["remarks"] == []
    assert second["remarks"] == [f"it overlaps in time with {tmp_path}/drives/a.parquet, of the same vehicle"]


def test_several_monitors_share_one_reading_and_say_why_one_did_not_run(tmp_path):
    path = written(tmp_path / "drives/a.parquet")
    judged(path, tmp_path / "results", asked=Asked((Chosen("friction"), Chosen("motor-angle")), spread=False))
    assert findings_of(tmp_path / "results")["monitor"].to_pylist() == ["friction"]
    (row,) = ledger_of(tmp_path / "results").to_pylist()
    assert row["remarks"][0].startswith("motor-angle did not run: the monitor 'motor-angle' needs motor_current_alpha")


def test_one_drive_in_several_formats_counts_once(tmp_path):
    drives = tmp_path / "drives"
    written(drives / "a.parquet", start=0.0)
    written(drives / "other.parquet", seed=2, start=0.0)
    recording = read(drives / "a.parquet")
    write(recording, drives / "b.mf4")
    (drives / "c.csv").write_text(
        "time," + ",".join(SIGNALS) + "\n"
        + "\n".join(
            f"{time:.3f}," + ",".join(f"{recording[name].values[at]:.5g}" for name in SIGNALS)
            for at, time in enumerate(recording["yaw_rate"].time)
        )
    )  # fmt: skip
    judged(drives, tmp_path / "results")
    found = reasons(tmp_path / "results")
    assert {name: outcome for name, (outcome, _) in found.items()} == {
        "a.parquet": "judged", "b.mf4": "skipped", "c.csv": "skipped", "other.parquet": "judged"}  # fmt: skip
    assert "a.parquet: mean and deviation of 7 signals agree; delete one" in found["b.mf4"][1]
    assert "a.parquet: mean and deviation of 7 signals agree; delete one" in found["c.csv"][1]


@pytest.fixture
def storage():
    made = fsspec.filesystem("memory")
    yield made
    made.store.clear()
    made.pseudo_dirs[:] = [""]


def test_recordings_and_results_lie_in_a_storage(storage, tmp_path):
    for number in (1, 2):
        written(tmp_path / f"{number}.parquet", seed=number, start=NOVEMBER + number * DAY)
        storage.put(str(tmp_path / f"{number}.parquet"), f"drives/2026/car-{number}/{number}.parquet")
    storage.pipe_file("drives/2026/car-1/torn.parquet", b"PAR1 torn PAR1")
    storage.pipe_file("drives/2026/readme.md", b"not a recording")
    (tmp_path / "fleet.toml").write_text(
        "[[recordings]]\npattern = '/(?P<vehicle>car-[0-9]+)/'\nparameters = 'midsize-eps'\n"
    )
    fleet = fleet_file.load(tmp_path / "fleet.toml")
    judged("memory://drives/2026/", "memory://results/fleet", fleet)
    found = findings_of("memory://results/fleet")
    assert found["vehicle"].to_pylist() == ["car-1", "car-2"]
    assert found["recording_name"].to_pylist()[0] == "memory:///drives/2026/car-1/1.parquet"
    rows = ledger_of("memory://results/fleet").to_pylist()
    assert [(row["outcome"], row["reason"][:12]) for row in rows] == [
        ("judged", ""), ("failed", "memory:///dr"), ("judged", "")]  # fmt: skip
    zoomed = levels.zoom("memory://results/fleet", found["key"][0].as_py(), "enabled")
    assert len(zoomed) > 30
    local = tmp_path / "here"
    judged(tmp_path / "*.parquet", local, fleet_file.one_vehicle("midsize-eps"))
    for column in ("estimate", "deviation", "status", "recording"):
        assert findings_of(local)[column].equals(found[column])
    workers = Here()
    judged("memory://drives/2026/**/*.parquet", "memory://results/fleet", fleet, workers=workers)
    assert workers.tasks == []
