"""Values that no vehicle reaches are left out and named; wrong ones that a sensor may give are not."""

import numpy as np

from tierod.monitors.condition.recording_checks.impossible import Impossible
from tierod.monitors.condition.signals import ConditionSample

PLACE = ConditionSample._fields.index("lateral_acceleration")


def test_what_is_impossible_is_left_out_counted_and_named():
    values = np.ones((10, len(ConditionSample._fields)))
    values[2, PLACE], values[3, PLACE], values[4, 0] = 1e300, -np.inf, np.inf
    checked = Impossible()
    kept = checked.add(values[:3]), checked.add(values[3:])
    cleaned = np.vstack(kept)
    assert np.argwhere(np.isnan(cleaned)).tolist() == [[2, PLACE], [3, PLACE], [4, 0]]
    assert (cleaned[np.isfinite(cleaned)] == 1.0).all()
    wheel, lateral = checked.notes()
    assert wheel.startswith("1 impossible value of wheel speed rear left, up to inf m/s was left out")
    assert lateral.startswith("2 impossible values of lateral acceleration, up to inf m/s**2 were left out")


def test_a_fault_of_a_sensor_and_a_missing_value_are_not_impossible():
    values = np.full((5, len(ConditionSample._fields)), 20.0)
    values[1, PLACE] = np.nan
    checked = Impossible()
    assert checked.add(values) is values
    assert checked.notes() == ()
