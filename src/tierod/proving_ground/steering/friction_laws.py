"""Laws of dry friction of level one along the path; each law states the meaning of the level.

The path within a step is taken as one stroke without reversal, over which every law is exact at a constant rate.
Sticking is a stiff spring, level / angle, which enters the implicit integration of a steering by `slope` (see
`steering.implicit`). With 12.5 N*m, steps of 1 ms and angles down to 0.1 degrees the path is right within 1 %, even at
a pinion without motor, which such a spring would let swing with a period of 1.5 ms; still lighter and stiffer things,
and Stribeck's falling curve on them, stick and slip faster than a step resolves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Protocol

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE, Range
from tierod.core.graph.maths import sign
from tierod.physics.friction import dahl_power_update, dahl_slope, dahl_update, stribeck_level
from tierod.physics.friction_path import (
    elastoplastic_slope,
    elastoplastic_update,
    lugre_share,
    lugre_slope,
    lugre_update,
)
from tierod.proving_ground.parts import Memory


class Law(Protocol):
    """A law of dry friction; it opposes motion with the sign of the rate."""

    def remembered(self) -> Memory:
        """Relaxed, before the first motion."""

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        """Friction over its level [-].

        Args:
            memory: at the start of the step
            turned: since the start of the step [rad]
            rate: now [rad/s]
        """

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Change of the share per angle [1/rad] at the start of a step, at a rate [rad/s]."""

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step that turned by an angle."""


class Elastic:
    """Base of the laws whose only memory is their share of the level."""

    def remembered(self) -> Memory:
        """Relaxed."""
        return 0.0

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        """Friction over its level [-]."""
        return self.advance(memory, turned, rate)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        """Memory after a step."""
        raise NotImplementedError


@dataclass(frozen=True)
class FallingLevel(Elastic):
    """Base of the laws whose level falls as the rate grows.

    Args:
        angle: level over stiffness
        excess: friction at standstill above that of fast sliding, over the latter
        rate: at which the excess has fallen to 1/e
    """

    angle: Annotated[float, "rad", POSITIVE] = math.radians(1.0)
    excess: Annotated[float, "", NOT_NEGATIVE] = 0.2
    rate: Annotated[float, "rad/s", POSITIVE] = 0.1

    def _steady(self, rate: Scalar) -> Scalar:
        return stribeck_level(rate, 1.0 + self.excess, 1.0, self.rate)


@dataclass(frozen=True)
class Dahl(Elastic):
    """Exponential build-up over an angle; the level is reached in any long stroke.

    Args:
        angle: level over initial stiffness
    """

    angle: Annotated[float, "rad", POSITIVE] = math.radians(1.0)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Change of the share per angle [1/rad]."""
        return dahl_slope(memory, sign(rate), self.angle)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step."""
        return dahl_update(memory, turned, self.angle)


@dataclass(frozen=True)
class DahlPower(Elastic):
    """Dahl's law with another exponent; the level is reached in any long stroke, with exponents above one late.

    Args:
        angle: level over initial stiffness
        exponent: shape of the build-up: below one steeper, above one with a longer tail
    """

    angle: Annotated[float, "rad", POSITIVE] = math.radians(1.0)
    exponent: Annotated[float, "", Range(0.0, 5.0)] = 2.0

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Change of the share per angle [1/rad]."""
        return dahl_slope(memory, sign(rate), self.angle, self.exponent)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step."""
        return dahl_power_update(memory, turned, self.angle, self.exponent)


@dataclass(frozen=True)
class Coulomb(Elastic):
    """Coulomb's law with a stiff, elastic stick: the level is friction while moving and the limit while sticking.

    Args:
        angle: level over the stiffness of sticking
    """

    angle: Annotated[float, "rad", POSITIVE] = math.radians(0.05)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Change of the share per angle [1/rad]."""
        return elastoplastic_slope(memory, sign(rate), self.angle)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step."""
        return elastoplastic_update(memory, turned, self.angle)


@dataclass(frozen=True)
class MaxwellSlip:
    """Elastic elements that slip one after the other; the level is that of all slipping together.

    Args:
        angles: level over stiffness of every element
        shares: of the level, by element; their sum is one

    Raises:
        ParameterError: not as many shares as angles, or their sum is not one
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
        """Relaxed."""
        return (0.0,) * len(self.angles)

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        """Friction over its level [-]."""
        elements = self.advance(memory, turned, rate)
        return sum((share * element for share, element in zip(self.shares, elements, strict=True)), start=0.0)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Change of the share per angle [1/rad]."""
        elements = zip(self.shares, memory, self.angles, strict=True)
        slopes = (share * elastoplastic_slope(element, sign(rate), angle) for share, element, angle in elements)
        return sum(slopes, start=0.0)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step."""
        return tuple(
            elastoplastic_update(element, turned, angle) for element, angle in zip(memory, self.angles, strict=True)
        )


@dataclass(frozen=True)
class Stribeck(FallingLevel):
    """Dahl's build-up to a level that falls as the rate grows; the stated level is that of fast sliding.

    `angle` is level over initial stiffness, `excess` that at standstill.
    """

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        """Friction over its level [-]."""
        return dahl_update(memory, turned, self.angle) * self._steady(rate)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Change of the share per angle [1/rad]."""
        return self._steady(rate) * dahl_slope(memory, sign(rate), self.angle)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step."""
        return dahl_update(memory, turned, self.angle)


@dataclass(frozen=True)
class LuGre(FallingLevel):
    """Bristles with a falling steady curve and damping; the stated level is that of fast sliding, without damping.

    `angle` is level over the stiffness of the bristles, `excess` that of steady friction near standstill.

    Args:
        micro_time: damping over stiffness of the bristles
    """

    micro_time: Annotated[float, "s", NOT_NEGATIVE] = 2e-3

    def share(self, memory: Memory, turned: Scalar, rate: Scalar) -> Scalar:
        """Friction over its level [-]."""
        steady = self._steady(rate)
        bristle = lugre_update(memory, turned, self.angle, steady)
        return lugre_share(bristle, rate, self.angle, steady, self.micro_time)

    def slope(self, memory: Memory, rate: Scalar) -> Scalar:
        """Change of the share per angle [1/rad]."""
        return lugre_slope(memory, sign(rate), self.angle, self._steady(rate))

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar) -> Memory:
        """Memory after a step."""
        return lugre_update(memory, turned, self.angle, self._steady(rate))
