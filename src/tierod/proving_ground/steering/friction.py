"""Dry friction of a steering: a level, the law by which it builds up, and what makes the level vary."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, Protocol

from tierod.physics.friction import dahl_update
from tierod.ranges import NOT_NEGATIVE, POSITIVE


class Law(Protocol):
    """How dry friction of level one follows the path; it opposes motion with the sign of the rate.

    The path within a step is taken as one stroke without reversal, over which a law is exact.
    """

    def remembered(self) -> Any:
        """Relaxed, before the first motion."""

    def share(self, memory: Any, turned: Any, rate: Any) -> Any:
        """Friction over its level [-].

        Args:
            memory: at the start of the step
            turned: since the start of the step [rad]
            rate: now [rad/s]
        """

    def advance(self, memory: Any, turned: Any, rate: Any) -> Any:
        """Memory after a step that turned by an angle."""


@dataclass(frozen=True)
class Dahl:
    """Exponential build-up over an angle; the level is that of sliding.

    Args:
        angle: level over initial stiffness
    """

    angle: Annotated[float, "rad", POSITIVE] = math.radians(1.0)

    def remembered(self) -> Any:
        """Relaxed."""
        return 0.0

    def share(self, memory: Any, turned: Any, rate: Any) -> Any:
        """Friction over its level."""
        return dahl_update(memory, turned, self.angle)

    def advance(self, memory: Any, turned: Any, rate: Any) -> Any:
        """Memory after a step."""
        return dahl_update(memory, turned, self.angle)


@dataclass(frozen=True)
class DryFriction:
    """Dry friction at a shaft.

    Args:
        level: torque while sliding, at the reference load: what faults vary and monitors estimate
        law: how friction builds up after a reversal
    """

    level: Annotated[float, "N*m", NOT_NEGATIVE] = 4.0
    law: Law = field(default_factory=Dahl)

    def remembered(self) -> Any:
        """Relaxed."""
        return self.law.remembered()

    def torque(self, memory: Any, turned: Any, rate: Any, load: Any, angle: Any = 0.0) -> Any:
        """Torque that opposes motion [N*m].

        Args:
            memory: at the start of the step
            turned: since the start of the step [rad]
            rate: now [rad/s]
            load: what presses the surfaces together
            angle: now [rad]
        """
        return self.level * self.law.share(memory, turned, rate)

    def advance(self, memory: Any, turned: Any, rate: Any, load: Any, angle: Any = 0.0) -> Any:
        """Memory after a step that turned by an angle."""
        return self.law.advance(memory, turned, rate)
