"""A damped body against its differential equation and against a body without damping."""

import numpy as np
import pytest
from scipy.linalg import expm

from tierod.physics.damped_rotation import damped_rotation


@pytest.mark.parametrize(("inertia", "damping", "time"), [(0.045, 1.07, 0.01), (0.045, 20.0, 0.1), (2.0, 0.5, 0.3)])
def test_it_solves_the_equation_of_motion(inertia, damping, time):
    system = np.zeros((3, 3))
    system[0, 1], system[1, 1], system[1, 2] = 1.0, -damping / inertia, 1.0 / inertia
    exact = expm(time * system)
    ours = damped_rotation(inertia, damping, time)
    expected = (exact[1, 1], exact[0, 1], exact[1, 2], exact[0, 2])
    assert ours == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("damping", [0.0, 1e-12])
def test_without_damping_it_is_a_free_body(damping):
    inertia, time = 0.05, 0.01
    ours = damped_rotation(inertia, damping, time)
    assert ours == pytest.approx((1.0, time, time / inertia, 0.5 * time * time / inertia), rel=1e-4)
