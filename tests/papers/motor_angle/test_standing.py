import math

import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod_lab.papers.motor_angle.observer_drives import parameters
from tierod_lab.papers.motor_angle.standing import HELD, MOVING, held_drive, items, settled, settling, standing
from tierod_lab.studies.effort import Effort

DRIVE = held_drive(1)


def test_the_motor_is_held_against_a_load_and_turns_on():
    still = (DRIVE.time > MOVING + 0.5) & (DRIVE.time < MOVING + HELD)
    assert np.abs(DRIVE.speed[still]).max() < 0.1
    assert np.abs(DRIVE.load[still]).mean() == pytest.approx(0.8, abs=0.05)
    assert np.abs(DRIVE.speed[DRIVE.time > MOVING + HELD + 0.5]).max() > 10.0


def test_held_the_observer_stays_and_knows_that_it_knows_less():
    found = standing(MotorAngleObserver(parameters()[1]), DRIVE)
    assert found.drift < 0.001
    assert found.late > 1.5 * found.early
    assert found.back < 0.05


def test_settled_is_what_stays_right():
    wrong = np.zeros(5000, dtype=bool)
    wrong[:300] = wrong[800] = True
    assert settled(wrong) == pytest.approx(0.0801)
    assert settled(~wrong) == math.inf


@pytest.mark.parametrize(("begins", "least"), [("from rest", 0.1), ("reversing", 0.3)])
def test_a_small_wrong_beginning_is_found_sooner_than_allowed(begins, least):
    assert np.quantile(settling(0.3, begins, 6), 0.9) < least


def test_the_study_has_its_claims():
    claims = {item.id: item for item in items(Effort(quick=True)) if isinstance(item, Claim)}
    assert set(claims) == {
        "standing.drift",
        "standing.variance",
        "standing.known-again",
        "standing.begin-from-rest",
        "standing.begin-reversing",
    }
    assert claims["standing.drift"].met
