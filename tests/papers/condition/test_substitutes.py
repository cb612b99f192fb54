"""Errors of the substitutes: of plain relations by hand, of the filter from the declaration to the end of the fault."""

import numpy as np
import pytest

from tierod.monitors.condition.reaction import FILTER, substitution_graph
from tierod.vehicles import load
from tierod_lab.papers.condition.by_bank import Known
from tierod_lab.papers.condition.drives import OFFSET, Drive, Injected
from tierod_lab.papers.condition.recorded import fault_free, recorded
from tierod_lab.papers.condition.substitutes import SETTLED, _root, _squares

CAR = load("smartload")


def test_a_plain_relation_errs_by_what_it_is_off():
    drive = Drive("short-round", 24.0, 0, 5)
    recording = recorded(drive)
    found = _squares({0: Known(CAR)}, drive, recording)
    assert {key[:2] for key in found} == {
        (sensor, way.name)
        for sensor, ways in substitution_graph().substitutes.items()
        for way in ways
        if way.name != FILTER
    }
    left, right = (recording[f"wheel_speed_rear_{side}"].values for side in ("left", "right"))
    error = (right - left) / CAR["track_width"] - fault_free("yaw_rate", recording, drive.driven.sensors)
    key = ("yaw_rate", "rear-wheels", False)
    assert found[key] == (pytest.approx(np.sum(error[SETTLED:] ** 2)), 2400 - SETTLED)
    assert _root([found, found], *key) == pytest.approx(np.sqrt(np.mean(error[SETTLED:] ** 2)))


def test_the_filter_counts_while_its_sensor_is_declared():
    fault = Injected("wheel_speed_rear_left", OFFSET, 2.0, start=10.0, end=16.0)
    drive = Drive("short-round", 24.0, 0, 5, (fault,))
    found = _squares({0: Known(CAR)}, drive, recorded(drive))
    assert set(found) == {("wheel_speed_rear_left", FILTER, which) for which in (True, False)}
    squares, count = found["wheel_speed_rear_left", FILTER, True]
    assert 500 < count <= 600
    assert np.sqrt(squares / count) < 0.4
