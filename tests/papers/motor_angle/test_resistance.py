import numpy as np

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.motor_angle.resistance import items, ramped
from tierod_lab.studies.effort import Effort


def test_a_quick_run_shows_every_claim_and_meets_it():
    found = list(items(Effort(quick=True)))
    claims = [each for each in found if isinstance(each, Claim)]
    assert {each.id for each in claims} == {"motor-angle.resistance.warm", "motor-angle.resistance.ramp"}
    assert all(each.met for each in claims)
    table = next(each for each in found if isinstance(each, Table))
    worst = {row[0]: float(row[2]) for row in table.rows}
    assert worst["20 % higher, resistance and flux not learnt"] > 5.0 * worst["20 % higher"]


def test_the_winding_warms_only_as_fast_as_it_is_worked():
    seen = ramped(4100, 6.0)
    assert np.all(np.diff(seen.resistance) >= 0.0)
    assert 1.15 < seen.resistance[-1] / seen.resistance[0] < 1.9
