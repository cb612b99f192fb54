import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.methods.analysis.fitness import require_fit
from tierod.models.linear import LinearSystem


def oscillator(frequency=10.0, damping=0.1):
    """x'' = -w^2 x - 2 d w x', the angle measured."""
    A = [[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]]
    return LinearSystem.of(A, [[1.0, 0.0]], states=("angle", "rate"))


def refused(system, **asked):
    with pytest.raises(ParameterError) as caught:
        require_fit(system, "the pendulum of 'clock.toml'", **{"stable": False, "observable": False} | asked)
    message = str(caught.value)
    assert message.startswith("the pendulum of 'clock.toml'")
    return message


def test_a_fault_free_model_passes_everything():
    require_fit(oscillator(), "it", stable=True, observable=True, sample_time=1e-3, method="rk4")
    require_fit(oscillator(), "it", stable=True, observable=True, sample_time=1e-3)


def test_an_unstable_model_is_refused_with_its_eigenvalue():
    message = refused(oscillator(damping=-0.1), stable="marginal")
    assert "eigenvalue 1 " in message
    assert "9.95i" in message
    assert "angle" in message
    require_fit(oscillator(damping=-0.1), "it", stable=False, observable=True)


def test_a_free_angle_is_marginal():
    free = LinearSystem.of([[0.0, 1.0], [0.0, -3.0]], [[1.0, 0.0]], states=("angle", "rate"))
    require_fit(free, "it", stable="marginal", observable=True)
    assert "does not come to rest" in refused(free, stable=True)


def test_angles_pushed_by_constant_torques_are_marginal():
    chain = np.zeros((4, 4))
    chain[:3, :3], chain[3, 3] = np.eye(3, k=1) * 300.0, -700.0
    turned = np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0]
    split = LinearSystem.of(turned @ chain @ turned.T, np.array([[1.0, 0.0, 0.0, 1.0]]) @ turned.T)
    assert np.linalg.eigvals(split.A).real.max() > 1e-4
    require_fit(split, "it", stable="marginal", observable=True)


def test_a_hidden_direction_is_named():
    blind = replace(oscillator(), A=np.diag([-1.0, -2.0]))
    message = refused(blind, observable=True)
    assert "not observable: 1 rate" in message
    assert "add an output" in message


@pytest.mark.parametrize(("method", "limit"), [("euler", 2.0), ("midpoint", 2.0), ("rk4", 2.785293563)])
def test_a_decay_may_not_be_stepped_over(method, limit):
    fast = LinearSystem.of([[-100.0]], [[1.0]], states=("pressure",))
    require_fit(fast, "it", stable=True, observable=True, sample_time=0.999 * limit / 100.0, method=method)
    message = refused(fast, sample_time=1.001 * limit / 100.0, method=method)
    assert "eigenvalue -100 " in message
    assert f"at most {limit / 100.0:.2g} s (" in message
    assert "Hz or faster)" in message


def test_an_undamped_vibration_needs_a_better_method_than_eulers():
    vibrating = oscillator(frequency=100.0, damping=1e-4)
    assert "15.9 Hz" in refused(vibrating, sample_time=1e-3, method="euler")
    require_fit(vibrating, "it", stable=True, observable=True, sample_time=1e-3, method="rk4")


def test_exact_sampling_wants_two_samples_of_a_vibration():
    vibrating = oscillator(frequency=100.0, damping=1e-4)
    require_fit(vibrating, "it", stable=True, observable=True, sample_time=0.999 * math.pi / 100.0)
    assert "to a slower one" in refused(vibrating, sample_time=1.001 * math.pi / 100.0)


@pytest.mark.parametrize("asked", [{"sample_time": 0.0}, {"sample_time": math.nan}])
def test_a_wrong_sample_time_is_refused(asked):
    with pytest.raises(ParameterError, match="sample_time"):
        require_fit(oscillator(), "it", stable=True, observable=True, **asked)


def test_an_unknown_method_is_refused():
    with pytest.raises(ParameterError, match="did you mean 'euler'"):
        require_fit(oscillator(), "it", stable=True, observable=True, sample_time=1e-3, method="eular")
