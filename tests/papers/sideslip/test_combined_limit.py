"""How a ramp on a slippery road is judged."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tierod_lab.papers.sideslip import combined_limit
from tierod_lab.papers.sideslip.combined_limit import Ramp, false_ice


def ramp(announced):
    time = np.arange(0.0, 30.0, 0.01)
    share = np.clip((time - 15.0) / 10.0, 0.0, 1.0)
    return Ramp(SimpleNamespace(time=time), None, share, 24.8, announced)


def test_the_lead_is_the_time_from_the_announcement_to_the_peak():
    early = ramp(23.0)
    assert early.lead == pytest.approx(1.8)
    assert early.share_then == pytest.approx(0.8)
    assert ramp(25.5).lead == pytest.approx(-0.7)


def test_a_peak_that_is_never_announced_has_no_lead():
    never = ramp(math.inf)
    assert never.lead == -math.inf
    assert math.isnan(never.share_then)


def test_false_ice_is_a_friction_below_the_road_s(monkeypatch):
    time = np.arange(0.0, 10.0, 0.01)
    road = np.where(time < 5.0, 1.0, 0.35)
    estimate = {"friction": np.where((time >= 2.0) & (time < 3.0), 0.5, road)}
    drive = SimpleNamespace(time=time, truth=lambda name: {"road_friction": road}[name])
    monkeypatch.setattr(combined_limit, "on", lambda name, seed: drive)
    monkeypatch.setattr(combined_limit, "estimated", lambda drive, readings: estimate)
    least, below, total = false_ice((1, 2), "all")
    assert least == pytest.approx(0.5)
    assert below == pytest.approx(2.0)
    assert total == pytest.approx(20.0)
