"""Friction of the steering: dry friction by several laws, exact over a path, and its level by the load."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Protocol

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE, Range
from tierod.core.graph.maths import absolute, cos, exp, limit, maximum, sign, where
from tierod.physics.friction import (
    dahl_power_update,
    dahl_slope,
    dahl_update,
    lugre_bristle_rate,
    lugre_torque,
    stribeck_level,
)
from tierod_lab.ground.parts import Memory


def elastoplastic_update(share: Scalar, angle_increment: Scalar, elastic_angle: Scalar) -> Scalar:
    """Friction share [-] of an elastic element that slips at its level, after an angle increment.

    Args:
        share: before the increment [-]
        angle_increment: [rad], without reversal inside
        elastic_angle: level over stiffness [rad], positive; tends to Coulomb's law as it tends to zero

    Source: one element of Iwan, J. Appl. Mech. 33 (1966) 893; the Maxwell slip model (Lampaert, Swevers, Al-Bender,
    IEEE TAC 47 (2002) 683) is a sum of such elements.
    """
    return limit(share + angle_increment / elastic_angle, -1.0, 1.0)


def elastoplastic_slope(share: Scalar, direction: Scalar, elastic_angle: Scalar) -> Scalar:
    """Derivative of the friction share with respect to the angle [1/rad]: slope of `elastoplastic_update`.

    Args:
        share: friction share at present [-]
        direction: sign of the rate [-]; zero at rest, where the element sticks
        elastic_angle: level over stiffness [rad], positive

    An elastic element that slips at its level.
    """
    return where(share * direction < 1.0, 1.0 / elastic_angle, 0.0)


def lugre_update(bristle: Scalar, angle_increment: Scalar, bristle_angle: Scalar, steady_share: Scalar) -> Scalar:
    """Normalised bristle deflection [-] of the LuGre model after an angle increment at a constant rate.

    Args:
        bristle: deflection times bristle stiffness over the sliding level, before the increment [-]
        angle_increment: [rad], without reversal inside
        bristle_angle: sliding level over bristle stiffness [rad], positive
        steady_share: steady friction at this rate over the sliding level, g of the paper [-], positive

    Source: Canudas de Wit et al., IEEE TAC 40 (1995) 419, eq (2), solved over the angle:
    dz/d theta = s - sigma_0 z / g with s = sgn(d theta).
    """
    settled = sign(angle_increment) * steady_share
    return settled + (bristle - settled) * exp(-absolute(angle_increment) / (bristle_angle * steady_share))


def lugre_slope(bristle: Scalar, direction: Scalar, bristle_angle: Scalar, steady_share: Scalar) -> Scalar:
    """Derivative of the normalised bristle deflection with respect to the angle [1/rad].

    Args:
        bristle: normalised deflection, from `lugre_update` [-]
        direction: sign of the rate [-]
        bristle_angle: sliding level over bristle stiffness [rad]
        steady_share: as in `lugre_update` [-]

    Source: the equation that `lugre_update` solves.
    """
    return (1.0 - direction * bristle / steady_share) / bristle_angle


def lugre_share(
    bristle: Scalar, rate: Scalar, bristle_angle: Scalar, steady_share: Scalar, micro_time: Scalar
) -> Scalar:
    """Friction share [-] of the LuGre model without its viscous term.

    Args:
        bristle: normalised deflection, from `lugre_update` [-]
        rate: angular rate [rad/s]
        bristle_angle: sliding level over bristle stiffness [rad]
        steady_share: as in `lugre_update` [-]
        micro_time: damping over stiffness of the bristles, sigma_1 / sigma_0 [s]

    Source: `lugre_torque`, with the sliding level as unit of torque and `bristle_angle` as unit of deflection.
    """
    bristle_rate = lugre_bristle_rate(bristle, rate, 1.0, steady_share) / bristle_angle
    return lugre_torque(bristle, bristle_rate, rate, 1.0, micro_time, 0.0)


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
        return elastoplastic_slope(memory, sign(rate), self.angle)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return elastoplastic_update(memory, turned, self.angle)


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
        slopes = (share * elastoplastic_slope(element, sign(rate), angle) for share, element, angle in elements)
        return sum(slopes, start=0.0)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return tuple(
            elastoplastic_update(element, turned, angle) for element, angle in zip(memory, self.angles, strict=True)
        )


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
    """

    micro_time: Annotated[float, "s", NOT_NEGATIVE] = 2e-3

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        steady = self._steady(rate)
        bristle = lugre_update(memory, turned, self.angle, steady)
        return lugre_share(bristle, rate, self.angle, steady, self.micro_time)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        return lugre_slope(memory, sign(rate), self.angle, self._steady(rate))

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        return lugre_update(memory, turned, self.angle, self._steady(rate))


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
        """Torque that opposes motion, exact over a path without reversal [N*m].

        Args:
            turned: angle since the start of the step [rad]
            rate: present rate [rad/s]
            load: load of the sliding surfaces, divided by its reference [-]
            angle: present angle [rad]
        """
        share = self.law.share(memory, turned, rate)
        sided = self._level_at(angle) + where(share > 0.0, self.left_excess, self.right_excess)
        return share * sided * (1.0 + self.load_share * (absolute(load) - 1.0))

    def stiffness(self, memory: Memory, rate: Scalar, angle: Scalar = 0.0) -> Scalar:
        """Derivative of the torque with respect to the angle [N*m/rad] at the start of a step, at the reference load.

        Args:
            rate: rate at the start of the step [rad/s]
            angle: angle at the start of the step [rad]
        """
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
