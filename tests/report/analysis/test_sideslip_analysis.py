"""The analysis of a car steered by wire, as users get it."""

from __future__ import annotations

import pytest

from tierod.core.errors import ParameterError
from tierod.report.analysis import SUBJECTS
from tierod.vehicles import load


def test_it_shows_modes_and_ranks_over_understeer_and_speed():
    found = SUBJECTS["sideslip"].analyse(load("steer-by-wire"), None)
    modes, ranks = found.items
    assert "-19.82 ± 0.66i" in modes.rows[1][1]
    neutral = [row for row in ranks.rows if row[0] == "1"]
    assert {row[3] for row in neutral} == {"1 of 2"}
    assert {row[4] for row in ranks.rows} == {"2 of 2"}
    assert found.document["rear_over_neutral"] == pytest.approx(140e3 * 1.31 / (100e3 * 1.33))


def test_a_car_that_is_not_steered_by_wire_lacks_parameters_and_is_reported_which():
    with pytest.raises(ParameterError, match="road_wheel_inertia"):
        SUBJECTS["sideslip"].analyse(load("midsize-eps"), None)
