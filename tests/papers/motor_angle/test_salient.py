"""The study of salient motors, a small share of it."""

import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod_lab.papers.motor_angle import salient
from tierod_lab.papers.motor_angle.salient_drives import LOAD, RIGHT, fast_drive, salient_bench, stepping_load
from tierod_lab.studies.effort import Effort


def test_a_load_stands_and_steps_within_a_millisecond():
    load = stepping_load(20.0, 3)
    steps = np.abs(np.diff(load))
    assert steps.max() == pytest.approx(LOAD)
    assert 15 < np.count_nonzero(steps) < 80
    assert np.abs(load).max() == pytest.approx(0.5 * LOAD)


@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_a_fast_drive_weakens_the_flux(ratio):
    seen = fast_drive(ratio, 1, 20.0)
    own = (seen.samples[:, 0] + 1j * seen.samples[:, 1]) * np.exp(-4j * seen.angle)
    fast = np.abs(seen.speed) > 155.0
    assert fast.any()
    assert own.real[fast].min() < -5.0
    machine = salient_bench(ratio).motor.machine
    assert machine.inductance_q / machine.inductance_d == pytest.approx(ratio)


def test_a_fault_free_drive_is_watched():
    found = salient.watched(40)
    assert not found.alarmed
    assert 20.0 < found.known < 60.0


def test_errors_are_small_slow_and_fast():
    for fast in (False, True):
        assert salient.error(salient.Course(3.0, 41, RIGHT, fast)) < 0.004


@pytest.mark.slow
def test_every_claim_is_met():
    claims = [each for each in salient.items(Effort(quick=True, processes=1)) if isinstance(each, Claim)]
    assert {each.id.partition(".")[0] for each in claims} == {"salient"}
    for each in claims:
        assert each.goal is None or each.measured is None or each.goal.holds(each.measured)
