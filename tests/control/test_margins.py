import math

import numpy as np
import pytest

from tierod.control.margins import margins
from tierod.errors import ParameterError
from tierod.models.linear import LinearSystem, sampled

STEP = 1e-3


def delayed_integrator(gain, samples):
    """gain/s, sampled, and some samples late."""
    n = samples + 1
    A = np.eye(n, k=1)
    A[0, 0] = 1.0
    A[0, 1:] = 0.0
    if samples:
        A[0, 1] = gain * STEP
    B = np.zeros((n, 1))
    B[-1, 0] = 1.0 if samples else gain * STEP
    return LinearSystem.of(A, np.eye(1, n), B)


def test_an_integrator_that_is_late_has_its_closed_form():
    found = margins(delayed_integrator(50.0, 4), STEP)
    crossover = 2.0 / STEP * math.asin(0.5 * 50.0 * STEP)
    assert found.crossover == pytest.approx(crossover / math.tau, rel=1e-3)
    lag = 0.5 * crossover * STEP + 4.0 * crossover * STEP
    assert found.phase == pytest.approx(math.pi / 2.0 - lag, rel=1e-3)
    assert found.delay == pytest.approx(found.phase / crossover, rel=2e-3)
    turning = math.pi / 2.0 / (4.5 * STEP)
    assert found.gain_up == pytest.approx(2.0 / STEP * math.sin(0.5 * turning * STEP) / 50.0, rel=1e-3)
    assert found.gain_down == 0.0


def test_an_unstable_plant_has_a_lowest_gain():
    plant = sampled(LinearSystem.of([[10.0]], [[1.0]], [[30.0]]), STEP)
    found = margins(plant, STEP)
    assert found.gain_down == pytest.approx(1.0 / 3.0, rel=1e-3)


def test_the_margins_are_where_the_loop_becomes_unstable():
    loop = delayed_integrator(50.0, 4)
    up = margins(loop, STEP).gain_up
    for factor, stable in ((0.999 * up, True), (1.001 * up, False)):
        closed = loop.A - factor * loop.B @ loop.C
        assert bool(np.abs(np.linalg.eigvals(closed)).max() < 1.0) is stable


def test_a_loop_that_is_unstable_is_refused_with_its_eigenvalue():
    with pytest.raises(ParameterError, match="unstable: eigenvalue .* of size 1"):
        margins(delayed_integrator(500.0, 4), STEP)
