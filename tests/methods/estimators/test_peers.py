"""The same numbers as filterpy, an implementation by others."""

import numpy as np
import pytest

from example_models import Pendulum, PendulumParameters, random_linear
from tierod.core.graph import scan
from tierod.methods.estimators import KalmanFilter
from tierod_lab.methods.unscented import UnscentedFilter

filterpy = pytest.importorskip("filterpy.kalman")


def test_kalman_filter():
    rng = np.random.default_rng(0)
    system, model, parameters = random_linear(rng, 4, 2, 2)
    block = KalmanFilter(model, parameters, (0.0,) * 4, (1.0,) * 4, (0.1, 0.2, 0.3, 0.4), (0.5, 0.6))
    samples = rng.normal(size=(80, 4))
    theirs = filterpy.KalmanFilter(4, 2, 2)
    theirs.F, theirs.B, theirs.H = system.A, system.B, system.C
    theirs.Q, theirs.R = np.diag(block.process_noise), np.diag(block.measurement_noise)
    expected = []
    for row in samples:
        theirs.predict(u=row[:2, None])
        theirs.update((row[2:] - system.D @ row[:2])[:, None])
        expected.append([*theirs.x[:, 0], *np.diag(theirs.P), *theirs.y[:, 0], *np.diag(theirs.S)])
    np.testing.assert_allclose(scan(block, samples).values[:, :12], expected, rtol=1e-8, atol=1e-10)


def test_unscented_filter():
    p, rng = PendulumParameters(), np.random.default_rng(1)
    block = UnscentedFilter(
        Pendulum, p, (0.5, 0.0), (0.2, 0.2), (1e-4, 1e-4), (0.01, 0.02), alpha=0.7, beta=2.0, kappa=1.0
    )
    samples = rng.normal(size=(60, 3)) * 0.4
    points = filterpy.MerweScaledSigmaPoints(2, 0.7, 2.0, 1.0)
    theirs = filterpy.UnscentedKalmanFilter(
        2,
        2,
        p.sample_time,
        lambda x: np.array(Pendulum.output(Pendulum.State(*x.tolist()), None, p)),
        lambda x, dt, u: np.array(Pendulum.transition(Pendulum.State(*x.tolist()), Pendulum.Input(u), p)),
        points,
    )
    theirs.x, theirs.P = np.array([0.5, 0.0]), 0.2 * np.eye(2)
    theirs.Q, theirs.R = np.diag(block.process_noise), np.diag(block.measurement_noise)
    expected = []
    for row in samples:
        theirs.predict(u=float(row[0]))
        theirs.update(row[1:])
        expected.append([*theirs.x, *np.diag(theirs.P), *theirs.y, *np.diag(theirs.S)])
    np.testing.assert_allclose(scan(block, samples).values[:, :8], expected, rtol=1e-6, atol=1e-9)
