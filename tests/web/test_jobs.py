"""Jobs: done once, cancelled, limited in time and memory, failed with a sentence."""

import dataclasses
import json
import time

import pytest

from shared_data import shared_data
from tierod.core.errors import InputError, ParameterError
from tierod.io.readers import read
from tierod.monitors.acceptance import vehicle_named_in
from tierod.web.analysing import Reading, analyse
from tierod.web.errors import Absent, Busy, in_the_page
from tierod.web.jobs import CANCELLED, DONE, FAILED, RUNNING, Jobs
from tierod.web.series import SeriesReader
from tierod.web.shapes import Analysed, ChosenScenario
from tierod.web.site import Limits
from tierod.web.store import Store
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


def worked_out(store, path, vehicle=""):
    return analyse(store, Reading(path), vehicle, False, lambda *words, **more: None)


def test_a_bus_log_is_read_and_judged_as_its_vehicle(tmp_path):
    store, path = Store(tmp_path), shared_data("rav4_highway_minute", "can.log")
    found = worked_out(store, path, "rav4")
    reader = SeriesReader(store.path("series", found["series"]))
    assert {"driver_torque", "steering_wheel_angle", "wheel_speed_front_left"} <= set(reader.signals)
    result = json.loads((store.path("results", found["result"]) / "result.json").read_text())
    assert result["monitors"]["friction"]["findings"][0]["status"] == "not identifiable"
    with pytest.raises(InputError, match="DBC"):
        worked_out(store, path)


def test_a_table_without_vehicle_shows_its_signals_and_says_why_there_is_no_verdict(tmp_path):
    store = Store(tmp_path)
    found = worked_out(store, shared_data("ferrari_250lm_race", "laps.parquet"))
    assert found["result"] == ""
    assert "no vehicle is given" in found["why"]
    reader = SeriesReader(store.path("series", found["series"]))
    time, values = reader.samples("yaw_rate")
    assert len(time) == len(values) == pytest.approx(27_500, abs=200)


def test_a_bus_log_without_database_leads_to_the_page(tmp_path):
    path = tmp_path / "can.log"
    path.write_text("".join(f"({n / 100:.6f}) can0 025#0000000000000000\n" for n in range(50)))
    with pytest.raises(InputError) as found:
        read(path)
    said = in_the_page(str(found.value))
    assert ": choose or upload it as CAN database under 'New recording', or name it in the vehicle file" in said
    assert "--dbc" in str(found.value)
    assert "--" not in said


def test_a_recording_without_vehicle_leads_to_the_page(tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text("time,yaw_rate [rad/s]\n" + "".join(f"{n / 100:.2f},0.{n}\n" for n in range(50)))
    with pytest.raises(ParameterError) as found:
        vehicle_named_in(path)
    assert "--vehicle" in str(found.value)
    assert (
        in_the_page(str(found.value))
        == "no vehicle is given, and the recording names none; choose one under 'judged as'"
    )
