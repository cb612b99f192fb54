"""The level of one very vehicle, kept from recording to recording."""

import dataclasses

import pytest

from driven import drive
from exact_vehicle import diagnose
from tierod.core.errors import InputError
from tierod.core.findings import Status
from tierod.monitors.baseline import Baseline, load_baseline

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
