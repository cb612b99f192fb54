"""Recordings of real cars in the store: a bus log with its database, a table without vehicle, what is none."""

import json

import pytest

from shared_data import shared_data
from tierod.core.errors import InputError
from tierod.web.analysing import Reading, analyse
from tierod.web.series import SeriesReader
from tierod.web.store import Store


def analysed(store, path, vehicle=""):
    return analyse(store, Reading(path), vehicle, False, lambda *words, **more: None)


def test_a_bus_log_is_read_and_judged_as_its_vehicle(tmp_path):
    store, path = Store(tmp_path), shared_data("rav4_highway_minute", "can.log")
    found = analysed(store, path, "rav4")
    reader = SeriesReader(store.path("series", found["series"]))
    assert {"driver_torque", "steering_wheel_angle", "wheel_speed_front_left"} <= set(reader.signals)
    result = json.loads((store.path("results", found["result"]) / "result.json").read_text())
    assert result["monitors"]["friction"]["findings"][0]["status"] == "not identifiable"
    with pytest.raises(InputError, match="DBC"):
        analysed(store, path)


def test_a_table_without_vehicle_shows_its_signals_and_says_why_there_is_no_verdict(tmp_path):
    store = Store(tmp_path)
    found = analysed(store, shared_data("ferrari_250lm_race", "laps.parquet"))
    assert found["result"] == ""
    assert "no vehicle is given" in found["why"]
    reader = SeriesReader(store.path("series", found["series"]))
    time, values = reader.samples("yaw_rate")
    assert len(time) == len(values) == pytest.approx(27_500, abs=200)


def test_what_is_no_recording_is_a_sentence(tmp_path):
    path = tmp_path / "README.md"
    path.write_text("# Not a recording\n\nSome words.\n")
    with pytest.raises(InputError, match="no table of numbers"):
        analysed(Store(tmp_path / "cache"), path, "midsize-eps")
