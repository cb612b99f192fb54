"""Faults in recordings of real cars: found and named by the rules, silence without them."""

from __future__ import annotations

import os

import pytest

from shared_data import shared_data
from tierod.studies.condition.real_cars import judged
from tierod.studies.condition.real_recordings import CARS, DATA
from tierod.studies.condition.summary import isolated, summary


@pytest.mark.parametrize(("car", "named"), [(CARS[0], 0.95), (CARS[1], 0.85)], ids=["rav4", "passenger-car"])
def test_faults_put_into_a_real_recording_are_found_and_named_and_nothing_else(car, named, monkeypatch):
    if car.dbc:
        pytest.importorskip("cantools")
    monkeypatch.setenv(DATA, os.fspath(shared_data(*car.file).parents[1]))
    quiet, found = judged(car, car.recording())
    assert quiet.false_alarms == 0
    told = isolated(found)
    assert told.wrong == 0.0
    assert told.right >= named
    assert summary(found).wrong < 0.01
