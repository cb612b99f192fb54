"""A lag of the first order against its differential equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tierod.physics.lag import lagged_ramp


@pytest.mark.parametrize("lag", [0.003, 0.01, 0.4])
def test_it_solves_the_equation_of_the_lag(lag):
    before, after, output, time = 1.0, 3.0, -0.5, 0.01

    def slope(t, y):
        rate = (before + (after - before) * t / time - y[0]) / lag
        return [rate, y[0]]

    solved = solve_ivp(slope, (0.0, time), [output, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    ours = lagged_ramp(before, after, output, lag, time)
    assert (ours.end, ours.mean) == pytest.approx((solved[0], solved[1] / time), rel=1e-7)


def test_without_a_lag_it_follows():
    assert lagged_ramp(1.0, 3.0, 1.0, 0.0, 0.01) == pytest.approx((2.0, 3.0), abs=0.03)
    assert np.isfinite(lagged_ramp(1.0, 3.0, 1.0, 0.0, 1.0)).all()
