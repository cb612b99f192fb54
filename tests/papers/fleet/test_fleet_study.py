"""The study of fleets in small: it counts what was drawn, and its claims have their tables."""

import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.fleet.ageing import Ageing, Linear
from tierod_lab.fleet.writing import shipped_law
from tierod_lab.papers.fleet import batches, measured_errors, study, virtual_years
from tierod_lab.papers.fleet.virtual_years import BEGIN, RAMP, Counted, Years
from tierod_lab.studies.effort import Effort


def test_vehicle_years_and_delays_are_counted():
    quiet = virtual_years.counted(Years(1, 60, shipped_law(), 5))
    assert quiet.years == pytest.approx(60.0, rel=0.03)
    assert (quiet.alarms, quiet.delays) == (0, ())
    ramps = virtual_years.counted(Years(1, 60, shipped_law(), 5, (Ageing("ramp", Linear(RAMP), 0.1, BEGIN),)))
    assert len(ramps.delays) == 6
    assert ramps.years < quiet.years
    assert max(ramps.delays) < 60.0


def test_false_alarms_are_counted_with_tyres_that_move_the_estimate_too():
    law = virtual_years.with_tyres(shipped_law(), 0.03)
    assert (law.winter, law.winter_deviation) == (0.0, 0.03)
    assert law.drive_deviation == shipped_law().drive_deviation
    counted = [Counted(10.0, alarms, (), 0.0, 0) for alarms in (1, 2, 3, 4)]
    rows = virtual_years._quiet_table(counted[:3], counted[3]).rows
    assert [(row[0], row[2]) for row in rows] == [
        ("1", "1"), ("2", "2"), ("7", "3"), ("7, other tyres by 0.03 N·m", "4")]  # fmt: skip


def test_quantiles_and_bounds():
    some = Counted(1.0, 0, (10.0, 20.0, 30.0, np.inf), 0.0, 3)
    assert virtual_years.quantile(some, 0.5) == 20.0
    assert virtual_years.quantile(some, 0.95) == np.inf
    assert virtual_years.within(some) == 0.75
    assert virtual_years.upper_bound(0) == pytest.approx(2.996, abs=1e-3)


def test_a_batch_is_named():
    named, log_odds, others, effect = batches.judged(batches.Fleet(1.0, shipped_law(), 6))
    assert named
    assert log_odds > 5.0
    assert others == 0
    assert effect == pytest.approx(1.0, abs=0.3)


@pytest.mark.slow
def test_the_study_runs_quickly():
    found = list(study.items(Effort(quick=True, processes=1), lambda share, what: None))
    assert measured_errors.table(shipped_law()).header in [each.header for each in found if isinstance(each, Table)]
    assert {each.group for each in found if isinstance(each, Claim)} == {"ramps", "batches"}
