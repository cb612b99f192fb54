import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import tyre

STIFFNESS, ADHESION, LOAD, HALF_LENGTH = 110e3, 0.9, 9000.0, 0.075
LIMIT = ADHESION * LOAD
BRUSH = (STIFFNESS, ADHESION, LOAD)


def test_brush_starts_with_the_cornering_stiffness():
    assert tyre.brush_lateral_force(1e-6, *BRUSH) / 1e-6 == pytest.approx(STIFFNESS, rel=1e-4)
    assert tyre.linear_lateral_force(1e-6, STIFFNESS) == pytest.approx(tyre.brush_lateral_force(1e-6, *BRUSH), rel=1e-4)


@given(st.floats(-3, 3))
def test_brush_force_is_odd_and_never_above_adhesion(slip):
    force = tyre.brush_lateral_force(slip, *BRUSH)
    assert abs(force) <= LIMIT
    assert force == -tyre.brush_lateral_force(-slip, *BRUSH)


def test_brush_peak_is_adhesion_times_load_from_the_sliding_slip_on():
    sliding = tyre.sliding_slip(*BRUSH)
    assert tyre.brush_lateral_force(sliding, *BRUSH) == pytest.approx(LIMIT)
    assert tyre.brush_lateral_force(3.0 * sliding, *BRUSH) == LIMIT
    assert tyre.brush_lateral_force(0.8 * sliding, *BRUSH) < LIMIT


def test_brush_is_fialas_polynomial():
    slip = np.linspace(0.0, 0.9, 7) * tyre.sliding_slip(*BRUSH)
    fiala = STIFFNESS * slip - STIFFNESS**2 * slip**2 / (3.0 * LIMIT) + STIFFNESS**3 * slip**3 / (27.0 * LIMIT**2)
    np.testing.assert_allclose(tyre.brush_lateral_force(slip, *BRUSH), fiala, rtol=1e-12, atol=1e-9)


def test_aligning_torque_peaks_at_a_quarter_of_the_sliding_slip():
    slip = np.linspace(0.0, 1.0, 4001) * tyre.sliding_slip(*BRUSH)
    torque = tyre.brush_aligning_torque(slip, *BRUSH, HALF_LENGTH)
    assert slip[np.argmax(torque)] / slip[-1] == pytest.approx(0.25, abs=1e-3)
    assert torque.max() == pytest.approx(LIMIT * HALF_LENGTH * 27.0 / 256.0)


def test_relaxation_settles_at_the_slip_and_holds_when_standing():
    deflection, speed, length = 0.0, 10.0, 0.3
    for _ in range(10_000):
        deflection += 1e-4 * tyre.relaxation_rate(deflection, speed * 0.02, speed, length)
    assert deflection / length == pytest.approx(0.02, rel=1e-6)
    assert tyre.relaxation_rate(0.01, 0.0, 0.0, length) == 0.0


def test_parking_torque_of_a_mid_size_car():
    wheel = tyre.parking_torque(4700.0, 0.9, 2.2e5)
    assert wheel == pytest.approx(0.9 * 4700.0 / 3.0 * math.sqrt(4700.0 / 2.2e5))
    assert 15.0 < 2.0 * wheel / 15.5 < 35.0


def test_the_deflection_of_a_dragged_tyre_is_bounded_and_that_of_a_rolling_one_is_not_touched():
    deflection, length = 0.0, 0.4
    for _ in range(10_000):
        speed = tyre.relaxation_speed(0.0, 1.0, 0.3)
        deflection += 1e-3 * tyre.relaxation_rate(deflection, 1.0, speed, length)
    assert deflection == pytest.approx(0.3 * length)
    assert tyre.relaxation_speed(100.0, (0.06 * 10.0) ** 2, 0.3) == pytest.approx(10.0, rel=4.1e-4)
    assert tyre.relaxation_speed(0.0, 0.0, 0.3) == 0.0


def test_a_bounded_rate_keeps_the_steady_deflection_and_its_own_limit():
    for speed in (1.0, 50.0, 5000.0):
        steady = 0.02 * 0.3
        assert tyre.bounded_relaxation_rate(steady, 0.02 * speed, speed, 0.3, 1e-3) == pytest.approx(0.0, abs=1e-9)
        rate = -tyre.bounded_relaxation_rate(1.0, 0.0, speed, 0.3, 1e-3)
        assert rate == pytest.approx(1.0 / (0.3 / speed + 1e-3))


def test_a_standing_patch_twists_up_to_its_limit_and_rolls_it_off():
    twist, limit, length = 0.0, 0.035, 0.05
    for _ in range(1000):
        twist += 1e-3 * tyre.twist_rate(twist, 0.5, 0.0, limit, length)
    assert twist == pytest.approx(limit, rel=1e-3)
    for _ in range(100):
        twist += 1e-3 * tyre.twist_rate(twist, 0.0, 0.5, limit, length)
    assert twist == pytest.approx(limit * math.exp(-1.0), rel=0.02)


def test_a_rolling_patch_twists_by_its_turn_slip():
    length, limit, speed, turning = 0.05, 1e3, 5.0, 0.4
    twist = 0.0
    for _ in range(1000):
        twist += 1e-3 * tyre.twist_rate(twist, turning, speed, limit, length)
    assert twist / length == pytest.approx(tyre.turn_slip(turning, speed), rel=1e-4)


def test_turn_slip_stiffness_is_the_sum_over_the_bristles():
    half_length, half_width, stiffness = 0.06, 0.08, 110e3
    x = half_length * (np.arange(1000) + 0.5) / 500.0
    y = half_width * ((np.arange(1000) + 0.5) / 500.0 - 1.0)
    per_area = stiffness / (2.0 * half_width * 2.0 * half_length**2)
    dragged = x[:, None] * y[None, :]
    area = 2.0 * half_width * 2.0 * half_length / dragged.size
    moment = per_area * float(np.sum(dragged * y[None, :])) * area
    assert tyre.turn_slip_stiffness(stiffness, half_width) == pytest.approx(moment, rel=1e-5)
