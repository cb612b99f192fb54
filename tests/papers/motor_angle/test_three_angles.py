import math

from tierod_lab.papers.motor_angle.three_angles import Case, Findings, findings_of


def test_a_fault_free_drive_raises_nothing():
    found = findings_of(Case("slalom", 40))
    assert found.delay == math.inf
    assert not found.early
    assert found.largest < 0.01


def test_the_ratio_over_speed_shows_the_recorded_wheel_where_motion_cannot():
    found = findings_of(Case("slalom", 40, "wheel, recorded", "drift"))
    assert isinstance(found, Findings)
    assert 0.3 < found.delay < 1.5
    assert (found.motion, found.suspect) == ("none", "wheel")


def test_the_observer_stands_by_the_motor_where_the_pinion_drifts():
    assert findings_of(Case("slalom", 40, "pinion", "drift")).suspect == "not the motor"
