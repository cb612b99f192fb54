import math

import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.motor_angle.feedforward import FeedforwardAngle
from tierod_lab.papers.motor_angle.observer_drives import (
    SAMPLE_TIME,
    accuracy,
    by_speed,
    methods,
    parameters,
    to_and_fro,
)
from tierod_lab.papers.motor_angle.printed import inductive_error, items, turned_by_printed_sign
from tierod_lab.papers.motor_angle.printed_observers import extended_kalman, luenberger
from tierod_lab.studies.effort import Effort

DQ, FIXED = parameters()


def test_the_load_as_a_state_keeps_the_angle_and_leaving_it_out_loses_it():
    drives = [to_and_fro(31, 6.0)]
    without = accuracy(luenberger(DQ, SAMPLE_TIME, load=False, axes="measured"), drives)
    loaded = accuracy(luenberger(DQ, SAMPLE_TIME, axes="measured"), drives)
    assert without.angle > 20.0 * loaded.angle
    assert loaded.speed < 1.0 < without.speed
    assert accuracy(extended_kalman(DQ, SAMPLE_TIME), drives).largest < 0.1


def test_the_feedforward_is_better_the_faster_the_motor():
    found = by_speed(FeedforwardAngle(FIXED, slow="increments"), [to_and_fro(31, 6.0)])
    assert found == sorted(found, reverse=True)
    assert found[1] < 0.066
    assert found[3] < 0.02


def test_the_printed_sign_turns_the_angle_on_the_bench_as_it_must():
    assert inductive_error(12.0) == pytest.approx(math.atan(2.0 * 1e-4 * 12.0 / 0.0085))
    assert turned_by_printed_sign(12.0) == pytest.approx(inductive_error(12.0), rel=0.03)


def test_all_methods_stand_in_the_study_and_its_claims_hold():
    found = list(items(Effort(quick=True)))
    claims = [item for item in found if isinstance(item, Claim)]
    assert all(claim.met for claim in claims)
    followed = next(item for item in found if isinstance(item, Table) and "Errors" in item.title)
    assert {row[0] for row in followed.rows} == set(methods())
