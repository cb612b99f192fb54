import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.methods.identification.column_fit import WheelMotion, wheel_side
from tierod.methods.identification.regression import instrumental

INERTIA, DAMPING = 0.04, 0.3


def motion(noise=0.0, seed=1, count=8000):
    """A wheel that swings by a few sines of known derivatives; the torque follows from them."""
    random, time = np.random.default_rng(seed), np.arange(count) * 1e-3
    frequencies, phases = np.array([0.4, 1.1, 2.3, 4.1]) * 2.0 * np.pi, np.array([0.0, 1.0, 2.0, 3.0])
    waves = 0.5 / frequencies * np.sin(np.outer(time, frequencies) + phases)
    angle = waves.sum(axis=1)
    rate = (0.5 * np.cos(np.outer(time, frequencies) + phases)).sum(axis=1)
    torque = -INERTIA * -(waves * frequencies**2).sum(axis=1) - DAMPING * rate + 0.1
    noisy = [values + noise * random.standard_normal(count) for values in (angle, angle, torque)]
    return WheelMotion(*noisy, 1e-3)


def test_without_noise_it_is_exact():
    found = wheel_side([motion()])
    assert found.inertia == pytest.approx(INERTIA, rel=1e-6)
    assert found.damping == pytest.approx(DAMPING, rel=1e-6)
    assert wheel_side([motion()], INERTIA).damping == pytest.approx(DAMPING, rel=1e-6)


def test_with_noise_the_deviations_say_how_exact_it_is():
    found = [wheel_side([motion(2e-3, seed)]) for seed in range(30)]
    inertia, damping = np.array([each.inertia for each in found]), np.array([each.damping for each in found])
    assert np.mean(inertia) == pytest.approx(INERTIA, abs=3.0 * np.std(inertia) / np.sqrt(30.0))
    assert np.mean([each.inertia_deviation for each in found]) == pytest.approx(np.std(inertia), rel=0.4)
    assert np.mean([each.damping_deviation for each in found]) == pytest.approx(np.std(damping), rel=0.4)


def test_instruments_take_away_the_bias_of_noisy_regressors():
    random = np.random.default_rng(3)
    true = random.standard_normal(20_000)
    noisy, other = (true + 0.7 * random.standard_normal(20_000) for _ in range(2))
    target = 2.0 * true + 0.1 * random.standard_normal(20_000)
    plain = instrumental([target], [noisy[:, None]], [noisy[:, None]])
    found = instrumental([target], [noisy[:, None]], [other[:, None]])
    assert plain.values[0] == pytest.approx(2.0 / 1.49, rel=0.03)
    assert found.values[0] == pytest.approx(2.0, abs=4.0 * np.sqrt(found.covariance[0, 0]))


def test_a_wheel_at_rest_is_refused():
    still = WheelMotion(np.zeros(4000), np.zeros(4000), np.zeros(4000), 1e-3)
    with pytest.raises(InputError, match="more motion"):
        wheel_side([still])
