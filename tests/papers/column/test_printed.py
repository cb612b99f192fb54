"""The observers of the paper."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import rms, run
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.steering_column import ColumnParameters
from tierod.vehicles import load
from tierod_lab.papers.column.printed import COLUMNS, PrintedObserver, reduced

KNOWN = load("column-bench").parameters_for(ColumnParameters)


@pytest.mark.parametrize("column", COLUMNS)
def test_full_and_reduced_are_equally_good(column):
    measured, true = run("steps")
    found = scan(PrintedObserver.of_column(KNOWN, column), measured)
    used = true["time"] > 0.5
    assert rms((found["hand_torque"] - true["hand_torque"])[used]) == pytest.approx(0.12, abs=0.01)
    assert rms((found["steering_wheel_rate"] - true["steering_wheel_rate"])[used]) < 0.04
    assert rms((found["steering_wheel_angle"] - true["steering_wheel_angle"])[used]) < np.radians(0.1)


def test_eigenvalues_of_the_reduced_columns():
    series = np.linalg.eigvals(reduced(KNOWN, "series spring").A)
    balanced = np.linalg.eigvals(reduced(KNOWN, "balanced").A)
    for value in (0.0, -8.11, -3.79 + 79.24j):
        assert np.abs(series - value).min() < 0.01
    assert np.abs(balanced - (-3.8399 + 79.658j)).min() < 1e-4 * 79.7


def test_a_reduced_observer_works_where_its_full_one_is_too_fast():
    stiff = replace(KNOWN, gear_inertia=1e-7)
    with pytest.raises(ParameterError, match="too fast for its rate"):
        PrintedObserver.of_column(stiff, "full")
    assert PrintedObserver.of_column(stiff, "series spring").filter is not None


def test_an_unknown_column_is_named():
    with pytest.raises(ParameterError, match="did you mean 'balanced'"):
        PrintedObserver.of_column(KNOWN, "balancd")
