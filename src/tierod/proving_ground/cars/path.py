"""Where a car is: along the path that it follows, and over ground."""

from __future__ import annotations

from typing import Any, NamedTuple

from tierod.core.graph.maths import cos, maximum, sin
from tierod.proving_ground.parts import Reaction

INSIDE = 0.2
"""Least share of a bend's radius that a car keeps from its centre, where the path's own frame would turn over [-]."""


class Path(NamedTuple):
    """Motion along a path; the offset is positive to its left, the heading over ground.

    Args:
        distance: of the foot of the car on the path [m]
        lateral_offset: of the car from there [m]
        heading_error: of the car against the path [rad]
        heading: of the car over ground [rad]
    """

    distance: Any
    lateral_offset: Any
    heading_error: Any
    heading: Any


START = Path(0.0, 0.0, 0.0, 0.0)


def path_rate(path: Path, reaction: Reaction, curvature: Any) -> Path:
    """Rate of change.

    Args:
        path: now
        reaction: of the chassis
        curvature: of the path [1/m]

    Source: Frenet frame; Rajamani, Vehicle Dynamics and Control (2012), section 2.5, without its small angles.
    """
    along, across = cos(path.heading_error), sin(path.heading_error)
    forward = reaction.speed * along - reaction.lateral_speed * across
    distance_rate = forward / maximum(1.0 - curvature * path.lateral_offset, INSIDE)
    sideways = reaction.speed * across + reaction.lateral_speed * along
    return Path(distance_rate, sideways, reaction.yaw_rate - curvature * distance_rate, reaction.yaw_rate)


def moved(position: tuple[Any, Any], reaction: Reaction, heading: Any, step: Any) -> tuple[Any, Any]:
    """Coordinates over ground [m] after a step.

    Args:
        position: before, x ahead and y to the left of the first heading [m]
        reaction: of the chassis at the start of the step
        heading: at the start of the step [rad]
        step: [s]

    Once a step, with speeds of its start: what that leaves out adds up to half a step of the change of speed, no more.
    """
    middle = heading + 0.5 * step * reaction.yaw_rate
    along, across = cos(middle), sin(middle)
    return (
        position[0] + step * (reaction.speed * along - reaction.lateral_speed * across),
        position[1] + step * (reaction.speed * across + reaction.lateral_speed * along),
    )
