import math

import numpy as np
import pytest

from tierod.models.linear import linearise
from tierod.models.two_inertia_column import TwoInertiaColumn, TwoInertiaParameters
from tierod.papers.column.control.flat_column import advanced, motion_for
from tierod.papers.column.control.reference import Reference, Sweep

COLUMN = TwoInertiaParameters(0.035, 0.2286, 132.1, 18.0, 1.62e-4, 1.48e-3)
BAR = 140.0


def sine(frequency, phase):
    """A sine of 1 rad and its derivatives, as complex amplitudes turned by a phase."""
    s = 2j * math.pi * frequency
    turned = np.exp(1j * phase) / 1j
    return Reference(*(float((s**order * turned).real) for order in range(5)))


@pytest.mark.parametrize(("frequency", "tolerance"), [(0.1, 1e-6), (1.0, 4e-4), (3.0, 1.2e-2)])
@pytest.mark.parametrize("output_stiffness", [BAR, COLUMN.stiffness])
def test_the_motion_is_that_of_the_linear_column(frequency, tolerance, output_stiffness):
    system = linearise(TwoInertiaColumn, COLUMN, (0.0,) * 4, (0.0,) * 3)
    s = 2j * math.pi * frequency
    states = np.linalg.solve(s * np.eye(4) - system.A, system.B[:, 0])
    share = COLUMN.stiffness / output_stiffness
    shaft = states[2] + share * (states[3] / COLUMN.motor_ratio - states[2])
    for phase in (0.0, 1.0, 2.5):
        turned = np.exp(1j * phase) / 1j
        exact = [*(states / shaft * turned).real, (s * states[0] / shaft * turned).real, (turned / shaft).real]
        sizes = [*np.abs(states / shaft), abs(s * states[0] / shaft), abs(1.0 / shaft)]
        found = motion_for(sine(frequency, phase), COLUMN, output_stiffness)
        np.testing.assert_allclose(np.array(found) / sizes, np.array(exact) / sizes, atol=tolerance)


def test_at_rest_nothing_is_needed():
    motion = motion_for(Reference(0.3, 0.0, 0.0, 0.0, 0.0), COLUMN, BAR)
    assert motion.motor_angle == pytest.approx(0.3 * 18.0)
    assert motion._replace(motor_angle=0.0, steering_wheel_angle=0.0) == (0.0,) * 6


def test_a_reference_is_taken_a_little_further():
    sweep, time = Sweep(duration=5.0), np.arange(0.5, 5.0, 0.01)
    ahead = advanced(sweep.at(time), 1.5e-3)
    for found, exact in zip(ahead, sweep.at(time + 1.5e-3), strict=True):
        np.testing.assert_allclose(found, exact, atol=0.04 * np.abs(exact).max())
    for order, tolerance in ((0, 1e-11), (1, 1e-8), (2, 1e-5)):
        np.testing.assert_allclose(ahead[order], sweep.at(time + 1.5e-3)[order], atol=tolerance * 200)
