"""Datasets of the study in a small size, against what must come out."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from shared_data import shared_data
from tierod_lab.papers.sideslip import combined_datasets, observer_datasets, real_datasets
from tierod_lab.papers.sideslip.drives import FAST, matched

TIME = np.arange(2000) / 100.0


def test_circles_find_the_stiffnesses_of_brush_tyres_and_their_trail():
    p = matched("brush tyres", FAST)
    assert p.front_cornering_stiffness == pytest.approx(100e3, rel=0.1)
    assert p.rear_cornering_stiffness == pytest.approx(140e3, rel=0.1)
    assert p.mechanical_trail + p.pneumatic_trail == pytest.approx(0.023 + 0.09 / 3.0, rel=0.15)


@pytest.mark.parametrize(("ratio", "ranks"), [(1.0, [1, 2, 4]), (0.95, [2, 2, 4])])
def test_in_neutral_steer_the_yaw_rate_does_not_hang_on_the_sideslip(ratio, ranks):
    found = observer_datasets.neutral_steer((ratio, 25.0))
    assert [row["rank"] for row in found] == ranks
    assert found[0]["margin"] == pytest.approx(0.0, abs=1e-9 if ratio == 1.0 else 0.05)


def test_the_observers_follow_the_paper_s_test():
    found = {row["observer"]: row for row in observer_datasets.driven_test(3)}
    assert found["two-stage, Kalman"]["correlation"] > 0.98
    assert found["eq (3)"]["torque_miss"] > found["disturbance observer"]["torque_miss"]


def against(announced):
    share = np.clip((TIME - 15.0) / 2.0, 0.0, 1.0)
    drive = SimpleNamespace(time=TIME, truth=lambda name: 2790.0 * share)
    return combined_datasets.against_the_peak(drive, {"limit_ahead": np.where(announced <= TIME, 1.0, 0.0)})


def test_a_peak_is_announced_before_it_or_never():
    peak, announced = against(16.0)
    assert peak - announced == pytest.approx(0.96, abs=0.02)
    assert against(math.inf)[1] == math.inf


def test_false_ice_and_false_announcements_are_those_of_the_road(monkeypatch):
    road = np.where(TIME < 10.0, 1.0, 0.35)
    truths = {"road_friction": road, "front_lateral_force": 0.3 * 7900.0 * road}
    friction, ahead = np.where((TIME >= 2.0) & (TIME < 3.0), 0.5, road), np.where(TIME < 0.5, 1.0, 0.0)
    monkeypatch.setattr(
        combined_datasets, "on", lambda name, seed: SimpleNamespace(time=TIME, truth=truths.__getitem__)
    )
    monkeypatch.setattr(
        combined_datasets, "estimated", lambda drive, readings: {"friction": friction, "limit_ahead": ahead}
    )
    row, _ = combined_datasets.quiet(("mixed", 1))
    assert (row["ice"], row["announced"], row["seconds"]) == pytest.approx((1.0, 0.5, 20.0))


def test_race_laps_are_estimated_better_than_by_simple_means(monkeypatch, tmp_path):
    monkeypatch.setenv("TIEROD_DATA", str(tmp_path))
    assert real_datasets.race_laps(False) == []
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("ferrari_250lm_race").parent))
    found = {row["estimator"]: row["rms"] for row in real_datasets.race_laps(False)}
    assert found.pop("combined") < 0.2
    assert min(found.values()) > 0.4
