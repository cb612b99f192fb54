import math

import numpy as np
import pytest

from tierod.monitors.driver_torque.design import FINE, MARGIN, measured_noise

RATE = 1000.0


def signals(seconds=5.0):
    time = np.arange(0.0, seconds, 1.0 / RATE)
    return 0.3 * np.sin(2.0 * np.pi * 0.7 * time), 2.0 * np.sin(2.0 * np.pi * 1.1 * time)


def test_white_noise_is_found_under_motion():
    draw, (angle, torque) = np.random.default_rng(1), signals()
    noisy = angle + 2e-4 * draw.standard_normal(len(angle)), torque + 0.03 * draw.standard_normal(len(torque))
    found = measured_noise(*noisy, RATE, FINE)
    assert found.angle == pytest.approx(MARGIN * 2e-4, rel=0.1)
    assert found.torque == pytest.approx(MARGIN * 0.03, rel=0.1)


def test_rounding_weighs_the_more_the_longer_it_stays():
    angle, torque = signals()
    step = math.radians(0.1)
    found = measured_noise(np.round(angle / step) * step, torque, RATE, FINE)
    assert MARGIN * step / math.sqrt(12.0) < found.angle < MARGIN * step / math.sqrt(12.0) * math.sqrt(10.0) + 1e-12


def rounded(values, step):
    return np.round(values / step) * step


def test_a_rounding_residue_in_one_reading_or_in_all_of_them_changes_nothing():
    angle, torque = signals()
    angle = rounded(angle, math.radians(0.1))
    noise = measured_noise(angle, torque, RATE, FINE).angle
    one = angle.copy()
    one[2000] += 1e-13
    assert measured_noise(one, torque, RATE, FINE).angle == pytest.approx(noise, rel=1e-6)
    for residues in (1e-15 * np.random.default_rng(3).standard_normal(len(angle)), angle.astype(np.float32) - angle):
        assert measured_noise(angle + residues, torque, RATE, FINE).angle == pytest.approx(noise, rel=1e-4)


def test_single_readings_between_two_steps_are_not_taken_for_the_step():
    angle, torque = signals()
    angle = rounded(angle, math.radians(0.1))
    noise = measured_noise(angle, torque, RATE, FINE).angle
    turned = np.flatnonzero(np.diff(angle))[5]
    angle[turned] += 0.03 * (angle[turned + 1] - angle[turned])
    assert measured_noise(angle, torque, RATE, FINE).angle == pytest.approx(noise, rel=0.01)


def test_missing_samples_are_left_out():
    draw, (angle, torque) = np.random.default_rng(2), signals()
    noisy = torque + 0.03 * draw.standard_normal(len(torque))
    noisy[::7] = np.nan
    assert measured_noise(angle, noisy, RATE, FINE).torque == pytest.approx(MARGIN * 0.03, rel=0.15)


def test_what_is_too_short_is_taken_as_usual():
    assert measured_noise(np.arange(100.0), np.arange(100.0) ** 2, RATE, FINE) == FINE


def test_ideal_sensors_are_not_trusted_without_bound():
    assert measured_noise(*signals(), RATE, FINE).torque == 0.5 * FINE.torque
