import numpy as np
import pytest

from tierod.core.errors import TierodError
from tierod.core.graph import scan
from tierod.monitors.motor_angle.plausibility import MOTOR, NONE, NOT_MOTOR, PINION, WHEEL, WhichAngle

COUNT, BEGIN = 4000, 1000
AFTER = np.arange(COUNT) >= BEGIN


def result(residual, suspect=NONE, detour=0.0, counts=10, mismatch=0.03):
    """Suspect over time where the angles disagree from `BEGIN` on, and the alarm comes 500 samples later."""
    columns = (
        np.where(AFTER, mismatch, 0.0),
        np.arange(COUNT) >= BEGIN + 500,
        np.where(np.arange(COUNT) >= BEGIN + 500, suspect, NONE),
        np.where(AFTER, detour, 0.0),
        np.where(AFTER, residual, 0.005),
        np.arange(COUNT) % counts == 0 if counts else np.zeros(COUNT),
    )
    return scan(WhichAngle(), np.column_stack(columns).astype(float))["suspect"]


def test_nothing_is_suspected_before_the_alarm():
    assert result(0.5)[: BEGIN + 499].max() == NONE


@pytest.mark.parametrize("suspect", [NONE, WHEEL, PINION])
def test_the_observer_against_the_sensor_makes_it_the_motor(suspect):
    assert result(0.5, suspect)[-1] == MOTOR


@pytest.mark.parametrize(("suspect", "said"), [(NONE, NOT_MOTOR), (MOTOR, NOT_MOTOR), (WHEEL, WHEEL), (PINION, PINION)])
def test_the_observer_by_the_sensor_makes_it_another(suspect, said):
    assert result(0.01, suspect)[-1] == said


def test_a_motor_that_goes_its_own_way_beside_a_wheel_that_does_not_makes_it_the_wheel():
    assert result(0.01, detour=0.06)[-1] == WHEEL


@pytest.mark.parametrize("suspect", [NONE, MOTOR, PINION])
def test_without_turning_motion_alone_decides(suspect):
    assert result(0.5, suspect, counts=0)[-1] == suspect


def test_what_the_observer_said_before_the_disagreement_does_not_count():
    assert result(0.5)[BEGIN + 700] == MOTOR


def test_numbers_that_cannot_be_are_refused():
    with pytest.raises(TierodError, match="agreement"):
        WhichAngle(agreement=0.0)
