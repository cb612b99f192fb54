from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from example_models import (
    Cart,
    CartParameters,
    ContinuousCart,
    Pendulum,
    PendulumParameters,
    Two,
    random_linear,
    with_gaps,
)
from textbook_filters import kalman_step
from tierod.core.block import units
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import pack, unpack
from tierod.methods.estimators.shapes import augment

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")
cart = KalmanFilter(
    Cart,
    CartParameters(),
    initial_mean=(0.0, 1.0),
    initial_variance=(1.0, 4.0),
    process_noise=(None, 0.01),
    measurement_noise=(0.1, 0.2),
)


def random_filter(rng, n, m, p, maskable=(), update="schmidt"):
    system, model, parameters = random_linear(rng, n, m, p)
    fields = {
        "initial_mean": tuple(rng.normal(size=n).tolist()),
        "initial_variance": tuple(rng.random(n).tolist()),
        "process_noise": tuple(rng.random(n).tolist()),
        "measurement_noise": tuple((0.1 + rng.random(p)).tolist()),
        "input_noise": tuple(None if k == 0 else float(rng.random()) for k in range(m)),
        "maskable": maskable,
        "covariance_update": update,
        "full_covariance": True,
    }
    return system, KalmanFilter(model, parameters, **fields)


def oracle(system, block, samples):
    """The textbook filter over samples (inputs, outputs, masks), as the block's own outputs."""
    n, m, p = len(system.A), system.B.shape[1], len(system.C)
    G = system.B
    w = np.array([0.0 if v is None else v for v in block.input_noise])
    Q = np.diag(block.process_noise) + G @ np.diag(w) @ G.T
    R = np.diag(block.measurement_noise)
    mean, covariance = np.array(block.initial_mean), np.diag(block.initial_variance)
    rows = []
    for sample in samples:
        u, y, given_masks = sample[:m], sample[m : m + p], sample[m + p :]
        mask = np.ones(n)
        for name, value in zip(block.maskable, given_masks, strict=True):
            mask[system.states.index(name)] = np.clip(np.nan_to_num(value), 0.0, 1.0)
        if not np.isfinite(u).all():
            covariance = covariance + np.diag(block.process_noise)
            rows.append(np.concatenate([mean, np.diag(covariance), np.full(2 * p, np.nan), [0, 0], pack(covariance)]))
            continue
        mean, covariance, r, s, nis, count = kalman_step(
            mean,
            covariance,
            lambda x, u=u: (system.A @ x + system.B @ u, system.A),
            lambda x, u=u: (system.C @ x + system.D @ u, system.C),
            Q,
            R,
            y,
            mask,
            block.covariance_update,
        )
        if block.covariance_update == "printed":
            covariance = 0.5 * (covariance + covariance.T)
        rows.append(np.concatenate([mean, np.diag(covariance), r, s, [nis, count], pack(covariance)]))
    return np.array(rows)


@pytest.mark.parametrize(
    ("n", "m", "p", "masked", "update"),
    [
        (1, 0, 1, 0, "schmidt"),
        (2, 1, 1, 0, "schmidt"),
        (3, 2, 3, 1, "printed"),
        (4, 2, 2, 2, "schmidt"),
        (5, 3, 3, 1, "schmidt"),
        (5, 3, 3, 5, "schmidt"),
    ],
)
def test_agrees_with_the_textbook(n, m, p, masked, update):
    rng = np.random.default_rng(10 * n + m)
    system, block = random_filter(rng, n, m, p, tuple(f"x{k}" for k in range(n - masked, n)), update)
    samples = np.hstack([rng.normal(size=(60, m)), with_gaps(rng, rng.normal(size=(60, p))), rng.random((60, masked))])
    if masked:
        samples[::3, -1], samples[1::3, -1], samples[5::9, -1] = 0.0, 1.0, np.nan
    if m:
        samples[20:23, 0] = np.nan
    result = scan(block, samples)
    expected = oracle(system, block, samples)
    compared = np.isfinite(expected)
    assert compared.all(axis=1).any()
    np.testing.assert_allclose(result.values[compared], expected[compared], rtol=1e-7, atol=1e-9)


def pendulum_filter(**changes):
    block = KalmanFilter(
        Pendulum,
        PendulumParameters(),
        initial_mean=(0.5, 0.0),
        initial_variance=(0.2, 0.2),
        process_noise=(None, 1e-4),
        measurement_noise=(0.01, 0.02),
        input_noise=(0.3,),
    )
    return dataclasses.replace(block, **changes)


def pendulum_samples(count=200, seed=0):
    rng = np.random.default_rng(seed)
    state, rows = Pendulum.State(0.7, 0.1), []
    for _ in range(count):
        torque = float(rng.normal())
        state = Pendulum.transition(state, Pendulum.Input(torque), PendulumParameters())
        seen = Pendulum.output(state, None, PendulumParameters())
        rows.append([torque + 0.5 * rng.normal(), seen.height + 0.1 * rng.normal(), seen.rate + 0.14 * rng.normal()])
    return np.array(rows)


def test_extended_filter_agrees_with_the_textbook_with_numeric_jacobians():
    block, samples = pendulum_filter(), pendulum_samples()
    samples[50:70, 1] = np.nan
    p = block.parameters

    def numeric(function, at):
        at, h = np.asarray(at, float), 1e-6
        columns = [
            (np.array(function(at + h * e)) - np.array(function(at - h * e))) / (2.0 * h) for e in np.eye(len(at))
        ]
        return np.array(columns).T

    mean, covariance, expected = np.array(block.initial_mean), np.diag(block.initial_variance), []
    for row in samples:
        u = Pendulum.Input(float(row[0]))

        def f(x, u=u):
            return Pendulum.transition(Pendulum.State(*map(float, x)), u, p)

        def h(x):
            return Pendulum.output(Pendulum.State(*map(float, x)), None, p)

        G = numeric(lambda v, mean=mean: Pendulum.transition(Pendulum.State(*mean), Pendulum.Input(float(v[0])), p), u)
        Q = np.diag([0.0, 1e-4]) + 0.3 * G @ G.T
        mean, covariance, r, s, nis, count = kalman_step(
            mean,
            covariance,
            lambda x, f=f: (np.array(f(x)), numeric(f, x)),
            lambda x: (np.array(h(x)), numeric(h, x)),
            Q,
            np.diag(block.measurement_noise),
            row[1:],
        )
        expected.append([*mean, *np.diag(covariance), *r, *s, nis, count])
    result = scan(block, samples)
    np.testing.assert_allclose(result.values, expected, rtol=1e-5, atol=1e-7, equal_nan=True)


def test_variance_of_a_masked_state_shrinks_only_as_printed():
    class Bias:
        """A speed with a constant bias; both are measured together."""

        State, Input, Output, Parameters = Cart.State, Cart.Input, Cart.Output, CartParameters

        @staticmethod
        def transition(x, u, p):
            return Two(0.9 * x.position + x.speed, x.speed)

        @staticmethod
        def output(x, u, p):
            return Cart.Output(x.position, x.position + x.speed)

    samples = np.tile([0.0, 1.0, 2.0, 0.0], (100, 1))
    block = dataclasses.replace(cart, model=Bias, maskable=("speed",), process_noise=(0.1, None))
    printed = scan(dataclasses.replace(block, covariance_update="printed"), samples)["variance.speed"]
    schmidt = scan(block, samples)["variance.speed"]
    np.testing.assert_array_equal(schmidt, 4.0)
    assert printed[-1] < 0.1
    np.testing.assert_array_equal(scan(block, samples)["mean.speed"], 1.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"model": ContinuousCart}, "discretise"),
        ({"model": CartParameters}, "no function `transition`"),
        ({"process_noise": (0.1,)}, "process_noise has 1 values; expected 2"),
        ({"measurement_noise": (0.1, 0.0)}, "greater than zero"),
        ({"initial_variance": (0.1, -1.0)}, "not negative"),
        ({"initial_variance": (0.1, 1)}, "expected a float"),
        ({"initial_mean": (0.1,)}, "initial_mean needs 2 values"),
        ({"initial_mean": (0.1, float("nan"))}, "initial_mean of .* is nan; expected a finite number"),
        ({"initial_variance": (0.1, float("inf"))}, "is inf; expected a float that is finite and not negative"),
        ({"input_noise": (0.1, 0.2)}, "input_noise has 2 values"),
        ({"maskable": ("sped",)}, "did you mean 'speed'"),
        ({"covariance_update": "joseph"}, "schmidt or printed"),
    ],
)
def test_wrong_tuning_is_refused(changes, words):
    with pytest.raises(ParameterError, match=words.replace("(", r"\(")):
        dataclasses.replace(cart, **changes)


def gated(gate):
    return dataclasses.replace(cart, gate=gate)


def test_the_further_a_reading_lies_beyond_the_gate_the_less_it_moves_the_estimate():
    start, bound = cart.init(), 10.83
    missing = float("nan")
    at_rest, _ = cart.step(start, cart.Sample(Cart.Input(0.0), Cart.Output(missing, missing)))

    def moved(reading):
        after, estimate = gated(bound).step(start, cart.Sample(Cart.Input(0.0), Cart.Output(reading, missing)))
        return abs(after.mean[0] - at_rest.mean[0]), estimate

    near, far, farther = (moved(reading)[0] for reading in (3.0, 30.0, 300.0))
    assert near > far > farther > 0.0
    assert moved(300.0)[1].nis == pytest.approx(bound)
    ungated, _ = cart.step(start, cart.Sample(Cart.Input(0.0), Cart.Output(300.0, missing)))
    assert farther < 0.05 * abs(ungated.mean[0] - at_rest.mean[0])


def full(values):
    return np.array(unpack(values), float)


def test_state_grows_and_the_equations_use_it():
    model = augment(Cart, "damping", "mass")
    assert model.State._fields == ("position", "speed", "damping", "mass")
    assert units(model.State) == ["m", "m/s", "N*s/m", "kg"]
    assert (model.Input, model.Output, model.Parameters) == (Cart.Input, Cart.Output, Cart.Parameters)
    x = model.State(1.0, 2.0, 0.7, 3.0)
    moved = model.transition(x, Cart.Input(5.0), CartParameters())
    plain = Cart.transition(Two(1.0, 2.0), Cart.Input(5.0), CartParameters(mass=3.0, damping=0.7))
    assert moved == (*plain, 0.7, 3.0)
    assert model.output(x, Cart.Input(5.0), CartParameters()) == Cart.output(Two(1.0, 2.0), None, CartParameters())
    assert model is augment(Cart, "damping", "mass")


Q, R = (0.1, 0.2, 0.3), (0.5, 0.6)
