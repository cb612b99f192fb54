"""The air around a chassis."""

from __future__ import annotations

from typing import Any, Protocol

from tierod.physics.resistances import AirForces, air_forces
from tierod.proving_ground.parts import Road, Wind


class Shape(Protocol):
    """What of a chassis the air meets, see `tierod.physics.resistances.air_forces`."""

    @property
    def drag_area(self) -> float:
        """[m**2]."""

    @property
    def side_area(self) -> float:
        """[m**2]."""

    @property
    def side_force_lead(self) -> float:
        """[m]."""


def air_on(shape: Shape, motion: Any, road: Road, wind: Wind) -> AirForces:
    """Forces of the air on a moving car; none on a hoist, which stands in a hall.

    Args:
        shape: of the car
        motion: with its speeds along and across the body
        road: under the car
        wind: over ground
    """
    return air_forces(
        motion.speed + wind.headwind_speed,
        motion.lateral_speed - wind.crosswind_speed,
        road.support * shape.drag_area,
        road.support * shape.side_area,
        shape.side_force_lead,
    )
