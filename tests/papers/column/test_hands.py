"""The swept bench, the paper's observers on it, and scores of the hands."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.courses.bench import BenchHands
from tierod_lab.papers.column.benches import AMPLITUDE, HANDS, NOISE, STEP, demands, drawn, known_column, score, swept
from tierod_lab.papers.column.hand_datasets import Held, Natural, hand_torque, hands_on_and_off, natural_drives
from tierod_lab.papers.column.printed import PrintedObserver

COURSE, KNOWN = BenchHands(time=60.0, seed=8), known_column()


def test_the_bench_follows_its_sweep_with_the_noise_of_its_sensors():
    for hands in HANDS:
        run, wanted = swept(hands, 20.0, 1), demands(hands, 20.0, seed=1)
        np.testing.assert_allclose(run["motor_angle_mechanical"] / 18.0, wanted[:, 0], atol=0.1 * AMPLITUDE)
        np.testing.assert_allclose(run["hand_torque"], wanted[:, 3], atol=1e-12)
        assert np.abs(run["disturbance_torque"]).max() == pytest.approx(0.1, rel=1e-3)
    apart = swept("free", 20.0, 1)["driver_torque"] - swept("free", 20.0, 2)["driver_torque"]
    assert np.std(apart) == pytest.approx(math.sqrt(2.0) * NOISE["driver_torque"], rel=0.05)
    slope = np.gradient(wanted[:, 0], 1e-3)[2000:-10]
    np.testing.assert_allclose(slope, wanted[2000:-10, 1], atol=1e-2 * np.abs(wanted[:, 1]).max())
    assert np.count_nonzero(demands("steps", 40.0, seed=3)[:, 3] == 2.0) == pytest.approx(4_000, abs=2)


def test_the_paper_s_observers_are_equally_good_and_the_default_is_better():
    found = {row["observer"]: row["error"] for row in hand_torque(("steps", 11))}
    default = found.pop("default")
    assert list(found.values()) == pytest.approx([0.12] * 6, abs=0.01)
    assert default < 0.06


def test_an_observer_that_cannot_be_is_refused_and_a_reduced_one_works_where_the_gear_is_too_fast():
    stiff = replace(KNOWN, gear_inertia=1e-7)
    with pytest.raises(ParameterError, match="too fast for its rate"):
        PrintedObserver.of_column(stiff, "full")
    assert PrintedObserver.of_column(stiff, "series spring").filter is not None
    with pytest.raises(ParameterError, match="did you mean 'balanced'"):
        PrintedObserver.of_column(KNOWN, "balancd")


def perfect(delay):
    time = np.arange(0.0, 60.0, STEP)
    return (np.searchsorted(COURSE.switches, time - delay, side="right") % 2).astype(float)


def test_scores_count_delays_and_false_changes_but_no_doubts():
    hands = perfect(0.2)
    found = score(hands, COURSE)
    assert found.grabs == pytest.approx(0.2, abs=2 * STEP)
    assert found.releases == pytest.approx(0.2, abs=2 * STEP)
    assert (found.false_on, found.false_off) == (0, 0)
    middle = round(0.5 * sum(COURSE.switches[:2]) / STEP)
    hands[middle : middle + 50] = 0.5
    assert score(hands, COURSE).false_off == 0
    hands[middle : middle + 50] = 0.0
    assert (score(hands, COURSE).false_on, score(hands, COURSE).false_off) == (0, 1)
    assert np.all(np.isinf(score(np.zeros(60_000), COURSE).grabs))


def test_hands_of_a_bench_that_differs_by_its_share_are_found():
    bench = drawn(5, 0.1, 60.0)
    assert abs(bench.plant.wheel_inertia / 0.035 - 1.0) == pytest.approx(0.1)
    found = hands_on_and_off(Held("usual", 2000, 60.0))
    delays = [row["delay"] for row in found if row["event"] == "grab"]
    assert 0.0 < max(delays) < 500.0
    assert sum(row["wrong"] for row in found) == 0.0


@pytest.mark.slow
def test_hands_that_leave_the_wheel_of_a_car_are_found():
    drive, *releases = natural_drives(Natural("straight", "bench, 1000 Hz", 1, 60.0))
    assert drive["torque"] < 0.1
    assert drive["off_while_held"] == 0.0
    assert [row["release"] < 1.0 for row in releases] == [True, True]
