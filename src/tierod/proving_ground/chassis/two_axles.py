"""What mass and distances say about a car on two axles."""

from __future__ import annotations

from tierod.physics.single_track import front_axle_load


class OnTwoAxles:
    """Base of the chassis; they give mass [kg] and distances of the axles from the centre of gravity [m]."""

    mass: float
    front_distance: float
    rear_distance: float

    @property
    def wheelbase(self) -> float:
        """Distance of the axles [m]."""
        return self.front_distance + self.rear_distance

    @property
    def front_load(self) -> float:
        """Static load of the front axle [N]."""
        return front_axle_load(self.mass, self.front_distance, self.rear_distance)

    @property
    def rear_load(self) -> float:
        """Static load of the rear axle [N]."""
        return front_axle_load(self.mass, self.rear_distance, self.front_distance)
