"""Steering of a demonstrator without steering wheel: two motors on the column, and a stiff rack and pinion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.physics.steering_ratio import column_torque_of_motor
from tierod_lab.ground.parts import Hand, Loads, Steer
from tierod_lab.ground.steering.friction import Dahl, DryFriction
from tierod_lab.ground.steering.linkage import Linkage
from tierod_lab.ground.steering.rack_eps import Mesh, RackEps, RackMemory, RackMotion
from tierod_lab.ground.steering.shaft import Motor


def demonstrator_rack() -> RackEps:
    """Rack and pinion of the demonstrator of Li, Frey and Gauterin, without the motors on its column.

    Source: Table A1 of the paper, without steering wheel and torsion bar. The inertia is printed as 45 kg*m**2 and
    taken as 0.045, divided between `wheel_inertia` and `pinion_inertia`, of which only the sum matters. The ratio is
    printed as the reciprocal of that which eqs (1) to (5) require. The build-up angle of friction is assumed.
    """
    return RackEps(
        wheel_inertia=0.040,
        wheel_damping=0.0,
        pinion_inertia=0.005,
        pinion_damping=0.0,
        rack_mass=3.0,
        rack_damping=22867.0,
        centring=31227.0,
        mesh=Mesh(1e8, 1e3),
        friction=DryFriction(level=1.11, law=Dahl(math.radians(1.0))),
        friction_on_rack=False,
        motor=None,
        linkage=Linkage(
            ratio=1.0 / 19.7,
            ackermann_gain=0.0,
            rack_ratio=1.0 / 146.12,
            road_wheel_inertia=0.0,
            friction=DryFriction(level=0.0),
        ),
        torsion_bar=None,
    )


class DemonstratorMotion(NamedTuple):
    """Motion of column and rack, and the torques of both motors at their shafts [N*m]."""

    rack: RackMotion
    torque_1: Scalar
    torque_2: Scalar


class DemonstratorSignals(NamedTuple):
    """Signals before sensors, and quantities without a sensor; the steering-wheel angle is that of the column.

    The drive torques are those of the previous step. Friction is defined as in `SteeringSignals`.
    """

    steering_wheel_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]
    steering_shaft_torque: Annotated[Scalar, "N*m"]
    tie_rod_force: Annotated[Scalar, "N"]
    tie_rod_force_left: Annotated[Scalar, "N"]
    tie_rod_force_right: Annotated[Scalar, "N"]
    steering_motor_1_torque: Annotated[Scalar, "N*m"]
    steering_motor_2_torque: Annotated[Scalar, "N*m"]
    drive_torque_left: Annotated[Scalar, "N*m"]
    drive_torque_right: Annotated[Scalar, "N*m"]
    rack_position: Annotated[Scalar, "m"]
    rack_speed: Annotated[Scalar, "m/s"]
    road_wheel_angle_left: Annotated[Scalar, "rad"]
    road_wheel_angle_right: Annotated[Scalar, "rad"]
    truth_steering_wheel_acceleration: Annotated[Scalar, "rad/s**2"]
    truth_friction_torque: Annotated[Scalar, "N*m"]
    truth_friction_resistance: Annotated[Scalar, "N*m"]


def steering_motor() -> Motor:
    """One motor of the demonstrator, directly on the column; assumed values."""
    return Motor(ratio=1.0, inertia=2.5e-3, damping=0.0, lag=3e-3, maximum_torque=15.0)


@dataclass(frozen=True)
class Demonstrator:
    """Column with two redundant motors, rack and pinion.

    The inertia of the motors is part of the rack's `wheel_inertia`; the shaft torque sensor is below the motors.
    Source: Li, Frey, Gauterin, eq (2); the connection force is multiplied by the rack ratio in the first row (printed
    without).
    """

    rack: RackEps = field(default_factory=demonstrator_rack)
    steering_motor_1: Motor = field(default_factory=steering_motor)
    steering_motor_2: Motor = field(default_factory=steering_motor)

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("steering_motor_1_torque", "steering_motor_2_torque", "drive_torque_left", "drive_torque_right")

    def init(self) -> DemonstratorMotion:
        return DemonstratorMotion(self.rack.init(), 0.0, 0.0)

    def remembered(self) -> RackMemory:
        return self.rack.remembered()

    def stiff(self) -> DemonstratorMotion:
        return DemonstratorMotion(self.rack.stiff(), 0.0, 0.0)

    def sticking(self, motion: DemonstratorMotion, memory: RackMemory) -> dict[tuple[str, str], Scalar]:
        entries = self.rack.sticking(motion.rack, memory)
        return {(f"rack.{rate}", f"rack.{angle}"): entry for (rate, angle), entry in entries.items()}

    def steer(self, motion: DemonstratorMotion) -> Steer:
        return self.rack.steer(motion.rack)

    def hand(self, motion: DemonstratorMotion) -> Hand:
        return self.rack.hand(motion.rack)

    def derivative(
        self, motion: DemonstratorMotion, start: DemonstratorMotion, memory: RackMemory, loads: Loads
    ) -> DemonstratorMotion:
        return DemonstratorMotion(
            self.rack.derivative(motion.rack, start.rack, memory, self._on_rack(motion, loads)),
            self.steering_motor_1.torque_rate(motion.torque_1, loads.actuator_torques[0]),
            self.steering_motor_2.torque_rate(motion.torque_2, loads.actuator_torques[1]),
        )

    def advance(
        self, motion: DemonstratorMotion, start: DemonstratorMotion, memory: RackMemory, loads: Loads
    ) -> RackMemory:
        return self.rack.advance(motion.rack, start.rack, memory, self._on_rack(motion, loads))

    def signals(self, motion: DemonstratorMotion, memory: RackMemory, loads: Loads) -> DemonstratorSignals:
        seen = self.rack.signals(motion.rack, memory, self._on_rack(motion, loads))
        acceleration = seen.truth_steering_wheel_acceleration
        motors = (self.steering_motor_1, self.steering_motor_2)
        # The rack computes the torque above the motors, the sensor is below them: their rotors' inertia is subtracted.
        above = sum(motor.ratio * motor.ratio * motor.inertia for motor in motors)
        return DemonstratorSignals(
            seen.steering_wheel_angle,
            seen.steering_wheel_rate,
            seen.driver_torque - above * acceleration,
            seen.tie_rod_force_left + seen.tie_rod_force_right,
            seen.tie_rod_force_left,
            seen.tie_rod_force_right,
            motion.torque_1,
            motion.torque_2,
            loads.actuator_torques[2],
            loads.actuator_torques[3],
            seen.rack_position,
            seen.rack_speed,
            seen.road_wheel_angle_left,
            seen.road_wheel_angle_right,
            acceleration,
            seen.truth_friction_torque,
            seen.truth_friction_resistance,
        )

    def _on_rack(self, motion: DemonstratorMotion, loads: Loads) -> Loads:
        first = column_torque_of_motor(motion.torque_1, self.steering_motor_1.ratio)
        second = column_torque_of_motor(motion.torque_2, self.steering_motor_2.ratio)
        return loads._replace(hand_torque=loads.hand_torque + first + second, actuator_torques=())
