"""Jobs: done once, cancelled, limited in time and memory, failed with a sentence."""

import dataclasses
import time

import pytest

from tierod.core.errors import ParameterError
from tierod.web.errors import Absent, Busy
from tierod.web.jobs import CANCELLED, DONE, FAILED, RUNNING, Jobs
from tierod.web.shapes import Analysed, ChosenScenario
from tierod.web.site import Limits
from web_jobs import ended


def asked(file="drives/weave.parquet"):
    return Analysed(file=file, vehicle="", channel_map=None, spread=False)


def test_nothing_is_worked_out_that_is_kept(working, analysed):
    before = {path: path.stat().st_ino for path in working.store.folder.glob("*/*/*/index.json")}
    job = working.analyse(asked())
    assert working.analyse(asked()) is job
    done = ended(working.jobs, job)
    assert (done.state, done.text) == (DONE, "")
    assert done.found == {"series": analysed.series, "result": analysed.result, "why": ""}
    assert {path: path.stat().st_ino for path in working.store.folder.glob("*/*/*/index.json")} == before


def test_a_broken_recording_is_a_sentence(working, analysed):
    path = analysed.folder / "broken.parquet"
    path.write_bytes((analysed.folder / "weave.parquet").read_bytes()[:5000])
    try:
        done = ended(working.jobs, working.analyse(asked("drives/broken.parquet")))
    finally:
        path.unlink()
    assert done.state == FAILED
    assert "broken.parquet" in done.text
    assert "Traceback" not in done.text
    assert str(analysed.folder) not in done.text


def test_a_job_is_cancelled_while_it_works_and_the_next_one_runs(working):
    first = working.simulate(ChosenScenario(car="midsize-eps", course="country", seconds=3600.0))
    while first.state != RUNNING:
        time.sleep(0.02)
    second = working.analyse(asked())
    assert working.jobs.cancel(first.id).state == CANCELLED
    assert ended(working.jobs, second).state == DONE
    assert working.jobs.job(first.id).state == CANCELLED
    with pytest.raises(Absent):
        working.jobs.cancel("no-such-job")


def test_limits_of_time_and_memory_end_a_job():
    slow = {
        "car": "midsize-eps",
        "course": "country",
        "seconds": 3600.0,
        "folder": "/nonexistent",
        "cache": "/nonexistent",
    }
    for limits, words in ((Limits(job_time=0.05), "longer than 0.05 s"), (Limits(job_memory=1 << 20), "memory")):
        jobs = Jobs(1, limits)
        try:
            done = ended(jobs, jobs.submit("simulate", slow, "driving"))
        finally:
            jobs.close()
        assert done.state == FAILED
        assert words in done.text


def test_too_many_jobs_are_refused():
    jobs = Jobs(0, dataclasses.replace(Limits(), waiting=2))
    for number in range(2):
        jobs.submit("inspect", {"number": number}, "looking")
    assert jobs.submit("inspect", {"number": 0}, "looking") is jobs.all()[-1]
    with pytest.raises(Busy, match="2 jobs wait"):
        jobs.submit("inspect", {"number": 3}, "looking")
    jobs.cancel(jobs.all()[0].id)
    assert jobs.submit("inspect", {"number": 3}, "looking").state == "waiting"
    jobs.close()


def test_a_scenario_that_cannot_be_is_reported_without_lines_of_a_file(tmp_path):
    from tierod_lab.web.scenarios import drive

    late = {"name": "friction-step", "start": 120.0}
    chosen = {"folder": str(tmp_path), "car": "midsize-eps", "course": "mixed", "seconds": 60.0, "faults": [late]}
    with pytest.raises(ParameterError, match="^the fault begins at 120 s, but the run ends at 60 s"):
        drive(chosen, lambda *_: None)


def test_a_channel_map_of_the_page_holds_when_the_vehicle_is_changed(working, analysed):
    file = "drives/weave.parquet"
    own = {"signals": {"yaw_rate": {"source": "yaw_rate", "sign": -1, "factor": 1, "optional": True}}}
    chosen = Analysed(file=file, vehicle="midsize-eps", channel_map=own, spread=False)
    first = ended(working.jobs, working.analyse(chosen))
    assert first.state == DONE
    assert first.found["series"] != analysed.series
    assert working.state(file).corrected
    again = working.analyse(Analysed(file=file, vehicle="revsted-car", spread=False))
    assert again.given["channel_map"] == own
    assert ended(working.jobs, again).found["series"] == first.found["series"]
