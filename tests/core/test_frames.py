"""Recordings as tables of other libraries and back, and what is shown of results."""

import builtins
import importlib.util

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from tierod.core.errors import InputError, MissingExtra
from tierod.core.findings import Diagnosis, Element, Estimate, Finding, Status
from tierod.core.recording import Channel, Recording
from tierod.vehicles import load


def recording():
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
            assert (found[name].unit, found[name].source, found[name].note) == (
                channel.unit,
                channel.source,
                channel.note,
            )


def test_arrow_and_back_keeps_everything():
    table = recording().to_arrow()
    assert table.column_names == ["time", "yaw_rate", "driver_torque", "vehicle_speed"]
    assert table["vehicle_speed"].null_count == len(table) - 4
    found = Recording.from_arrow(table)
    same(found, recording())
    assert found["yaw_rate"].time is found["driver_torque"].time


def test_any_library_reads_the_capsule():
    same(Recording.from_arrow(pa.table(recording())), recording())
    same(Recording.from_arrow(pa.RecordBatchReader.from_stream(recording()).read_all()), recording())


def test_pandas_and_back():
    whole = recording()
    frame = whole.to_pandas()
    assert frame.index.name == "time"
    same(Recording.from_pandas(frame), whole, missing=False)
    alike = Recording({name: whole[name] for name in ("yaw_rate", "driver_torque")})
    same(Recording.from_pandas(alike.to_pandas()), alike)


def test_a_frame_of_ones_own():
    frame = pd.DataFrame({"time": [0.0, 0.1], "yaw_rate": [0.0, np.nan], "n": [1, 2]})
    for found in (
        Recording.from_pandas(frame, units={"yaw_rate": "rad/s"}),
        Recording.from_arrow(pa.table(frame.fillna(7.0)), units={"yaw_rate": "rad/s"}),
    ):
        assert found["yaw_rate"].unit == "rad/s"
        assert len(found["yaw_rate"].values) == 2
        assert found["n"].values.tolist() == [1.0, 2.0]
    dated = frame.drop(columns="time").set_index(pd.to_datetime(["2024-01-01 00:00:00.0", "2024-01-01 00:00:00.1"]))
    np.testing.assert_allclose(Recording.from_pandas(dated)["n"].time, [0.0, 0.1])


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


def test_a_channel_called_time_is_refused():
    stamps = np.arange(2.0)
    with pytest.raises(InputError, match="rename it"):
        Recording({"time": Channel("time", stamps, stamps, "s")}).to_pandas()


@pytest.mark.parametrize("name", ["pandas", "polars", "xarray"])
def test_without_the_library_a_sentence_names_it(name, monkeypatch):
    load_module = importlib.import_module

    def without(module, *more):
        if module == name:
            raise ImportError(name)
        return load_module(module, *more)

    monkeypatch.setattr(importlib, "import_module", without)
    with pytest.raises(MissingExtra, match=rf"'{name}'.*pip install 'tierod\[frames\]'"):
        getattr(recording(), f"to_{name}")()


@pytest.mark.parametrize("name", ["polars", "xarray"])
def test_other_libraries_and_back(name):
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    frame = getattr(recording(), f"to_{name}")()
    found = getattr(Recording, f"from_{name}")(frame)
    same(found, recording(), missing=name == "polars", about=name == "xarray")


FINDING = Finding(
    "friction",
    Status.FAULT,
    "Friction is <high>.",
    12.5,
    Estimate("friction torque", 8.1, 0.25, "N*m"),
    cause="dry joint",
    action="grease it",
)


@pytest.mark.parametrize(
    ("shown", "words"),
    [
        (recording(), ["3 channels", "yaw_rate", "vehicle_speed", "samples"]),
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
        assert word in builtins.str(page)
    assert "<high>" not in page


def test_an_empty_recording_shows_itself():
    assert "0 channels" in repr(Recording({}))
