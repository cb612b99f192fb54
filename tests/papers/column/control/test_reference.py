import math
from itertools import pairwise

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.papers.column.control.reference import Step, Sweep

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
