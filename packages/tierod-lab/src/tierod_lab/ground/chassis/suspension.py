"""Axles, kingpins, and the parameters of the two-track chassis."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, Protocol, Self

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics import single_track
from tierod.physics.aligning import scrub_radius_torque, weight_lever, weight_torque
from tierod.physics.single_track import front_axle_load
from tierod_lab.ground.chassis.resistances import AirForces, air_forces
from tierod_lab.ground.chassis.tyres import Contact, Hub, Tyre
from tierod_lab.ground.parts import Road, Wheels, Wind


class Planar(Protocol):
    """Velocity of a chassis, from which the aerodynamic forces follow."""

    @property
    def speed(self) -> Scalar:
        """Speed along the body [m/s]."""

    @property
    def lateral_speed(self) -> Scalar:
        """Speed across the body [m/s]."""


class OnTwoAxles:
    """Base class of the chassis: axle loads from mass [kg] and distances [m], and air forces from areas [m**2]."""

    mass: float
    front_distance: float
    rear_distance: float
    drag_area: float
    side_area: float
    side_force_lead: float

    @property
    def wheelbase(self) -> float:
        """Distance between the axles [m]."""
        return self.front_distance + self.rear_distance

    @property
    def front_load(self) -> float:
        """Static load of the front axle [N]."""
        return front_axle_load(self.mass, self.front_distance, self.rear_distance)

    @property
    def rear_load(self) -> float:
        """Static load of the rear axle [N]."""
        return front_axle_load(self.mass, self.rear_distance, self.front_distance)

    def air(self, motion: Planar, road: Road, wind: Wind) -> AirForces:
        """Aerodynamic forces on a car; none on a hoist, which stands in a hall."""
        return air_forces(
            motion.speed + wind.headwind_speed,
            motion.lateral_speed - wind.crosswind_speed,
            road.support * self.drag_area,
            road.support * self.side_area,
            self.side_force_lead,
        )


@dataclass(frozen=True)
class Axle:
    """One axle with two equal wheels."""

    track: Annotated[float, "m", POSITIVE]
    roll_centre_height: Annotated[float, "m"]
    roll_stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE]
    roll_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE]
    compliance: Annotated[float, "rad/N"]
    wheel_inertia: Annotated[float, "kg*m**2", POSITIVE]
    tyre: Tyre = field(default_factory=Tyre)

    def stiffness(self, load: float) -> float:
        """Cornering stiffness of the whole axle at its static load, including its compliance [N/rad]."""
        return 1.0 / (0.5 / self.tyre.stiffness(0.5 * load) + self.compliance)


@dataclass(frozen=True)
class Kingpins:
    """Steering axes of the front wheels; typical of a front-wheel-drive car."""

    mechanical_trail: Annotated[float, "m"] = 0.025
    scrub_radius: Annotated[float, "m"] = 0.008
    inclination: Annotated[float, "rad"] = 0.20

    def aligning(self, patch: Contact) -> Scalar:
        """Torque of the lateral force about a kingpin [N*m]."""
        return (self.mechanical_trail + patch.trail) * patch.lateral_force

    def geometry(
        self, loads: Wheels, hubs: Wheels[Hub], contacts: Wheels[Contact], wheel_radius: Scalar
    ) -> tuple[Scalar, Scalar]:
        """Torques about the left and the right kingpin due to weight and to longitudinal tyre forces [N*m].

        Args:
            loads: vertical load of every wheel [N]
            wheel_radius: radius of the wheels [m]
        """
        lever = weight_lever(self.scrub_radius, self.inclination, wheel_radius)
        left, right = scrub_radius_torque(
            contacts.front_left.longitudinal_force, contacts.front_right.longitudinal_force, self.scrub_radius
        )
        left = left + weight_torque(loads.front_left, lever, hubs.front_left.sine)
        return left, right + weight_torque(loads.front_right, lever, hubs.front_right.sine)


@dataclass(frozen=True)
class TwoTrackParameters(OnTwoAxles):
    """Parameters of body, axles and air of a chassis with four wheels.

    The defaults are those of a mid-size car, typical unless stated otherwise; its axles have cornering stiffnesses of
    110 and 130 kN/rad, including compliance.
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
        """Understeer gradient in the linear range: additional road-wheel angle per lateral acceleration [rad*s**2/m].

        The pneumatic trails shift the points at which the axles' forces act.
        """
        return single_track.understeer_gradient(
            self.mass,
            self.front_distance - self._trail(self.front, self.front_load),
            self.rear_distance + self._trail(self.rear, self.rear_load),
            self.front.stiffness(self.front_load),
            self.rear.stiffness(self.rear_load),
        )

    def on_tyres(self, front: Tyre, rear: Tyre | None = None) -> Self:
        """The same chassis on other tyres; with one argument, the same tyres front and rear."""
        rear = front if rear is None else rear
        return replace(self, front=replace(self.front, tyre=front), rear=replace(self.rear, tyre=rear))

    def with_axle_stiffness(self, front: float, rear: float) -> Self:
        """The same chassis with compliances that give the axles these cornering stiffnesses at static load [N/rad]."""
        axles = []
        for axle, load, wanted in ((self.front, self.front_load, front), (self.rear, self.rear_load, rear)):
            axles.append(replace(axle, compliance=1.0 / wanted - 0.5 / axle.tyre.stiffness(0.5 * load)))
        return replace(self, front=axles[0], rear=axles[1])

    @staticmethod
    def _trail(axle: Axle, load: float) -> float:
        return axle.tyre.trail * 0.5 * load / axle.tyre.nominal_load
