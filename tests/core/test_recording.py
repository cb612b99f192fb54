"""Recordings: faults of channels and time stamps are repaired or refused, tables of other libraries and back."""

import dataclasses
import importlib.util

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import InputError, MissingExtra
from tierod.core.findings import Diagnosis, Element, Estimate, Finding, Status
from tierod.core.recording import Channel, Recording, checked
from tierod.core.series import order, paced
from tierod.vehicles import load


def channel(name="yaw_rate", time=(0.0, 1.0, 2.0), values=(1.0, 2.0, 3.0), unit="rad/s", **more) -> Channel:
    return Channel(name, np.array(time, dtype=float), np.array(values, dtype=float), unit, **more)


def recording(*channels: Channel) -> Recording:
    return Recording({one.name: one for one in channels})


def test_infinite_values_become_missing_with_a_note():
    fit = checked(channel(values=(1.0, np.inf, 3.0), note="raw"))
    assert np.isnan(fit.values[1])
    assert fit.note == "raw; 1 infinite values taken as missing"


def test_alignment_leaves_gaps_and_absent_signals_missing():
    time = np.concatenate((np.arange(0.0, 1.0, 0.01), np.arange(3.0, 4.0, 0.01)))
    aligned = recording(channel(time=time, values=np.ones(200))).align(["yaw_rate", "vehicle_speed"], 100.0)
    assert np.isnan(aligned.values[:, 1]).all()
    gap = (aligned.time > 1.11) & (aligned.time < 2.99)
    assert np.isnan(aligned.values[gap, 0]).all()
    assert np.isfinite(aligned.values[~gap & (aligned.time < 1.08), 0]).all()


def test_a_grid_follows_the_samples_not_the_span():
    time = 10.0 * np.arange(10_000.0)
    slow = Recording({"a": Channel("a", time, time, "")})
    assert len(slow.align(["a"], 40.0).time) == 3_999_601
    with pytest.raises(InputError, match="from 0 s to 99990 s is too long.*count milliseconds"):
        slow.align(["a"], 50.0)


@given(
    st.sampled_from([50.0, 100.0, 1000.0]), st.sampled_from([20.0, 50.0, 100.0]), st.floats(-0.02, 0.3),
    st.sampled_from(["as they are", "jittered", "one lost", "twice the same"]),
)  # fmt: skip
def test_regular_clocks_align_as_a_search_for_every_time_does(rate, grid_rate, start, stamps):
    time = np.arange(round(4.0 * rate)) / rate
    if stamps == "jittered":
        time = np.sort(time + np.random.default_rng(1).uniform(0.0, 2.0 / rate, len(time)))
    elif stamps == "one lost":
        time = np.delete(time, len(time) // 2)
    elif stamps == "twice the same":
        time[len(time) // 3] = time[len(time) // 3 - 1]
    values = np.arange(len(time), dtype=float)
    aligned = recording(channel(time=time, values=values)).align(
        ["yaw_rate"], grid_rate, maximum_age=0.1, start=start, stop=3.5
    )
    for at, found in zip(aligned.time, aligned.columns["yaw_rate"], strict=True):
        before = np.flatnonzero(time <= at + 1e-6)
        held = len(before) and at - time[before[-1]] <= 0.1 + 1e-6
        assert found == values[before[-1]] if held else np.isnan(found)
    assert aligned.there["yaw_rate"].tolist() == np.isfinite(aligned.values[:, 0]).tolist()


def test_stamps_that_are_no_numbers_are_dropped():
    put = order(np.array([0.0, np.nan, 1.0, np.inf, 2.0]), "x")
    assert put.time.tolist() == [0.0, 1.0, 2.0]
    assert put(np.arange(5)).tolist() == [0, 2, 4]
    assert put.notes == ("2 samples without a time stamp left out",)


def test_late_samples_are_sorted():
    put = order(np.array([0.0, 0.02, 0.01, 0.03]), "x")
    assert put.time.tolist() == [0.0, 0.01, 0.02, 0.03]
    assert put(np.arange(4)).tolist() == [0, 2, 1, 3]
    assert "1 samples that arrived late" in put.notes[0]
    assert put.behind == pytest.approx(0.01)


def test_a_clock_set_back_is_refused():
    with pytest.raises(
        InputError,
        match=r"time of x jumps back from 5\.0+ s to 1\.0+ s at sample 3; .*cut the.*if a counter rolled over",
    ):
        order(np.array([0.0, 5.0, 1.0, 2.0]), "x")


def test_a_clock_that_stands_still_is_refused():
    with pytest.raises(InputError, match="stands still at 3 s for all 4 samples"):
        order(np.full(4, 3.0), "x")


@pytest.mark.parametrize("drift", [-2e-4, 2e-4])
def test_a_drifting_clock_is_followed(drift):
    sent = 0.01 * (1.0 + drift) * np.arange(20000)
    polls = np.cumsum(np.random.default_rng(3).uniform(0.005, 0.035, 20000))
    delivered = polls[np.searchsorted(polls, sent)]
    assert np.abs(delivered - sent).max() > 0.03
    assert np.abs(paced(delivered, 0.01) - sent)[:19800].max() < 0.004


def table():
    fast, slow = np.arange(20) / 100.0, np.array([0.0, 0.045, 0.1, 0.1])
    values = np.sin(fast)
    values[3] = np.nan
    return Recording({}).with_channels(
        [
            Channel("yaw_rate", fast, values, "rad/s", "ESP.YawRate", "sign turned"),
            Channel("driver_torque", fast, 2.0 * values, "N*m"),
            Channel("vehicle_speed", slow, np.array([10.0, np.nan, 11.0, 12.0]), "m/s"),
        ]
    )


def same(found, wanted, missing=True, about=True):
    assert found.names == wanted.names
    for name, channel in wanted.channels.items():
        kept = np.ones(len(channel.time), bool) if missing else np.isfinite(channel.values)
        np.testing.assert_array_equal(found[name].time, channel.time[kept])
        np.testing.assert_array_equal(found[name].values, channel.values[kept])
        if about:
            assert dataclasses.replace(found[name], time=0, values=0) == dataclasses.replace(channel, time=0, values=0)


def test_arrow_and_back_keeps_everything():
    whole = table().to_arrow()
    assert whole.column_names == ["time", "yaw_rate", "driver_torque", "vehicle_speed"]
    assert whole["vehicle_speed"].null_count == len(whole) - 4
    found = Recording.from_arrow(whole)
    same(found, table())
    assert found["yaw_rate"].time is found["driver_torque"].time


def test_pandas_and_back():
    whole = table()
    frame = whole.to_pandas()
    assert frame.index.name == "time"
    same(Recording.from_pandas(frame), whole, missing=False)
    alike = Recording({name: whole[name] for name in ("yaw_rate", "driver_torque")})
    same(Recording.from_pandas(alike.to_pandas()), alike)


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        (pa.table({"tim": [0.0], "a": [1.0]}), "no column 'time'; did you mean 'tim'"),
        (pa.table({"time": [0.0], "a": ["x"]}), "the column 'a' is of the type string; expected numbers"),
        ([1, 2], "has no Arrow interface"),
    ],
)
def test_what_is_no_recording_is_refused(table, sentence):
    with pytest.raises(InputError, match=sentence):
        Recording.from_arrow(table)


@pytest.mark.parametrize("name", ["pandas"])
def test_without_the_library_a_sentence_names_it(name, monkeypatch):
    load_module = importlib.import_module

    def without(module, *more):
        if module == name:
            raise ImportError(name)
        return load_module(module, *more)

    monkeypatch.setattr(importlib, "import_module", without)
    with pytest.raises(MissingExtra, match=rf"'{name}'.*pip install 'tierod\[frames\]'"):
        getattr(table(), f"to_{name}")()


@pytest.mark.parametrize("name", ["polars", "xarray"])
def test_other_libraries_and_back(name):
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    frame = getattr(table(), f"to_{name}")()
    found = getattr(Recording, f"from_{name}")(frame)
    same(found, table(), missing=name == "polars", about=name == "xarray")


SIZE = Estimate("friction torque", 8.1, 0.25, "N*m")
FINDING = Finding("friction", Status.FAULT, "Friction is <high>.", 12.5, SIZE, cause="dry joint", action="grease it")


@pytest.mark.parametrize(
    ("shown", "words"),
    [
        (table(), ["3 channels", "yaw_rate", "vehicle_speed", "samples"]),
        (FINDING, ["friction: fault", "8.1 N·m", "± 0.25", "dry joint", "grease it", "since 12.5 s"]),
        (Diagnosis((FINDING,), (Element("yaw_rate", "sensor", Status.HEALTHY),)), ["fault", "yaw_rate", "healthy"]),
        (load("midsize-eps"), ["Vehicle midsize-eps", "mass", "kg", "... and"]),
    ],
)
def test_an_object_shows_one_screen(shown, words):
    text, page = repr(shown), shown._repr_html_()
    assert text.count("\n") < 40
    for word in words:
        assert word in text
        assert word in page
    assert "<high>" not in page
