"""Two-track chassis: four wheels with Magic Formula tyres, axles, kingpins, roll, and load transfer."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple, Self

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import cos, limit, maximum, sin, where
from tierod.physics import motion as single_track
from tierod.physics.motion import GRAVITY, front_axle_load, longitudinal_load_transfer, yaw_moment
from tierod.physics.steering import weight_lever, weight_torque
from tierod.physics.tyre import twist_rate
from tierod_lab.ground.chassis.laws import parking_torque
from tierod_lab.ground.chassis.tyres import (
    AirForces,
    Contact,
    Hub,
    Tyre,
    air_forces,
    contact,
    holding_friction,
    hub,
    rolling_resistance,
)
from tierod_lab.ground.parts import Reaction, Road, Steer, Wheels, Wind


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

    def air(self, motion: Any, road: Road, wind: Wind) -> AirForces:
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
        """Torques about the left and the right kingpin due to weight and to longitudinal tyre forces [N*m]."""
        lever = weight_lever(self.scrub_radius, self.inclination, wheel_radius)
        # Brakes and motors are inside the wheels, so that their torque acts on the knuckle.
        left = self.scrub_radius * contacts.front_left.longitudinal_force
        right = -self.scrub_radius * contacts.front_right.longitudinal_force
        left = left + weight_torque(loads.front_left, lever, hubs.front_left.sine)
        return left, right + weight_torque(loads.front_right, lever, hubs.front_right.sine)


STOPPING_TIME = 0.004
"""Time constant with which a braked wheel comes to rest [s]: shorter than all others, stable at steps of 1 ms."""


class TwoTrackMotion(NamedTuple):
    """State of motion of the two-track chassis."""

    speed: Scalar
    lateral_speed: Scalar
    yaw_rate: Scalar
    roll_angle: Scalar  # roll_angle, roll_rate: positive when the right side goes down [rad], [rad/s]
    roll_rate: Scalar
    spins: Wheels  # angular speed of every wheel [rad/s]
    # longitudinal, lateral: deflection of every tyre, forward and to the left under a positive force [m]
    longitudinal: Wheels
    lateral: Wheels
    left_twist: Scalar  # left_twist, right_twist: twist of the front contact patches [rad]
    right_twist: Scalar
    # tyre_force, front_force, rear_force: force along the body and forces of the axles across it behind the lag of the
    # suspension, which determine load transfer and compliance steer [N]
    tyre_force: Scalar
    front_force: Scalar
    rear_force: Scalar


class Sums(NamedTuple):
    """Forces of all tyres in the axes of the body [N], and their yaw moment [N*m]."""

    along: Scalar
    front: Scalar
    rear: Scalar
    yaw_moment: Scalar


class Scrub(NamedTuple):
    """Scrub torques of the contact patches [N*m] and the rates of their twists [rad/s]."""

    left: Scalar
    right: Scalar
    left_rate: Scalar
    right_rate: Scalar


class Balance(NamedTuple):
    """Parts of a reaction for the derivative: rates, and the longitudinal forces on the wheels."""

    rates: TwoTrackMotion
    wheel_forces: Wheels


@dataclass(frozen=True)
class TwoTrack(OnTwoAxles):
    """Planar motion and roll of a body on four wheels.

    Loads and compliance follow the forces with a first-order lag, which replaces the vertical motion of the wheels.
    Speeds are those of the centre of gravity, about which the body rolls with the arm above its roll axis.

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
        axles = ((self.front, self.front_load), (self.rear, self.rear_load))
        front, rear = (axle.tyre.trail * 0.5 * load / axle.tyre.nominal_load for axle, load in axles)
        distances = (self.front_distance - front, self.rear_distance + rear)
        return single_track.understeer_gradient(self.mass, *distances, *(axle.stiffness(load) for axle, load in axles))

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

    def init(self, speed: float) -> TwoTrackMotion:
        front, rear = speed / self.front.tyre.radius, speed / self.rear.tyre.radius
        still = Wheels(0.0, 0.0, 0.0, 0.0)
        spins = Wheels(front, front, rear, rear)
        return TwoTrackMotion(speed, 0.0, 0.0, 0.0, 0.0, spins, still, still, 0.0, 0.0, 0.0, 0.0, 0.0)

    def reaction(self, motion: TwoTrackMotion, steer: Steer, road: Road, wind: Wind) -> Reaction:
        """Forces, accelerations and kingpin torques in a state of motion."""
        loads, hubs = self.loads(motion, road), self.hubs(motion, steer)
        contacts = self.contacts(motion, loads, hubs, road)
        scrub = self.scrub(motion, steer, loads, hubs, contacts)
        sums = self.sums(hubs, contacts, scrub)
        air = self.air(motion, road, wind)
        rates = self._rates(motion, sums, air, road)._replace(
            longitudinal=Wheels(*(each.longitudinal_rate for each in contacts)),
            lateral=Wheels(*(each.lateral_rate for each in contacts)),
            left_twist=scrub.left_rate,
            right_twist=scrub.right_rate,
        )
        left, right = contacts.front_left, contacts.front_right
        aligning_left, aligning_right = self.kingpins.aligning(left), self.kingpins.aligning(right)
        geometry_left, geometry_right = self.kingpins.geometry(loads, hubs, contacts, self.front.tyre.radius)
        return Reaction(
            speed=motion.speed,
            lateral_speed=motion.lateral_speed,
            yaw_rate=motion.yaw_rate,
            yaw_acceleration=rates.yaw_rate,
            longitudinal_acceleration=(sums.along + air.longitudinal) / self.mass,
            lateral_acceleration=(sums.front + sums.rear + air.lateral) / self.mass,
            roll_angle=motion.roll_angle,
            roll_rate=motion.roll_rate,
            roll_acceleration=rates.roll_rate,
            kingpin_left=aligning_left + scrub.left + geometry_left,
            kingpin_right=aligning_right + scrub.right + geometry_right,
            front_lateral_force=sums.front,
            rear_lateral_force=sums.rear,
            front_slip_angle=0.5 * (left.slip + right.slip),
            loads=loads,
            wheel_speeds=self._wheel_speeds(motion),
            self_aligning_torque=aligning_left + aligning_right,
            scrub_torque=scrub.left + scrub.right,
            private=Balance(rates, Wheels(*(each.longitudinal_force for each in contacts))),
        )

    def derivative(self, motion: TwoTrackMotion, reaction: Reaction, torques: Wheels, brakes: Wheels) -> TwoTrackMotion:
        balance: Balance = reaction.private
        spins = []
        for axle, spin, force, load, torque, brake in zip(
            self.axles, motion.spins, balance.wheel_forces, reaction.loads, torques, brakes, strict=True
        ):
            driving = torque - axle.tyre.radius * force
            greatest = brake + axle.tyre.radius * rolling_resistance(load, axle.tyre.rolling_coefficient)
            held = holding_friction(spin, driving, greatest, axle.wheel_inertia, STOPPING_TIME)
            spins.append((driving - held) / axle.wheel_inertia)
        return balance.rates._replace(spins=Wheels(*spins))

    @property
    def axles(self) -> Wheels[Axle]:
        return Wheels(self.front, self.front, self.rear, self.rear)

    def loads(self, motion: TwoTrackMotion, road: Road) -> Wheels:
        """Vertical load of every wheel [N]; when a wheel lifts off, the other carries the whole axle load."""
        upright = 0.5 * road.support * cos(road.bank_angle) * cos(road.grade_angle)
        shift = 0.5 * longitudinal_load_transfer(motion.tyre_force, self.centre_height, self.wheelbase)
        loads = []
        for axle, static, force in (
            (self.front, upright * self.front_load - shift, motion.front_force),
            (self.rear, upright * self.rear_load + shift, motion.rear_force),
        ):
            mean = maximum(static, 0.0)
            roll_torque = axle.roll_stiffness * motion.roll_angle + axle.roll_damping * motion.roll_rate
            # Mitschke and Wallentowitz, section 23.1: one part through the links, the other through the springs.
            transfer = limit((force * axle.roll_centre_height + roll_torque) / axle.track, -mean, mean)
            loads += [mean - transfer, mean + transfer]
        return Wheels(*loads)

    def hubs(self, motion: TwoTrackMotion, steer: Steer) -> Wheels[Hub]:
        """Steering angle of every wheel, with compliance, and motion of its contact point."""
        across = motion.lateral_speed + self.roll_arm * motion.roll_rate
        front_across = across + self.front_distance * motion.yaw_rate
        rear_across = across - self.rear_distance * motion.yaw_rate
        front, rear = (0.5 * axle.track * motion.yaw_rate for axle in (self.front, self.rear))
        yielded = self.front.compliance * motion.front_force
        rear_steer = -self.rear.compliance * motion.rear_force
        return Wheels(
            hub(steer.left - yielded, motion.speed - front, front_across),
            hub(steer.right - yielded, motion.speed + front, front_across),
            hub(rear_steer, motion.speed - rear, rear_across),
            hub(rear_steer, motion.speed + rear, rear_across),
        )

    def contacts(self, motion: TwoTrackMotion, loads: Wheels, hubs: Wheels[Hub], road: Road) -> Wheels[Contact]:
        """Forces and rates of every contact patch."""
        sides = Wheels(road.adhesion_left, road.adhesion_right, road.adhesion_left, road.adhesion_right)
        wheels = zip(
            self.axles, loads, sides, hubs, self._wheel_speeds(motion), motion.longitudinal, motion.lateral, strict=True
        )
        return Wheels(*(contact(axle.tyre, *rest) for axle, *rest in wheels))

    def scrub(
        self, motion: TwoTrackMotion, steer: Steer, loads: Wheels, hubs: Wheels[Hub], contacts: Wheels[Contact]
    ) -> Scrub:
        """Scrub torques of the front contact patches, and rates of their twists."""
        tyre, torques, rates = self.front.tyre, [], []
        for twist, steer_rate, load, side, patch in (
            (motion.left_twist, steer.left_rate, loads.front_left, hubs.front_left, contacts.front_left),
            (motion.right_twist, steer.right_rate, loads.front_right, hubs.front_right, contacts.front_right),
        ):
            torques.append(parking_torque(load, patch.friction, tyre.pressure) * twist / tyre.twist_angle)
            turning = steer_rate + motion.yaw_rate
            loaded = twist_rate(twist, turning, side.along, tyre.twist_angle, tyre.twist_length)
            # The twist of a lifted wheel fades, since nothing holds it.
            rates.append(where(load > 0.0, loaded, -twist / self.suspension_lag))
        return Scrub(*torques, *rates)

    def sums(self, hubs: Wheels[Hub], contacts: Wheels[Contact], scrub: Scrub) -> Sums:
        """Forces of all tyres on the body."""
        forces = []
        for side, patch in zip(hubs, contacts, strict=True):
            forces.append(side.to_body(patch.longitudinal_force, patch.lateral_force))
        (x1, y1), (x2, y2), (x3, y3), (x4, y4) = forces
        aligning = sum(patch.trail * patch.lateral_force for patch in contacts)
        turning = 0.5 * (self.front.track * (x2 - x1) + self.rear.track * (x4 - x3))
        front, rear = y1 + y2, y3 + y4
        moment = yaw_moment(front, rear, self.front_distance, self.rear_distance) + turning - aligning
        return Sums(x1 + x2 + x3 + x4, front, rear, moment - scrub.left - scrub.right)

    def _rates(self, motion: TwoTrackMotion, sums: Sums, air: AirForces, road: Road) -> TwoTrackMotion:
        gravity = road.support * GRAVITY
        along, across = sums.along + air.longitudinal, sums.front + sums.rear + air.lateral
        stiffness = self.front.roll_stiffness + self.rear.roll_stiffness - self.mass * gravity * self.roll_arm
        damping = self.front.roll_damping + self.rear.roll_damping
        roll_torque = self.roll_arm * (sums.front + sums.rear)
        roll_torque = roll_torque - stiffness * motion.roll_angle - damping * motion.roll_rate
        lag = self.suspension_lag
        return TwoTrackMotion(
            speed=along / self.mass + motion.lateral_speed * motion.yaw_rate - gravity * sin(road.grade_angle),
            lateral_speed=across / self.mass - motion.speed * motion.yaw_rate - gravity * sin(road.bank_angle),
            yaw_rate=(sums.yaw_moment + air.yaw_moment) / self.yaw_inertia,
            roll_angle=motion.roll_rate,
            roll_rate=roll_torque / self.roll_inertia,
            spins=motion.spins,
            longitudinal=motion.longitudinal,
            lateral=motion.lateral,
            left_twist=0.0,
            right_twist=0.0,
            tyre_force=(sums.along - motion.tyre_force) / lag,
            front_force=(sums.front - motion.front_force) / lag,
            rear_force=(sums.rear - motion.rear_force) / lag,
        )

    def _wheel_speeds(self, motion: TwoTrackMotion) -> Wheels:
        return Wheels(*(spin * axle.tyre.radius for axle, spin in zip(self.axles, motion.spins, strict=True)))


def demonstrator() -> TwoTrack:
    """Chassis of the light electric demonstrator of Li, Frey and Gauterin, a car at a scale of 1 to 1.5.

    Source: Table A1 of the paper for mass, yaw inertia, distances, track and wheel radius. The cornering stiffness is
    35 kN/rad per axle, as usual for these loads; the printed 322 kN/rad would be almost ten times as high. All roll
    parameters and the scrub radius are assumed.
    """
    tyre = Tyre(
        radius=0.243, nominal_load=1000.0, cornering_stiffness=26.0, lateral_relaxation=0.3, trail=0.018, pressure=2.0e5
    )
    return TwoTrack(
        mass=403.2,
        yaw_inertia=548.3,
        front_distance=0.904,
        rear_distance=1.166,
        centre_height=0.35,
        roll_inertia=70.0,
        drag_area=0.5,
        side_area=2.5,
        side_force_lead=0.3,
        front=Axle(1.084, 0.03, 14e3, 700.0, 0.0, 0.45, tyre),
        rear=Axle(1.084, 0.05, 11e3, 600.0, 0.0, 0.40, tyre),
        kingpins=Kingpins(mechanical_trail=0.02, scrub_radius=0.05, inclination=0.1),
    ).with_axle_stiffness(35e3, 35e3)
