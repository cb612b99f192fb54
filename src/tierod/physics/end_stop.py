"""The stops at both ends of the travel of a steering."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, maximum, sign, where


def end_stop_torque(angle: Scalar, rate: Scalar, lock: Scalar, stiffness: Scalar, damping: Scalar) -> Scalar:
    """Torque [N*m] of an elastic, damped stop, positive where it opposes a turn to the left.

    Args:
        angle: [rad]
        rate: [rad/s]
        lock: angle at which either stop is touched [rad], positive
        stiffness: of the stop [N*m/rad]
        damping: of the stop [N*m*s/rad]

    A stop pushes and never pulls.
    """
    depth = absolute(angle) - lock
    direction = sign(angle)
    push = maximum(stiffness * depth + damping * direction * rate, 0.0)
    return where(depth > 0.0, direction * push, 0.0)
