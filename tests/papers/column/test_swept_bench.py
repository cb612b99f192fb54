"""The swept bench, and the errors of observers on it."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.block import Ring
from tierod.monitors.driver_torque.observer import ColumnSample
from tierod_lab.papers.column.hand_datasets import SENSORS, hand_torque, wrong_columns
from tierod_lab.papers.column.swept_bench import (
    AMPLITUDE,
    HANDS,
    NOISE,
    SIGNALS,
    demands,
    errors,
    samples,
    swept,
)


def test_the_bench_follows_its_sweep_whatever_the_hands_do():
    for hands in HANDS:
        run, wanted = swept(hands, 20.0, 1), demands(hands, 20.0, seed=1)
        np.testing.assert_allclose(run["motor_angle_mechanical"] / 18.0, wanted[:, 0], atol=0.1 * AMPLITUDE)
        np.testing.assert_allclose(run["hand_torque"], wanted[:, 3], atol=1e-12)
        assert np.abs(run["disturbance_torque"]).max() == pytest.approx(0.1, rel=1e-3)


@pytest.mark.parametrize("pace", ["octaves", "linear"])
def test_demands_are_derivatives_of_each_other(pace):
    wanted = demands("free", 10.0, 1e-4, pace=pace)
    for k in range(2):
        slope = np.gradient(wanted[:, k], 1e-4)
        away = np.abs(slope - wanted[:, k + 1])[20_000:-10]
        assert away.max() < 1e-3 * np.abs(wanted[:, k + 1]).max()


def test_noise_is_that_of_the_sensors_and_of_the_seed():
    run, again, other = swept("free", 5.0, 1), swept("free", 5.0, 1), swept("free", 5.0, 2)
    np.testing.assert_array_equal(run["driver_torque"], again["driver_torque"])
    difference = run["driver_torque"] - other["driver_torque"]
    assert np.std(difference) == pytest.approx(math.sqrt(2.0) * NOISE["driver_torque"], rel=0.05)


def test_hands_pull_twice_for_a_tenth_of_the_run():
    torque = demands("steps", 40.0, seed=3)[:, 3]
    assert np.count_nonzero(torque == 2.0) == pytest.approx(4_000, abs=2)
    assert np.count_nonzero(torque == -2.0) == pytest.approx(4_000, abs=2)
    assert np.abs(np.diff(demands("ramps", 40.0, seed=3)[:, 3])).max() <= 2.0 / 100 + 1e-9


class Estimate(NamedTuple):
    hand_torque: float


@dataclass(frozen=True)
class LateBar:
    samples: int

    Sample = ColumnSample

    def init(self):
        return Ring(self.samples, math.nan)

    def step(self, state, sample):
        return state.push(sample.driver_torque), Estimate(state.oldest)


def test_errors_take_the_lag_into_account():
    drive = swept("ramps", 10.0, 11)
    true = drive["hand_torque"]

    def with_hands(given):
        changed = given.copy()
        changed[:, 3] = true
        return changed

    block = LateBar(3)
    found = errors(block, [drive], 3, with_hands)
    assert found.hand_torque == 0.0
    assert math.isnan(found.nis)
    assert math.isnan(found.disturbance_torque)
    assert errors(block, [drive], 0, with_hands).hand_torque > 0.0


def test_sensors_that_are_not_as_trusted_change_their_own_column():
    given = swept("free", 5.0, 11)
    before = samples(given)
    for what, (change, _) in SENSORS.items():
        after = change(before)
        column = SIGNALS.index("driver_torque" if "bar" in what else "motor_torque")
        np.testing.assert_array_equal(np.delete(after, column, 1), np.delete(before, column, 1))
        assert np.any(after[:, column] != before[:, column])
    late = SENSORS["bar's torque 1 ms late"][0](before)[:, 3]
    np.testing.assert_array_equal(late[1:], before[:-1, 3])


def test_the_default_is_better_than_the_printed_observers_and_a_wrong_inertia_costs():
    found = {row["observer"]: row for row in hand_torque(("ramps", 11))}
    assert found["default"]["error"] < 0.04 < found["paper: full"]["error"]
    assert found["20 ms later"]["error"] < found["default"]["error"]
    assert found["friction by its law, level half"]["disturbance"] < 0.3 * found["default"]["disturbance"]
    (wrong,) = wrong_columns(("steering wheel inertia +10 %", "ramps", 11))
    assert wrong["kind"] == "parameter"
    assert wrong["error"] > 2.0 * found["default"]["error"]
