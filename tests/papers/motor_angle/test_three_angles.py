import math

from tierod.papers.motor_angle.three_angles import Case, Told, told_of


def test_a_sound_drive_raises_nothing():
    told = told_of(Case("slalom", 40))
    assert told.delay == math.inf
    assert not told.early
    assert told.largest < 0.01


def test_the_ratio_over_speed_tells_the_recorded_wheel_where_motion_cannot():
    told = told_of(Case("slalom", 40, "wheel, recorded", "drift"))
    assert isinstance(told, Told)
    assert 0.3 < told.delay < 1.5
    assert (told.motion, told.suspect) == ("none", "wheel")


def test_the_observer_stands_by_the_motor_where_the_pinion_drifts():
    assert told_of(Case("slalom", 40, "pinion", "drift")).suspect == "not the motor"
