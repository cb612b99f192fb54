import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod.core.findings import Status
from tierod_lab.papers.foreign import friction
from tierod_lab.papers.foreign.friction import LAWS, LEVELS, Judged, judged, shown


def drives(off=0.05, deviation=0.1, status=None):
    return [
        Judged(
            law,
            level,
            number,
            level,
            level + off,
            deviation,
            status or (Status.FAULT if level > 4.0 else Status.HEALTHY),
        )
        for law in LAWS
        for level in LEVELS
        for number in (0, 1)
    ]


def claims(found):
    return {each.id: each for each in shown(found) if isinstance(each, Claim)}


def test_right_estimates_hold_and_wrong_ones_do_not():
    assert all(each.met for each in claims(drives()).values())
    biased = claims(drives(off=0.5))
    assert biased["friction.foreign-bias"].measured == pytest.approx(0.5)
    assert biased["friction.foreign-covered"].measured == 0.0
    assert not any(biased[f"friction.foreign-{name}"].met for name in ("bias", "covered"))
    alarmed = claims(drives(status=Status.FAULT))
    assert alarmed["friction.foreign-verdicts"].measured == 2 * len(LAWS)
    silent = claims(drives(status=Status.NOT_IDENTIFIABLE))
    assert silent["friction.foreign-verdicts"].measured == silent["friction.foreign-judged"].measured == 0.0
    (table,) = (each for each in shown(drives()) if isinstance(each, Table))
    assert len(table.rows) == len(LAWS) * len(LEVELS)


def test_a_foreign_car_is_judged_against_its_baseline(monkeypatch):
    monkeypatch.setattr(friction, "LEVELS", (4.0, 12.5))
    free, risen = judged((LAWS[0], 0, 1, 4.0))
    assert (free.status, risen.status) == (Status.HEALTHY, Status.FAULT)
    assert free.estimate == pytest.approx(free.true, abs=0.6)
    assert risen.estimate == pytest.approx(risen.true, abs=1.2)
    assert 12.5 < risen.true < 1.1 * 12.5
    assert np.isfinite([free.deviation, risen.deviation]).all()
