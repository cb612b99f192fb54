"""One time from the stamps of several buses."""

import math

from tierod.live.clock import DriveClock, Frame

CALENDAR = 1_700_000_000.0


def placed(clock, time, bus=1, came=None, data=b"x"):
    return clock.placed(Frame(time, 7, bus, data), time if came is None else came, CALENDAR)


def test_time_counts_from_the_whole_second_of_the_first_stamp():
    clock = DriveClock()
    assert placed(clock, CALENDAR + 0.75).time == 0.75
    assert clock.origin == CALENDAR


def test_a_clock_without_a_calendar_takes_that_of_the_computer():
    clock = DriveClock()
    assert placed(clock, 12.25).time == 0.25
    assert clock.origin == CALENDAR


def test_frames_out_of_order_keep_their_stamps_and_are_counted():
    clock = DriveClock()
    times = [placed(clock, 10.0 + at).time for at in (0.0, 0.2, 0.1, 0.3)]
    assert times == [0.0, 0.1999999999999993, 0.09999999999999964, 0.3000000000000007]
    assert (clock.late, clock.jumps) == (1, 0)


def test_a_clock_that_jumps_back_goes_on_by_the_time_of_the_computer():
    clock = DriveClock()
    placed(clock, 100.0, came=5.0)
    assert math.isclose(placed(clock, 40.0, came=5.01).time, 0.01, abs_tol=1e-9)
    assert math.isclose(placed(clock, 40.02, came=5.03).time, 0.03, abs_tol=1e-9)
    assert clock.jumps == 1


def test_a_clock_that_jumps_ahead_is_bridged_and_a_pause_is_not():
    clock = DriveClock()
    placed(clock, 100.0, came=5.0)
    assert math.isclose(placed(clock, 160.0, came=65.0).time, 60.0)
    assert clock.jumps == 0
    assert math.isclose(placed(clock, 9000.0, came=65.01).time, 60.01)
    assert clock.jumps == 1


def test_two_buses_with_clocks_of_their_own():
    clock = DriveClock()
    placed(clock, 100.0, bus=1, came=5.0)
    assert math.isclose(placed(clock, 7.0, bus=2, came=5.5).time, 0.5)
    assert math.isclose(placed(clock, 7.25, bus=2, came=5.75).time, 0.75)
    assert clock.jumps == 0


def test_doubled_frames_are_counted_and_a_stamp_that_is_no_number_is_left_out():
    clock = DriveClock()
    placed(clock, 1.0)
    placed(clock, 1.0)
    placed(clock, 1.0, data=b"y")
    assert clock.doubled == 1
    assert placed(clock, math.nan) is None
