import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import magic_formula as mf

SHAPE, CURVATURE = 1.38, -0.3
KX, KY, MUX, MUY, LOAD = 25.0, 18.0, 1.1, 1.0, 4200.0

BAKKER = [
    (2.0, 0.244, 1.50, 1936.0, -0.132),
    (4.0, 0.239, 1.19, 3650.0, -0.678),
    (6.0, 0.164, 1.27, 5237.0, -1.61),
    (8.0, 0.112, 1.36, 6677.0, -2.16),
]
"""Load [kN], B [1/deg], C, D [N], E of the side force of one tyre: Bakker, Nyborg, Pacejka, SAE 870421 (1987)."""


@pytest.mark.parametrize(("load", "stiffness", "shape", "peak", "curvature"), BAKKER)
def test_printed_curves_have_the_printed_stiffness_and_peak(load, stiffness, shape, peak, curvature):
    slope = mf.magic_formula(1e-6, stiffness, shape, peak, curvature) / 1e-6
    assert slope == pytest.approx(1078.0 * math.sin(1.82 * math.atan(0.208 * load)), rel=0.015)
    curve = mf.magic_formula(np.linspace(0.0, 60.0, 60_001), stiffness, shape, peak, curvature)
    assert curve.max() == pytest.approx(peak, rel=1e-6)
    assert peak == pytest.approx(-22.1 * load**2 + 1011.0 * load, rel=0.015)


def test_a_printed_curve_peaks_where_its_angle_is_a_quarter_turn_over_the_shape():
    _, stiffness, shape, peak, curvature = BAKKER[2]
    slip = np.linspace(0.0, 40.0, 400_001)
    at = slip[np.argmax(mf.magic_formula(slip, stiffness, shape, peak, curvature))]
    assert mf.magic_angle(stiffness * at, curvature) == pytest.approx(0.5 * math.pi / shape, abs=1e-4)


@pytest.mark.parametrize("share", [0.1, 0.7, 0.99])
def test_the_slip_of_a_share_of_the_peak_gives_that_share(share):
    scaled = mf.scaled_slip_of(share, SHAPE)
    assert mf.magic_formula(scaled / 10.0, 10.0, SHAPE, 4000.0, 0.0) == pytest.approx(share * 4000.0, rel=1e-9)


def test_curves_are_odd():
    for slip in (0.01, 0.1, 1.0):
        values = [mf.magic_formula(sign * slip, 10.0, SHAPE, 4000.0, CURVATURE) for sign in (1.0, -1.0)]
        assert values[0] == -values[1] > 0.0


@pytest.mark.parametrize("load", [0.0, 1000.0, 4500.0, 9000.0, 14000.0])
def test_stiffness_by_load_is_the_sine_of_the_books(load):
    ours = load * mf.stiffness_per_load(load, 4500.0, 22.0, 2.0)
    assert ours == pytest.approx(22.0 * 4500.0 * math.sin(2.0 * math.atan(load / 9000.0)))


def test_stiffness_is_greatest_at_its_load():
    loads = np.linspace(0.0, 20e3, 2001)
    stiffness = loads * mf.stiffness_per_load(loads, 4500.0, 22.0, 2.0)
    assert loads[np.argmax(stiffness)] == pytest.approx(9000.0, abs=10.0)
    assert stiffness.max() == pytest.approx(22.0 * 4500.0)


def test_friction_falls_with_the_load():
    assert mf.friction_at_load(4500.0, 4500.0, 1.0, -0.1) == 1.0
    assert mf.friction_at_load(9000.0, 4500.0, 1.0, -0.1) == pytest.approx(0.9)


def forces(along, across):
    return mf.combined_forces((along, across), (KX, KY), (MUX, MUY), LOAD, SHAPE, CURVATURE)


@pytest.mark.parametrize("slip", [1e-3, 0.03, 0.1, 0.5])
def test_one_slip_alone_gives_the_pure_curve(slip):
    lateral = forces(0.0, slip)
    assert lateral.longitudinal == 0.0
    factor = KY / (SHAPE * MUY)
    assert lateral.lateral == pytest.approx(mf.magic_formula(slip, factor, SHAPE, MUY * LOAD, CURVATURE), rel=1e-6)
    factor = KX / (SHAPE * MUX)
    pure = mf.magic_formula(slip, factor, SHAPE, MUX * LOAD, CURVATURE)
    assert forces(slip, 0.0).longitudinal == pytest.approx(pure, rel=1e-6)


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_forces_stay_within_the_ellipse_and_along_their_slips(along, across):
    found = forces(along, across)
    share = math.hypot(found.longitudinal / (MUX * LOAD), found.lateral / (MUY * LOAD))
    assert share <= 1.0 + 1e-9
    assert found.longitudinal * along >= 0.0
    assert found.lateral * across >= 0.0


def test_braking_takes_side_force_away():
    lateral = [forces(-slip, 0.05).lateral for slip in (0.0, 0.03, 0.1, 0.3)]
    assert lateral == sorted(lateral, reverse=True)
    assert lateral[-1] < 0.3 * lateral[0]


def test_a_tyre_at_rest_and_one_without_load_have_no_force():
    assert forces(0.0, 0.0)[:2] == (0.0, 0.0)
    lifted = mf.combined_forces((0.1, 0.1), (KX, KY), (MUX, MUY), 0.0, SHAPE, CURVATURE)
    assert lifted[:2] == (0.0, 0.0)


def test_the_trail_grows_with_load_and_vanishes_with_slip():
    assert mf.trail(4500.0, 4500.0, 0.024, 0.0, 1.1) == 0.024
    assert mf.trail(9000.0, 4500.0, 0.024, 0.0, 1.1) == 0.048
    sliding = mf.trail(4500.0, 4500.0, 0.024, forces(0.0, 1.0).angle, 1.1)
    assert abs(sliding) < 0.1 * 0.024
