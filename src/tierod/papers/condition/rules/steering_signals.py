"""Angle, rate and acceleration of the steering with all that is compared to them, delayed alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import both, exp, present, tanh, where
from tierod.core.ranges import POSITIVE


class Smooth(NamedTuple):
    """A value after a low-pass of the second order, its slope, and whether it follows a signal that is there."""

    value: Any
    rate: Any
    follows: Any


@dataclass(frozen=True)
class SteeringSignals:
    """What the linear models of torque and tie-rod force stand on: all through one low-pass of the second order.

    Args:
        bandwidth: of the low-pass, critically damped; the angle's steps of 0.1 degrees must not dominate its second
            derivative
        friction_width: rate of the column over which the sign of its friction turns round
        sample_time: between two samples

    What is missing is held; where it comes again the low-pass begins there.
    """

    bandwidth: Annotated[float, "rad/s", POSITIVE] = 30.0
    friction_width: Annotated[float, "rad/s", POSITIVE] = 0.2
    sample_time: Annotated[float, "s", POSITIVE] = 0.01

    class Sample(NamedTuple):
        """Signals of the steering; NaN where missing."""

        steering_wheel_angle: Annotated[float, "rad"]
        steering_shaft_torque: Annotated[float, "N*m"]
        tie_rod_force: Annotated[float, "N"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    class Output(NamedTuple):
        """The signals, smooth; the angle's rate, its mean acceleration over the sample, and its direction (-1 to 1)."""

        angle: Annotated[float, "rad"]
        rate: Annotated[float, "rad/s"]
        acceleration: Annotated[float, "rad/s**2"]
        direction: Annotated[float, ""]
        torque: Annotated[float, "N*m"]
        force: Annotated[float, "N"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    def init(self) -> tuple[Smooth, ...]:
        """All at zero, until a signal comes."""
        return (Smooth(0.0, 0.0, 0.0),) * 4

    def step(self, state: tuple[Smooth, ...], sample: Sample) -> tuple[tuple[Smooth, ...], Output]:
        """One sample on."""
        after = tuple(self._follow(each, value) for each, value in zip(state, sample, strict=True))
        angle, torque, force, lateral = after
        acceleration = (angle.rate - state[0].rate) / self.sample_time
        direction = tanh(angle.rate / self.friction_width)
        return after, self.Output(
            angle.value, angle.rate, acceleration, direction, torque.value, force.value, lateral.value
        )

    def _follow(self, before: Smooth, value: Any) -> Smooth:
        """The solution of x'' = w^2 (u - x) - 2 w x' over a sample with constant u, from where a signal comes."""
        there, follows = present(value), before.follows > 0.5
        travel = self.bandwidth * self.sample_time
        away = where(both(there, follows), before.value - value, 0.0)
        faded = exp(-travel)
        rest = faded * ((1.0 + travel) * away + self.sample_time * before.rate)
        rate = faded * ((1.0 - travel) * before.rate - self.bandwidth * travel * away)
        after = before.value - away + rest
        held = where(there, value, before.value)
        return Smooth(where(follows, after, held), where(follows, rate, 0.0), where(there, 1.0, 0.0))
