"""Datasets of the study in a small size, against what must come out."""

import numpy as np
import pytest

from shared_data import shared_data
from tierod_lab.papers.motor_angle import identification_datasets, monitor_datasets, observer_datasets
from tierod_lab.papers.motor_angle import robustness_datasets as robustness
from tierod_lab.papers.motor_angle.monitor_datasets import AngleCase, Course
from tierod_lab.papers.motor_angle.robustness_datasets import MOVING, STILL, Case, held_drive, time_until_right
from tierod_lab.papers.motor_angle.salient_bench import LOAD, fast_drive, salient_bench, stepping_load
from tierod_lab.studies.metrics import Frame


def test_the_bench_shows_the_error_that_the_gains_promise():
    found = {row["observer"]: row for row in observer_datasets.loaded(11)}
    assert found["full"]["predicted"] == pytest.approx(-25.73, abs=0.01)
    assert found["reduced"]["predicted"] == pytest.approx(-27.78, abs=0.01)
    assert found["held still"]["predicted"] == pytest.approx(0.05 / 6.0 * 0.6 / 0.051 / 0.034)
    assert max(found[name]["miss"] for name in ("full", "reduced", "held still")) < 0.02
    assert found["full, with load"]["size"] < 0.05


def test_the_feedforward_is_better_the_faster_the_motor_and_the_printed_sign_turns_it():
    slow, quick = (observer_datasets.fast((31, speed))[0] for speed in (10.0, 60.0))
    assert quick["error"] < 0.3 * slow["error"] < 0.05
    assert quick["turned"] == pytest.approx(np.arctan(2.0 * 1e-4 * 12.0 / 0.0085), rel=0.03)


def test_operations_stand_beside_the_printed_ones():
    found = {row["observer"]: row for row in observer_datasets.operations(None)}
    assert {name: row["printed"] for name, row in found.items()} == observer_datasets.PRINTED_PRODUCTS
    assert found["Luenberger"]["bare"] == 19


@pytest.mark.parametrize("kind", ["drawn", "warm", "warming"])
def test_motors_that_differ_are_followed(kind):
    (row,) = robustness.accuracy(Case(kind, 650, 6.0))
    assert 0.0 < row["rms"] < 0.006


def test_a_resistance_that_is_not_learnt_costs_the_angle():
    (fixed,) = robustness.accuracy(Case("warm, not learnt", 650, 6.0))
    (learnt,) = robustness.accuracy(Case("warm", 650, 6.0))
    assert fixed["rms"] > 5.0 * learnt["rms"]


def test_a_hot_motor_raises_no_alarm():
    (row,) = robustness.accuracy(Case("temperature", 900, 8.0, 120.0))
    assert row["case"] == "120 °C"
    assert row["rms"] < 0.006
    assert row["alarmed"] == 0.0


@pytest.mark.slow
def test_a_wrong_knee_is_learnt_and_said():
    found = {row["knows"]: row for row in robustness.commanded((4900, 4901, 8.0))}
    assert found["command taken for the voltage"]["rms"] > 1.0
    assert found["knee 2 A, held"]["rms"] > 3.0 * found["loss and knee identified"]["rms"]
    assert [found[f"knee {knee:g} A, learnt"]["said"] for knee in (0.5, 1.0, 2.0)] == [1.0, 0.0, 1.0]


def test_the_motor_is_held_against_a_load_and_turns_on():
    seen = held_drive(1)
    still = (seen.time > MOVING + 0.5) & (seen.time < MOVING + STILL)
    assert np.abs(seen.speed[still]).max() < 0.1
    assert np.abs(seen.load[still]).mean() == pytest.approx(0.8, abs=0.05)
    for row in robustness.standstill(1):
        assert row["drift"] < 1e-4
        assert row["growth"] > 1.5
        assert row["known_again"] < 50.0


def test_a_small_wrong_beginning_is_gone_soon_and_what_returns_is_not():
    wrong = np.zeros(5000, dtype=bool)
    wrong[:300] = wrong[800] = True
    assert time_until_right(wrong) == pytest.approx(0.0801)
    assert time_until_right(~wrong) == np.inf
    (row,) = robustness.beginnings(("from rest", 5, 5, (0.3,)))
    assert row["time"] < 0.1


@pytest.mark.slow
def test_three_angles_are_told_apart():
    (fault_free,) = monitor_datasets.three_angles(AngleCase("slalom", 40))
    assert (fault_free["found"], fault_free["early"]) == (0.0, 0.0)
    (wheel,) = monitor_datasets.three_angles(AngleCase("slalom", 40, "wheel, recorded", "drift"))
    assert (wheel["found"], wheel["by_motion"], wheel["named"]) == (1.0, 0.0, 1.0)
    assert 0.3 < wheel["delay"] < 1.5


def test_a_load_stands_and_steps_and_a_fast_drive_weakens_the_flux():
    load = stepping_load(20.0, 3)
    assert np.abs(np.diff(load)).max() == pytest.approx(LOAD)
    seen = fast_drive(3.0, 1, 20.0)
    own = (seen.samples[:, 0] + 1j * seen.samples[:, 1]) * np.exp(-4j * seen.angle)
    quick = np.abs(seen.speed) > 155.0
    assert own.real[quick].min() < -5.0
    machine = salient_bench(3.0).motor.machine
    assert machine.inductance_q / machine.inductance_d == pytest.approx(3.0)
    (row,) = monitor_datasets.salient(Course(3.0, 41))
    assert row["rms"] < 0.004


def test_white_residuals_alarm_as_often_as_designed():
    (row,) = monitor_datasets.run_length((1, 100.0, 200_000))
    assert row["alarms"] > 1000
    assert row["miss"] < 10.0


@pytest.mark.slow
def test_an_identified_motor_is_right_and_its_intervals_hold():
    found = Frame.of("identified", identification_datasets.identified((701, 5.0)))
    assert np.abs(found.where({"error": "-1 to 1"})["error"]).max() < 0.03
    assert found.where({"parameter": "angle"})["over_true"][0] < 1.1
    assert all(row["holds"] for row in identification_datasets.guaranteed(701))


def test_a_real_drive_whose_current_counts_outwards_is_recognised(monkeypatch, tmp_path):
    monkeypatch.setenv("TIEROD_DATA", str(tmp_path))
    assert identification_datasets.real_drive("dragged") == []
    monkeypatch.setenv("TIEROD_DATA", str(shared_data("pmsm_drive").parent))
    found = {row["what"]: row for row in identification_datasets.real_drive("dragged")}
    assert found["current sign"]["said"] == 1.0
    assert found["flux observer"]["deviation"] < 0.03
    (friction,) = identification_datasets.real_drive("friction")
    assert friction["over_recorded"] == pytest.approx(1.0, abs=0.05)
