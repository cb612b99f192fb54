"""Models and stepping helpers for the tests of estimators, filters and detectors."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Ring, leaves, rebuild, skeleton
from tierod.core.graph import maths, scan
from tierod.models.linear import LinearSystem, as_model


class Two(NamedTuple):
    position: Annotated[float, "m"]
    speed: Annotated[float, "m/s"]


class Force(NamedTuple):
    force: Annotated[float, "N"]


class Position(NamedTuple):
    position: Annotated[float, "m"]


class Both(NamedTuple):
    position: Annotated[float, "m"]
    speed: Annotated[float, "m/s"]


@dataclass(frozen=True)
class CartParameters:
    mass: Annotated[float, "kg"] = 2.0
    damping: Annotated[float, "N*s/m"] = 0.5
    sample_time: Annotated[float, "s"] = 0.1


class Cart:
    """A damped mass, Euler steps."""

    State, Input, Output, Parameters = Two, Force, Both, CartParameters

    @staticmethod
    def transition(x, u, p):
        acceleration = (u.force - p.damping * x.speed) / p.mass
        return Two(x.position + p.sample_time * x.speed, x.speed + p.sample_time * acceleration)

    @staticmethod
    def output(x, u, p):
        return Both(x.position, x.speed)


class ContinuousCart:
    """The same mass as differential equations."""

    State, Input, Output, Parameters = Two, Force, Both, CartParameters

    @staticmethod
    def derivative(x, u, p):
        return Two(x.speed, (u.force - p.damping * x.speed) / p.mass)

    @staticmethod
    def output(x, u, p):
        return Both(x.position, x.speed)


class Swing(NamedTuple):
    angle: Annotated[float, "rad"]
    rate: Annotated[float, "rad/s"]


class Torque(NamedTuple):
    torque: Annotated[float, "N*m"]


class Seen(NamedTuple):
    height: Annotated[float, "m"]
    rate: Annotated[float, "rad/s"]


@dataclass(frozen=True)
class PendulumParameters:
    length: Annotated[float, "m"] = 1.3
    sample_time: Annotated[float, "s"] = 0.02


class Pendulum:
    """Nonlinear in transition and output."""

    State, Input, Output, Parameters = Swing, Torque, Seen, PendulumParameters

    @staticmethod
    def transition(x, u, p):
        slope = -9.81 / p.length * maths.sin(x.angle) + u.torque * maths.cos(x.angle)
        return Swing(x.angle + p.sample_time * x.rate, x.rate + p.sample_time * slope)

    @staticmethod
    def output(x, u, p):
        return Seen(p.length * maths.sin(x.angle), x.rate + 0.1 * x.rate * x.rate)


def named(name, fields):
    return NamedTuple(name, [(field, float) for field in fields])


def random_linear(rng, n, inputs, outputs):
    """A random stable system with some structural zeros and ones, as (system, model, parameters)."""
    A = rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.7)
    A *= 0.98 / max(np.abs(np.linalg.eigvals(A)).max(), 1e-3)
    A[rng.random((n, n)) < 0.1] = 0.0
    B = rng.normal(size=(n, inputs))
    C = rng.normal(size=(outputs, n)) * (rng.random((outputs, n)) < 0.7)
    C[np.arange(outputs), rng.integers(0, n, outputs)] = 1.0
    D = rng.normal(size=(outputs, inputs))
    system = LinearSystem.of(A, C, B, D)
    shapes = [
        named("State", [f"x{k}" for k in range(n)]),
        named("Input", [f"u{k}" for k in range(inputs)]),
        named("Output", [f"y{k}" for k in range(outputs)]),
    ]
    return system, *as_model(system, *shapes)


def float_steps(block, samples):
    """Outputs of a block stepped as plain floats, (n, outputs), and its final state; delay lines by hand."""
    state = block.init()
    lines = {path: deque([leaf.initial] * leaf.size) for path, leaf in leaves(state) if isinstance(leaf, Ring)}
    shape = skeleton(block.Sample)
    outputs = []
    for row in np.atleast_2d(np.asarray(samples, float).T).T.tolist():
        ready = [
            leaf._replace(oldest=lines[path][0]) if isinstance(leaf, Ring) else leaf for path, leaf in leaves(state)
        ]
        state, output = block.step(rebuild(state, ready), rebuild(shape, row))
        for path, leaf in leaves(state):
            if isinstance(leaf, Ring):
                lines[path].popleft()
                lines[path].append(leaf.newest)
        outputs.append([float(leaf) for _, leaf in leaves(output)])
    return np.array(outputs), state


def assert_floats_equal_scan(block, samples, rtol=1e-10):
    """Plain floats and the compiled graph agree, NaN included; returns the scan."""
    result = scan(block, samples)
    floats, _ = float_steps(block, samples)
    np.testing.assert_allclose(floats, result.values, rtol=rtol, atol=1e-12, equal_nan=True)
    return result


def with_gaps(rng, values, share=0.3):
    """A copy with NaN, and now and then infinity, in a share of the places."""
    values = np.array(values, float)
    values[rng.random(values.shape) < share] = math.nan
    values[rng.random(values.shape) < share / 20.0] = math.inf
    return values
