"""The level of one very vehicle, kept from recording to recording."""

import dataclasses
import os

import numpy as np
import pytest

from driven import drive
from exact_vehicle import diagnose
from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Status
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write
from tierod.monitors.acceptance import other_vehicle, vehicle_named_in
from tierod.monitors.baseline import Baseline, load_baseline
from tierod_lab.ground.scenarios import load

LEVEL = Baseline("midsize-eps", "friction, pre-sliding", 4.0, 0.1, "N*m", 100.0, "2026-01-01T00:00:00+00:00")


def test_a_healthy_recording_stores_it_and_a_later_one_is_judged_against_it(tmp_path):
    path = tmp_path / "level.json"
    first = diagnose(drive(minutes=8.0, friction=2.0, seed=2), "midsize-eps", baseline=path)
    assert first.findings[0].status is Status.HEALTHY
    stored = load_baseline(path)
    assert stored.value == pytest.approx(2.0, abs=0.1)
    assert stored.learnt == first.created
    later = diagnose(drive(minutes=5.0, friction=3.8, seed=3), "midsize-eps", baseline=path).findings[0]
    assert later.status is Status.FAULT, "3.8 N·m is below every limit of the vehicle file"
    assert load_baseline(path) == stored


def test_a_faulty_recording_stores_nothing(tmp_path):
    path = tmp_path / "level.json"
    diagnosis = diagnose(drive(minutes=5.0, friction=12.0, seed=2), "midsize-eps", baseline=path)
    assert diagnosis.findings[0].status is Status.FAULT
    assert not path.exists()


@pytest.mark.parametrize(
    ("field", "value", "sentence"),
    [("vehicle", "rav4", "learnt for the vehicle 'rav4'"), ("monitor", "friction, refined", "learnt for the monitor")],
)
def test_a_foreign_level_is_refused(field, value, sentence):
    with pytest.raises(InputError, match=sentence):
        diagnose(drive(minutes=1.0), "midsize-eps", baseline=dataclasses.replace(LEVEL, **{field: value}), spread=False)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"schema": "tierod.baseline/1",', "not JSON from line 1 on"),
        ('{"schema": "tierod.baseline/2"}', "its schema is not tierod.baseline/1"),
        ('{"schema": "tierod.baseline/1", "value": 1}', "deviation, monitor, seconds, unit, vehicle is missing"),
    ],
)
def test_a_damaged_baseline_is_refused(tmp_path, text, reason):
    path = tmp_path / "level.json"
    path.write_text(text)
    with pytest.raises(InputError, match=f"is not a baseline that tierod stored .*{reason}.*remove it to learn anew"):
        load_baseline(path)


@pytest.mark.parametrize("text", ["", "{", "{}", '{"schema": "other/1"}', "[1]", "name = 'car'"])
def test_a_file_that_is_no_baseline_is_refused_and_nobody_is_told_to_remove_it(tmp_path, text):
    path = tmp_path / "car.toml"
    path.write_text(text)
    with pytest.raises(InputError, match="is no baseline") as refused:
        load_baseline(path)
    assert "remove" not in str(refused.value)
    assert path.read_text() == text


def recording(**metadata):
    time = np.arange(100) * 0.01
    return Recording({"yaw_rate": Channel("yaw_rate", time, np.sin(time), "rad/s")}, metadata)


def test_a_virtual_car_is_judged_with_the_vehicle_of_its_name(tmp_path):
    made = recording(virtual_car="midsize-eps", vehicle={"mass": 1600.0})
    assert vehicle_named_in(made) == "midsize-eps"
    path = tmp_path / "drive.parquet"
    write(made, path)
    assert vehicle_named_in(path) == "midsize-eps"


def test_a_virtual_car_of_another_name_shows_the_vehicle_with_which_it_is_judged(tmp_path):
    drive = load("demonstrator-lap").with_run(seconds=1.0).run().recording
    assert vehicle_named_in(drive) == "smartload"
    assert other_vehicle(drive.metadata, "smartload") is None
    assert "made with the vehicle 'smartload'" in (other_vehicle(drive.metadata, "rav4") or "")
    with pytest.raises(InputError, match="made with the vehicle 'smartload'.*judge it with --vehicle smartload"):
        diagnose(drive, vehicle="midsize-eps", monitor="friction")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_is_not_read_for_the_name_of_a_vehicle_since_it_could_not_be_read_again(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="is a pipe, which can be read once only; give --vehicle"):
        vehicle_named_in(tmp_path / "pipe")


@pytest.mark.parametrize(
    ("metadata", "sentence"), [({}, "names none"), ({"virtual_car": "my-car"}, "names 'my-car', which tierod does not")]
)
def test_where_it_names_none_that_is_shipped_the_user_must(metadata, sentence):
    with pytest.raises(ParameterError, match=sentence):
        vehicle_named_in(recording(**metadata))
