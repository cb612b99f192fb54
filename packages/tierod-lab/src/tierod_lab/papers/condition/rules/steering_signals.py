"""Filters of the steering: equally delayed signals for the linear models, and lost shares of two torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import both, exp, present, tanh, where


class Smooth(NamedTuple):
    """Output of a second-order low-pass, its derivative, and whether it follows a present signal, 1.0 or 0.0."""

    value: Scalar
    rate: Scalar
    follows: Scalar


@dataclass(frozen=True)
class SteeringSignals:
    """Regressors of the linear models of torque and tie-rod force, all through the same second-order low-pass.

    Args:
        bandwidth: bandwidth of the critically damped low-pass; low enough that the angle's quantisation of 0.1 degrees
            does not dominate its second derivative
        friction_width: column rate over which the sign of the friction is smoothed

    A missing signal is held; the low-pass restarts at the first value after the gap.
    """

    bandwidth: Annotated[float, "rad/s", POSITIVE] = 30.0
    friction_width: Annotated[float, "rad/s", POSITIVE] = 0.2
    sample_time: Annotated[float, "s", POSITIVE] = 0.01

    class Sample(NamedTuple):
        steering_wheel_angle: Annotated[float, "rad"]
        steering_shaft_torque: Annotated[float, "N*m"]
        tie_rod_force: Annotated[float, "N"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    class Output(NamedTuple):
        angle: Annotated[float, "rad"]
        rate: Annotated[float, "rad/s"]
        acceleration: Annotated[float, "rad/s**2"]
        direction: Annotated[float, ""]
        torque: Annotated[float, "N*m"]
        force: Annotated[float, "N"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    def init(self) -> tuple[Smooth, ...]:
        return (Smooth(0.0, 0.0, 0.0),) * 4

    def step(self, state: tuple[Smooth, ...], sample: Sample) -> tuple[tuple[Smooth, ...], Output]:
        after = tuple(self._follow(each, value) for each, value in zip(state, sample, strict=True))
        angle, torque, force, lateral = after
        acceleration = (angle.rate - state[0].rate) / self.sample_time
        direction = tanh(angle.rate / self.friction_width)
        return after, self.Output(
            angle.value, angle.rate, acceleration, direction, torque.value, force.value, lateral.value
        )

    def _follow(self, before: Smooth, value: Scalar) -> Smooth:
        """Exact solution of x'' = w^2 (u - x) - 2 w x' over a sample with constant u, from the first value present."""
        there, follows = present(value), before.follows > 0.5
        travel = self.bandwidth * self.sample_time
        away = where(both(there, follows), before.value - value, 0.0)
        faded = exp(-travel)
        rest = faded * ((1.0 + travel) * away + self.sample_time * before.rate)
        rate = faded * ((1.0 - travel) * before.rate - self.bandwidth * travel * away)
        after = before.value - away + rest
        held = where(there, value, before.value)
        return Smooth(where(follows, after, held), where(follows, rate, 0.0), where(there, 1.0, 0.0))


@dataclass(frozen=True)
class LostShares:
    """Least squares with forgetting for two lost shares: missing = first share * first + second share * second.

    Args:
        memory: time constant of forgetting; longer is less noisy and later
        doubt: magnitude of the regressors below which the regularisation draws the shares to zero, in their unit

    Regressors in a constant proportion are collinear; then the regularisation alone decides between the shares.
    """

    memory: Annotated[float, "s", POSITIVE]
    doubt: Annotated[float, "unit of the signal", POSITIVE]
    sample_time: Annotated[float, "s", POSITIVE]

    class Sample(NamedTuple):
        missing: Annotated[float, "unit of the signal"]
        first: Annotated[float, "unit of the signal"]
        second: Annotated[float, "unit of the signal"]

    class State(NamedTuple):
        first: Scalar
        mixed: Scalar
        second: Scalar
        missing_first: Scalar
        missing_second: Scalar

    class Output(NamedTuple):
        first: Annotated[float, ""]
        second: Annotated[float, ""]

    def init(self) -> State:
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, state: State, sample: Sample, enabled: Scalar = True) -> tuple[State, Output]:
        # Not finite as soon as one of the three is missing.
        whole = (sample.missing + sample.first + sample.second) * 0.5
        use = where(present(whole), enabled, 0.0)
        missing, first, second = (where(use, value, 0.0) for value in sample)
        keep = exp(-self.sample_time / self.memory)
        products = (first * first, first * second, second * second, missing * first, missing * second)
        after = self.State(
            *(where(use, keep * old + (1.0 - keep) * new, old) for old, new in zip(state, products, strict=True))
        )
        square = self.doubt * self.doubt
        a, b, c = after.first + square, after.mixed, after.second + square
        # Positive by the regularisation, so it needs no guard.
        determinant = a * c - b * b
        shares = (
            (c * after.missing_first - b * after.missing_second) / determinant,
            (a * after.missing_second - b * after.missing_first) / determinant,
        )
        return after, self.Output(*shares)
