"""Tyres: brush, magic formula, relaxation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.physics import tyre
from tierod.physics import tyre as mf
from tierod_lab.ground.chassis import laws


def test_a_standing_patch_twists_up_to_its_limit_and_rolls_it_off():
    twist, limit, length = 0.0, 0.035, 0.05
    for _ in range(1000):
        twist += 1e-3 * tyre.twist_rate(twist, 0.5, 0.0, limit, length)
    assert twist == pytest.approx(limit, rel=1e-3)
    for _ in range(100):
        twist += 1e-3 * tyre.twist_rate(twist, 0.0, 0.5, limit, length)
    assert twist == pytest.approx(limit * math.exp(-1.0), rel=0.02)


def test_turn_slip_stiffness_is_the_sum_over_the_bristles():
    half_length, half_width, stiffness = 0.06, 0.08, 110e3
    x = half_length * (np.arange(1000) + 0.5) / 500.0
    y = half_width * ((np.arange(1000) + 0.5) / 500.0 - 1.0)
    per_area = stiffness / (2.0 * half_width * 2.0 * half_length**2)
    dragged = x[:, None] * y[None, :]
    area = 2.0 * half_width * 2.0 * half_length / dragged.size
    moment = per_area * float(np.sum(dragged * y[None, :])) * area
    assert tyre.turn_slip_stiffness(stiffness, half_width) == pytest.approx(moment, rel=1e-5)


SHAPE, CURVATURE = 1.38, -0.3
KX, KY, MUX, MUY, TYRE_LOAD = 25.0, 18.0, 1.1, 1.0, 4200.0
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


@pytest.mark.parametrize("share", [0.1, 0.7, 0.99])
def test_the_slip_of_a_share_of_the_peak_gives_that_share(share):
    scaled = mf.scaled_slip_of(share, SHAPE)
    assert mf.magic_formula(scaled / 10.0, 10.0, SHAPE, 4000.0, 0.0) == pytest.approx(share * 4000.0, rel=1e-9)


def forces(along, across):
    return laws.combined_forces((along, across), (KX, KY), (MUX, MUY), TYRE_LOAD, SHAPE, CURVATURE)


def test_the_trail_grows_with_load_and_vanishes_with_slip():
    assert mf.trail(4500.0, 4500.0, 0.024, 0.0, 1.1) == 0.024
    assert mf.trail(9000.0, 4500.0, 0.024, 0.0, 1.1) == 0.048
    sliding = mf.trail(4500.0, 4500.0, 0.024, forces(0.0, 1.0).angle, 1.1)
    assert abs(sliding) < 0.1 * 0.024
