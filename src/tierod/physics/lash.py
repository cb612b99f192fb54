"""A meshing of gears: elastic, damped, with free play between the flanks."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, maximum, sign, where


def lash_torque(twist: Scalar, twist_rate: Scalar, stiffness: Scalar, damping: Scalar, play: Scalar) -> Scalar:
    """Torque [N*m] that a meshing passes on, in the direction of its twist; a force where twist is a distance [m].

    Args:
        twist: of the driving against the driven side [rad], zero in the middle of the play
        twist_rate: its rate [rad/s]
        stiffness: of the flanks in contact [N*m/rad]
        damping: of the flanks in contact [N*m*s/rad]
        play: whole free way from flank to flank [rad]; zero is a meshing without play, linear in both directions

    Flanks push and never pull: parting from each other, they lose contact before the elastic part is gone.
    Source: Nordin and Gutman, Automatica 38 (2002) 1633, dead-zone model with damping; the condition on the sign is the
    release condition of their physical model.
    """
    depth = absolute(twist) - 0.5 * play
    direction = sign(twist)
    push = maximum(stiffness * depth + damping * direction * twist_rate, 0.0)
    loose = where(depth > 0.0, direction * push, 0.0)
    return where(play > 0.0, loose, stiffness * twist + damping * twist_rate)
