"""Dry friction of a steering: its level, the law by which it builds up, and what makes the level vary."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tierod.core.block import Scalar
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import absolute, cos, maximum, where
from tierod.proving_ground.parts import Memory
from tierod.proving_ground.steering.friction_laws import Dahl, Law


@dataclass(frozen=True)
class Wave:
    """A level that varies once per turn of the shaft, as with a bent one or a bad universal joint.

    Args:
        torque: amplitude; where it is more than the level, friction is zero
        angle: of the shaft where friction is highest
    """

    torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    angle: Annotated[float, "rad", ANY] = 0.0


@dataclass(frozen=True)
class DryFriction:
    """Dry friction at a shaft.

    Args:
        level: torque of sliding in both directions, away from bumps, at the reference load: what faults vary and
            monitors estimate; each law of `friction_laws` defines sliding
        law: how friction builds up after a reversal; angles scale with nothing, so stiffness grows with the level
        load_share: share of the friction that is proportional to the load
        left_excess, right_excess: more torque while turning to one side only
        bump: more torque about one angle, as of a dented ball or tooth
        bump_angle: where the bump is highest
        bump_width: from there to where it ends, on either side
        wave: None for a level without waves
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
        """Relaxed, before the first motion."""
        return self.law.remembered()

    def torque(self, memory: Memory, turned: Scalar, rate: Scalar, load: Scalar = 1.0, angle: Scalar = 0.0) -> Scalar:
        """Torque that opposes motion [N*m], exact over a path without reversal.

        Args:
            memory: at the start of the step
            turned: since the start of the step [rad]
            rate: now [rad/s]
            load: what presses the surfaces together, over its reference [-]
            angle: now [rad]
        """
        share = self.law.share(memory, turned, rate)
        sided = self._level_at(angle) + where(share > 0.0, self.left_excess, self.right_excess)
        return share * sided * (1.0 + self.load_share * (absolute(load) - 1.0))

    def stiffness(self, memory: Memory, rate: Scalar, angle: Scalar = 0.0) -> Scalar:
        """Growth of the torque per angle [N*m/rad] at the start of a step, at the reference load.

        Args:
            memory: at the start of the step
            rate: then [rad/s]
            angle: then [rad]
        """
        sided = self._level_at(angle) + where(rate > 0.0, self.left_excess, self.right_excess)
        return sided * self.law.slope(memory, rate)

    def advance(self, memory: Memory, turned: Scalar, rate: Scalar, load: Scalar = 1.0, angle: Scalar = 0.0) -> Memory:
        """Memory after a step; arguments as of `torque`."""
        return self.law.advance(memory, turned, rate)

    def sliding_level(self, angle: Scalar) -> Scalar:
        """Torque of sliding [N*m] at an angle and the reference load, the mean of both directions: the truth."""
        return self._level_at(angle) + 0.5 * (self.left_excess + self.right_excess)

    def _level_at(self, angle: Scalar) -> Scalar:
        aside = (angle - self.bump_angle) / self.bump_width
        rest = maximum(1.0 - aside * aside, 0.0)
        level = self.level + self.bump * rest * rest
        if self.wave is None:
            return level
        return maximum(level + self.wave.torque * cos(angle - self.wave.angle), 0.0)
