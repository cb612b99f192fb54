"""Dry friction of a steering: its level, the law of its build-up, and dependences of the level."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tierod.core.block import Scalar
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import absolute, cos, maximum, where
from tierod_lab.ground.parts import Memory
from tierod_lab.ground.steering.friction_laws import Dahl, Law


@dataclass(frozen=True)
class Wave:
    """Variation of the level once per turn of the shaft, as with a bent shaft or a bad universal joint.

    Args:
        torque: amplitude; friction is zero where the amplitude exceeds the level
    """

    torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    angle: Annotated[float, "rad", ANY] = 0.0


@dataclass(frozen=True)
class DryFriction:
    """Dry friction at a shaft.

    Args:
        level: sliding torque in both directions, away from bumps, at the reference load, which faults change and
            monitors estimate; each law of `friction_laws` defines sliding
        law: law of the build-up after a reversal; its angles are constants, so that stiffness grows with the level
        wave: None for a level without variation over the turn
    """

    level: Annotated[float, "N*m", NOT_NEGATIVE] = 4.0
    law: Law = field(default_factory=Dahl)
    load_share: Annotated[float, "", SHARE] = 0.0
    left_excess: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    right_excess: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    bump: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    bump_angle: Annotated[float, "rad", ANY] = 0.0
    bump_width: Annotated[float, "rad", POSITIVE] = 0.2
    wave: Wave | None = None

    def remembered(self) -> Memory:
        """Memory of relaxed friction, before the first motion."""
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
