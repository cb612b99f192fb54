import pytest

from tierod_lab.papers.friction.hysteresis import TABLE_1, Turn, brake_torque, items, turns
from tierod_lab.studies.effort import Effort


def claims(measured):
    return {item.id: item for item in items(measured) if hasattr(item, "met")}


@pytest.mark.parametrize("pwm", TABLE_1)
def test_the_brake_goes_through_the_middles_of_table_1(pwm):
    low, high = TABLE_1[pwm]
    assert brake_torque(pwm) == pytest.approx(0.5 * (low + high), rel=0.01)


def test_no_setting_adds_nothing():
    assert brake_torque(0.0) == 0.0


def made(error=0.0):
    fault_free = {"hoist": 4.0, "ground": 20.0}
    return [
        Turn(support, pwm, brake_torque(pwm), fault_free[support] + brake_torque(pwm) + (error if pwm else 0.0))
        for support in fault_free
        for pwm in (0, 15, 20, 25)
    ]


def test_right_turns_meet_every_claim():
    assert all(claim.met for claim in claims(made()).values())


def test_wrong_turns_do_not():
    found = claims(made(error=3.0))
    assert found["paper.hysteresis-error"].measured == pytest.approx(3.0)
    assert found["paper.hysteresis-error"].met is False
    assert found["paper.hysteresis-nominal"].met is True


def test_virtual_turns_find_what_was_added():
    assert claims(turns(Effort(quick=True)))["paper.hysteresis-error"].met
