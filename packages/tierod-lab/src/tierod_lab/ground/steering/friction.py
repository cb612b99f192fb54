"""Friction of the steering: dry friction by several laws, exact over a path, and its level by the load."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Protocol

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE, Range
from tierod.core.graph.maths import absolute, cos, exp, limit, maximum, sign, where
from tierod.physics.friction import dahl_slope, dahl_update
from tierod_lab.ground.laws import dahl_power_update, lugre_bristle_rate, lugre_torque, stribeck_level
from tierod_lab.ground.parts import Memory


def _elastic(share: Scalar, turned: Scalar, angle: Scalar) -> Scalar:
    """Friction share [-] of an elastic element that slips at its level, after a turn [rad].

    Source: one element of Iwan, J. Appl. Mech. 33 (1966) 893; the Maxwell slip model (Lampaert, Swevers, Al-Bender,
    IEEE TAC 47 (2002) 683) is a sum of such elements.
    """
    return limit(share + turned / angle, -1.0, 1.0)


def _elastic_slope(share: Scalar, rate: Scalar, angle: Scalar) -> Scalar:
    return where(share * sign(rate) < 1.0, 1.0 / angle, 0.0)


class Law(Protocol):
    """Law of dry friction; the friction opposes motion and is positive for a positive rate."""

    def remembered(self) -> Memory:
        """Memory of relaxed friction, before the first motion."""

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        """Friction divided by its level [-].

        Args:
            turned: angle since the start of the step [rad]
            rate: present rate [rad/s]
        """

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Derivative of the share with respect to the angle [1/rad] at the start of a step, at a rate [rad/s]."""

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step over an angle [rad], with a rate [rad/s] at its end."""


class Elastic:
    """Base class of the laws whose only memory is their share of the level."""

    def remembered(self) -> Memory:
        return 0.0

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        return self.advance(memory, turned, rate)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        raise NotImplementedError


@dataclass(frozen=True)
class FallingLevel(Elastic):
    """Base class of the laws whose level falls with the rate (Stribeck effect)."""

    angle: Annotated[float, "rad", POSITIVE] = math.radians(1.0)
    excess: Annotated[float, "", NOT_NEGATIVE] = 0.2
    rate: Annotated[float, "rad/s", POSITIVE] = 0.1

    def _steady(self, rate: Scalar) -> Scalar:
        return stribeck_level(rate, 1.0 + self.excess, 1.0, self.rate)


@dataclass(frozen=True)
class Dahl(Elastic):
    """Exponential build-up over an angle; friction reaches the level in any long stroke."""

    angle: Annotated[float, "rad", POSITIVE] = math.radians(1.0)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        return dahl_slope(memory, sign(rate), self.angle)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return dahl_update(memory, turned, self.angle)


@dataclass(frozen=True)
class DahlPower(Elastic):
    """Dahl's law with another exponent; friction reaches the level in any long stroke, later with larger exponents."""

    angle: Annotated[float, "rad", POSITIVE] = math.radians(1.0)
    exponent: Annotated[float, "", Range(0.0, 5.0)] = 2.0

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        return dahl_slope(memory, sign(rate), self.angle, self.exponent)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return dahl_power_update(memory, turned, self.angle, self.exponent)


@dataclass(frozen=True)
class Coulomb(Elastic):
    """Coulomb's law with stiff, elastic sticking: the level is the sliding friction and the limit of sticking."""

    angle: Annotated[float, "rad", POSITIVE] = math.radians(0.05)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        return _elastic_slope(memory, rate, self.angle)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return _elastic(memory, turned, self.angle)


@dataclass(frozen=True)
class MaxwellSlip:
    """Maxwell-slip model of parallel elastic elements that slip one after another; the level is reached when all slip.

    Args:
        shares: share of the level by element; their sum is one
    """

    angles: Annotated[tuple[float, ...], "rad", POSITIVE] = tuple(math.radians(k) for k in (0.75, 1.5, 2.25, 3.0))
    shares: Annotated[tuple[float, ...], "", SHARE] = (0.25, 0.25, 0.25, 0.25)

    def __post_init__(self) -> None:
        if len(self.angles) != len(self.shares) or not math.isclose(sum(self.shares), 1.0, abs_tol=1e-9):
            raise ParameterError(
                f"Maxwell slip has {len(self.angles)} angles and the shares {self.shares}; "
                "give one share per angle, and let their sum be 1"
            )

    def remembered(self) -> Memory:
        return (0.0,) * len(self.angles)

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        elements = self.advance(memory, turned, rate)
        return sum((share * element for share, element in zip(self.shares, elements, strict=True)), start=0.0)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        elements = zip(self.shares, memory, self.angles, strict=True)
        slopes = (share * _elastic_slope(element, rate, angle) for share, element, angle in elements)
        return sum(slopes, start=0.0)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return tuple(_elastic(element, turned, angle) for element, angle in zip(memory, self.angles, strict=True))


@dataclass(frozen=True)
class Stribeck(FallingLevel):
    """Dahl's build-up to a level that falls with the rate; the stated level is that of fast sliding.

    `angle` is the level divided by the initial stiffness, and `excess` the excess at standstill.
    """

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        return dahl_update(memory, turned, self.angle) * self._steady(rate)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        return self._steady(rate) * dahl_slope(memory, sign(rate), self.angle)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return dahl_update(memory, turned, self.angle)


@dataclass(frozen=True)
class LuGre(FallingLevel):
    """Bristle model with a falling steady-state curve and damping; the level is that of fast sliding, without damping.

    `angle` is the level divided by the bristle stiffness, and `excess` that of steady-state friction near standstill.
    The memory is the bristle deflection times its stiffness over the sliding level.
    Source: Canudas de Wit et al., IEEE TAC 40 (1995) 419, eq (2), solved over the angle:
    dz/d theta = s - sigma_0 z / g with s = sgn(d theta).
    """

    micro_time: Annotated[float, "s", NOT_NEGATIVE] = 2e-3  # damping over stiffness of the bristles

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        bristle = self.advance(memory, turned, rate)
        bristle_rate = lugre_bristle_rate(bristle, rate, 1.0, self._steady(rate)) / self.angle
        return lugre_torque(bristle, bristle_rate, rate, 1.0, self.micro_time, 0.0)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        bristle: Scalar = memory
        return (1.0 - sign(rate) * bristle / self._steady(rate)) / self.angle

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        steady = self._steady(rate)
        settled = sign(turned) * steady
        return settled + (memory - settled) * exp(-absolute(turned) / (self.angle * steady))


@dataclass(frozen=True)
class Wave:
    """Variation of the level once per turn of the shaft, as with a bent shaft or a bad universal joint."""

    # amplitude; friction is zero where the amplitude exceeds the level
    torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    angle: Annotated[float, "rad", ANY] = 0.0


@dataclass(frozen=True)
class DryFriction:
    """Dry friction at a shaft."""

    # sliding torque in both directions, away from bumps, at the reference load, which faults change and monitors
    # estimate; each law of `friction_laws` defines sliding
    level: Annotated[float, "N*m", NOT_NEGATIVE] = 4.0
    # law of the build-up after a reversal; its angles are constants, so that stiffness grows with the level
    law: Law = field(default_factory=Dahl)
    load_share: Annotated[float, "", SHARE] = 0.0
    left_excess: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    right_excess: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    bump: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    bump_angle: Annotated[float, "rad", ANY] = 0.0
    bump_width: Annotated[float, "rad", POSITIVE] = 0.2
    wave: Wave | None = None  # None for a level without variation over the turn

    def remembered(self) -> Memory:
        return self.law.remembered()

    def torque(self, memory: Memory, turned: Scalar, rate: Scalar, load: Scalar = 1.0, angle: Scalar = 0.0) -> Scalar:
        """Torque that opposes motion, exact over a path without reversal [N*m]; arguments as in `Law.share`.

        Args:
            load: load of the sliding surfaces, divided by its reference [-]
            angle: present angle [rad]
        """
        share = self.law.share(memory, turned, rate)
        sided = self._level_at(angle) + where(share > 0.0, self.left_excess, self.right_excess)
        return share * sided * (1.0 + self.load_share * (absolute(load) - 1.0))

    def stiffness(self, memory: Memory, rate: Scalar, angle: Scalar = 0.0) -> Scalar:
        """Derivative of the torque by the angle [N*m/rad] at the start of a step, at the reference load."""
        sided = self._level_at(angle) + where(rate > 0.0, self.left_excess, self.right_excess)
        return sided * self.law.slope(memory, rate)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar, load: Scalar = 1.0, angle: Scalar = 0.0) -> Memory:
        return self.law.advance(memory, turned, rate)

    def sliding_level(self, angle: Scalar) -> Scalar:
        """Sliding torque at an angle and the reference load, mean of both directions [N*m]; the true level."""
        return self._level_at(angle) + 0.5 * (self.left_excess + self.right_excess)

    def _level_at(self, angle: Scalar) -> Scalar:
        aside = (angle - self.bump_angle) / self.bump_width
        rest = maximum(1.0 - aside * aside, 0.0)
        level = self.level + self.bump * rest * rest
        if self.wave is None:
            return level
        return maximum(level + self.wave.torque * cos(angle - self.wave.angle), 0.0)
