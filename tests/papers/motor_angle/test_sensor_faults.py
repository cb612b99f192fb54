import math

import numpy as np
import pytest

from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod_lab.papers.motor_angle.bench import FLUX, INDUCTANCE, RESISTANCE, drive
from tierod_lab.papers.motor_angle.fault_trials import (
    Found,
    Trial,
    anywhere,
    begin,
    bench_monitor,
    found,
    other_motor,
    target,
)
from tierod_lab.papers.motor_angle.sensor_faults import (
    DEGREE,
    FIVE_DEGREES,
    STUCK,
    coarse,
    drift,
    gain,
    intermittent,
    offset,
)

ANGLE = MotorAngleSample._fields.index("motor_angle_mechanical")


@pytest.fixture(scope="module")
def begun():
    return begin(Trial(11, 60.0))


def test_a_fault_changes_nothing_before_it_begins_and_then_what_it_says():
    fault_free, faulty = drive(1, 0.6), drive(1, 0.6, offset(5.0), 0.5)
    np.testing.assert_array_equal(fault_free.samples[:5000], faulty.samples[:5000])
    jump = faulty.samples[5000, ANGLE] - fault_free.samples[5000, ANGLE]
    assert jump == pytest.approx(FIVE_DEGREES)
    assert pytest.approx(math.radians(5.0) / 4.0) == FIVE_DEGREES


def test_a_stuck_sensor_reads_what_it_read_last():
    faulty = drive(1, 0.6, STUCK, 0.5)
    late = faulty.samples[5000:, ANGLE]
    assert late.std() < 6e-4
    assert late.mean() == pytest.approx(faulty.samples[4999, ANGLE], abs=0.003)


def test_a_gain_begins_without_a_jump_and_then_grows():
    fault_free, faulty = drive(1, 1.0), drive(1, 1.0, gain(10.0), 0.5)
    difference = faulty.samples[:, ANGLE] - fault_free.samples[:, ANGLE]
    assert abs(difference[5000]) < 0.02
    assert np.abs(difference).max() > 0.1


def test_steps_are_in_the_recording_from_their_begin_on():
    faulty = drive(1, 0.6, coarse(20.0), 0.5)
    off = faulty.samples[:, ANGLE] / (20.0 * DEGREE)
    assert np.std(off[5000:] - np.round(off[5000:])) < 0.01
    assert np.std(off[4000:5000] - np.round(off[4000:5000])) > 0.05


def test_an_intermittent_offset_is_there_for_a_twentieth_of_the_time():
    time = np.arange(1000) * 1e-3
    assert np.mean(intermittent(20.0).offset(time) > 0.0) == pytest.approx(0.05)


def test_delays_count_from_when_a_drift_is_as_large_as_five_degrees():
    grown = drift(20.0)
    assert grown.offset(np.array([grown.size]))[0] == pytest.approx(FIVE_DEGREES)


def test_the_motor_turns_at_the_speed_that_is_asked_for():
    rate = np.diff(target(Trial(3, 30.0), 7000)) * 1e3
    assert np.median(np.abs(rate[1000:])) == pytest.approx(30.0, rel=0.01)
    assert rate[1000:].min() == pytest.approx(-30.0, rel=0.01)


def test_a_trial_goes_on_where_its_fault_free_part_ended(begun):
    assert begun is not None
    five, two = found(begun, offset(5.0)), found(begun, offset(2.0))
    assert 10.0 < five.turning <= five.delay < 200.0
    assert two == Found(math.inf, math.inf, "")
    assert found(begun, STUCK).delay < 10.0


def test_a_trial_and_a_whole_drive_with_the_same_fault_show_the_same(begun):
    assert begun is not None
    again = begin(Trial(11, 60.0))
    assert again is not None
    assert again.step == begun.step
    np.testing.assert_array_equal(again.monitor.values, begun.monitor.values)


def test_a_stuck_sensor_is_found_from_any_instant():
    assert math.isfinite(anywhere(STUCK, 7).delay)


def test_motors_in_a_row_spread_over_their_ranges():
    p = bench_monitor().observer.parameters
    drawn = [other_motor(number).observer.parameters for number in range(3, 63)]
    for name, (low, high) in (
        ("motor_resistance", RESISTANCE),
        ("motor_flux", FLUX),
        ("motor_inductance", INDUCTANCE),
    ):
        shares = np.sort([(getattr(p, name) / getattr(each, name) - low) / (high - low) for each in drawn])
        assert np.abs(shares - (np.arange(60) + 0.5) / 60.0).max() < 0.06
