"""References, and the motion of the column that follows one."""

import math
from itertools import pairwise

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.models.linear import linearise
from tierod.models.steering_column import TwoInertiaColumn, TwoInertiaParameters
from tierod_lab.papers.column.control.reference import Reference, Step, Sweep, advanced, motion_for

TIME = np.arange(0.0, 12.0, 1e-3)


@pytest.mark.parametrize("source", [Sweep(duration=10.0), Sweep(start=2.0, stop=2.0), Step(1.0, 0.5, 1.5)])
def test_every_derivative_is_that_of_the_one_before(source):
    reference = source.at(TIME)
    for below, above in pairwise(reference):
        slope = (below[2:] - below[:-2]) / (TIME[2] - TIME[0])
        inside = np.abs(TIME[1:-1, None] - [0.5, 2.0, 10.0]).min(axis=1) > 1.5e-3
        np.testing.assert_allclose(slope[inside], above[1:-1][inside], atol=2e-4 * np.abs(above).max())


def test_the_sweep_has_the_frequencies_and_the_amplitude_asked_for():
    sweep = Sweep()
    time = np.arange(0.0, 34.0, 1e-3)
    angle = sweep.at(time).angle
    assert np.abs(angle).max() == pytest.approx(math.radians(30.0), rel=1e-6)
    rising = np.nonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))[0]
    assert 1e3 / np.diff(rising[time[rising] > 30.5]).mean() == pytest.approx(3.0, rel=2e-3)
    assert sweep.frequency(np.array([0.0, 15.0, 40.0])).tolist() == pytest.approx([0.1, 1.55, 3.0])


def test_a_sweep_and_a_step_begin_at_rest():
    for source in (Sweep(), Step(1.0)):
        assert all(value[0] == 0.0 for value in source.at(np.zeros(1)))


def test_a_jump_has_no_derivatives():
    reference = Step(0.4, 0.5, 0.0).at(TIME)
    assert set(reference.angle) == {0.0, 0.4}
    assert not any(value.any() for value in reference[1:])


@pytest.mark.parametrize("wrong", [lambda: Sweep(duration=0.0), lambda: Sweep(stop=-1.0), lambda: Step(math.nan)])
def test_wrong_numbers_are_refused(wrong):
    with pytest.raises(ParameterError, match="expected"):
        wrong()


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
