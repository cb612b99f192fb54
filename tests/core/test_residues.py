"""What arithmetic adds to a reading is no change of it."""

import math

import numpy as np
import pytest

from tierod.core.signals import SIGNALS, UNBOUNDED, levels_of, residue_between, residue_of

WHEEL = SIGNALS["steering_wheel_angle"].plausible[1]


def test_single_precision_of_a_plausible_reading_is_a_residue_and_a_step_of_a_sensor_is_none():
    for reading in np.linspace(-WHEEL, WHEEL, 101).tolist():
        assert abs(float(np.float32(reading)) - reading) < residue_of("steering_wheel_angle")
    assert residue_of("steering_wheel_angle") < 0.01 * math.radians(0.1)


def test_a_signal_without_a_plausible_range_has_residues_all_the_same():
    assert 0.0 < residue_of("motor_angle_mechanical") < 1e-6 * UNBOUNDED


def test_a_small_motion_far_from_zero_is_no_residue():
    assert residue_between(5e6, 5e6 + 0.02) < 0.01
    assert residue_between(5.0, 5.0 + 4e-15) > 4e-15
    assert residue_between(5.0, 5.0 + 1e-9) < 1e-9
    assert residue_between(0.0, 0.0) == 0.0


def test_levels_are_counted_without_their_residues():
    values = np.array([0.3, 0.1 + 0.2, 1.0, -2.0, 1.0 + 1e-13, 1.0 - 1e-13])
    levels, counts = levels_of(values, residue_between(-2.0, 1.0))
    assert levels == pytest.approx([-2.0, 0.3, 1.0])
    assert counts.tolist() == [1, 2, 3]
    assert not len(levels_of(np.array([]), 1e-9)[0])
