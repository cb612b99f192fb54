"""The parameters of the full chassis and what follows from them alone."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, Self

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics import single_track
from tierod.proving_ground.chassis.suspension import Axle, Kingpins
from tierod.proving_ground.chassis.two_axles import OnTwoAxles
from tierod.proving_ground.chassis.tyres import Tyre


@dataclass(frozen=True)
class TwoTrackParameters(OnTwoAxles):
    """Body, axles and air of a chassis with four wheels.

    Defaults are those of a mid-size car, typical unless said otherwise; its axle stiffnesses, with compliance, are 110
    and 130 kN/rad.

    Args:
        centre_height: of the centre of gravity, above ground
        roll_inertia: of the body about the centre of gravity of the car
        suspension_lag: of loads and compliance behind the forces
        drag_area, side_area: drag coefficient, and slope of the side force with the flow's angle, times frontal area
        side_force_lead: of the point where the wind's side force acts, ahead of the centre of gravity
        front, rear: axles
        kingpins: of the front axle
    """

    mass: Annotated[float, "kg", POSITIVE] = 1600.0
    yaw_inertia: Annotated[float, "kg*m**2", POSITIVE] = 2800.0
    front_distance: Annotated[float, "m", POSITIVE] = 1.14
    rear_distance: Annotated[float, "m", POSITIVE] = 1.69
    centre_height: Annotated[float, "m", POSITIVE] = 0.55
    roll_inertia: Annotated[float, "kg*m**2", POSITIVE] = 600.0
    suspension_lag: Annotated[float, "s", POSITIVE] = 0.012
    drag_area: Annotated[float, "m**2", NOT_NEGATIVE] = 0.65
    side_area: Annotated[float, "m**2", NOT_NEGATIVE] = 5.0
    side_force_lead: Annotated[float, "m"] = 0.5
    front: Axle = field(default_factory=lambda: Axle(1.55, 0.05, 64e3, 2700.0, 3.32e-6, 1.3))
    rear: Axle = field(default_factory=lambda: Axle(1.54, 0.10, 44e3, 2200.0, 0.13e-6, 1.1))
    kingpins: Kingpins = field(default_factory=Kingpins)

    @property
    def roll_arm(self) -> float:
        """Height of the centre of gravity above the roll axis [m]."""
        axis = self.rear_distance * self.front.roll_centre_height + self.front_distance * self.rear.roll_centre_height
        return self.centre_height - axis / self.wheelbase

    @property
    def understeer_gradient(self) -> float:
        """Extra road-wheel angle per lateral acceleration at the start of the range [rad*s**2/m].

        The pneumatic trails move the points where the axles' forces act.
        """
        return single_track.understeer_gradient(
            self.mass,
            self.front_distance - self._trail(self.front, self.front_load),
            self.rear_distance + self._trail(self.rear, self.rear_load),
            self.front.stiffness(self.front_load),
            self.rear.stiffness(self.rear_load),
        )

    def on_tyres(self, front: Tyre, rear: Tyre | None = None) -> Self:
        """The same car on other tyres; the same ones in front and behind where one is given."""
        rear = front if rear is None else rear
        return replace(self, front=replace(self.front, tyre=front), rear=replace(self.rear, tyre=rear))

    def with_axle_stiffness(self, front: float, rear: float) -> Self:
        """The same car with compliances that give the whole axles these cornering stiffnesses at rest [N/rad]."""
        axles = []
        for axle, load, wanted in ((self.front, self.front_load, front), (self.rear, self.rear_load, rear)):
            axles.append(replace(axle, compliance=1.0 / wanted - 0.5 / axle.tyre.stiffness(0.5 * load)))
        return replace(self, front=axles[0], rear=axles[1])

    @staticmethod
    def _trail(axle: Axle, load: float) -> float:
        return axle.tyre.trail * 0.5 * load / axle.tyre.nominal_load
