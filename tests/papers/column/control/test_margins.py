import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, sampled
from tierod.papers.column.control.margins import margins

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


def test_a_peak_that_is_narrower_than_any_grid_is_seen():
    turning, damping, height = math.tau * 112.3, 1e-6, 1.5
    width = 2.0 * damping * turning
    ringing = LinearSystem.of([[0.0, 1.0], [-(turning**2), -width]], [[0.0, height * width]], [[0.0], [1.0]])
    found = margins(sampled(ringing, STEP), STEP)
    assert found.crossover == pytest.approx(112.3, rel=1e-4)
    # Sampled and held it is half a sample late, and smaller by the sine of that lag over the lag.
    lag = 0.5 * turning * STEP
    beside = math.acos(lag / (height * math.sin(lag)))
    assert found.phase == pytest.approx(math.pi - beside - lag, abs=1e-3)


def test_an_eigenvalue_without_damping_is_passed_by():
    turning, rate = math.tau * 20.0, 2.0
    swinging = LinearSystem.of([[0.0, 1.0], [-(turning**2), 0.0]], [[0.0, rate]], [[0.0], [1.0]])
    found = margins(sampled(swinging, STEP), STEP)
    # |L| is one where w rate = |w^2 - turning^2|, above and below the eigenvalue.
    assert found.crossover == pytest.approx((0.5 * rate + math.hypot(0.5 * rate, turning)) / math.tau, rel=1e-3)
    assert found.phase == pytest.approx(0.5 * math.pi - 0.5 * turning * STEP, abs=0.01)
