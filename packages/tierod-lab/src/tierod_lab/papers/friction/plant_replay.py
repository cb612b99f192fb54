"""Simulation of a chassis alone, with recorded or prescribed steering angle and speed as inputs.

Used to compare the chassis with recordings and with other simulators.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod_lab.ground.chassis import TwoTrack
from tierod_lab.ground.integration import rosenbrock
from tierod_lab.ground.parts import Chassis, Motion, Reaction, Road, Steer, Wheels, Wind
from tierod_lab.ground.powertrain import Powertrain


class ChassisInput(NamedTuple):
    """Inputs of a chassis at one instant."""

    road_wheel_angle: Annotated[float, "rad"]
    road_wheel_rate: Annotated[float, "rad/s"]
    speed: Annotated[float, "m/s"]
    bank_angle: Annotated[float, "rad"] = 0.0
    grade_angle: Annotated[float, "rad"] = 0.0


class ChassisResponse(NamedTuple):
    """Response of the chassis, at the instant of its sample."""

    speed: Annotated[Scalar, "m/s"]
    lateral_speed: Annotated[Scalar, "m/s"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    yaw_acceleration: Annotated[Scalar, "rad/s**2"]
    longitudinal_acceleration: Annotated[Scalar, "m/s**2"]
    lateral_acceleration: Annotated[Scalar, "m/s**2"]
    roll_angle: Annotated[Scalar, "rad"]
    front_lateral_force: Annotated[Scalar, "N"]
    rear_lateral_force: Annotated[Scalar, "N"]
    self_aligning_torque: Annotated[Scalar, "N*m"]
    kingpin_torque: Annotated[Scalar, "N*m"]
    loads: Wheels
    wheel_speeds: Wheels


class _Motion(NamedTuple):
    chassis: Motion


@dataclass(frozen=True)
class Replay:
    """Drives a chassis by its front road wheels, both at one angle; a stiff speed controller drives and brakes."""

    chassis: Chassis = field(default_factory=TwoTrack)  # chassis under test
    powertrain: Powertrain = field(default_factory=Powertrain)  # distribution of the controller's force over the wheels
    start_speed: Annotated[float, "m/s", NOT_NEGATIVE] = 20.0  # initial speed, rolling straight ahead
    # force per speed error; at 1 m/s**2 a car of 1600 kg lags by 0.05 m/s
    speed_gain: Annotated[float, "N*s/m", NOT_NEGATIVE] = 32e3
    # step of the integration, which uses Heun's method as in the cars
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    Sample = ChassisInput

    def init(self) -> Motion:
        return self.chassis.init(self.start_speed)

    def step(self, state: Motion, sample: ChassisInput) -> tuple[Motion, ChassisResponse]:
        first = self._reaction(state, sample)
        force = self.speed_gain * (sample.speed - first.speed)
        torques, brakes = self.powertrain.torques(force, first)

        def slope(motion: _Motion) -> _Motion:
            now = motion.chassis
            return _Motion(self.chassis.derivative(now, self._reaction(now, sample), torques, brakes))

        # With no stiff field and an empty inverse, the Rosenbrock step reduces to Heun's method.
        after = rosenbrock(slope, _Motion(state), self.step_time, "", [])
        return after.chassis, _driven(first)

    def _reaction(self, motion: Motion, sample: ChassisInput) -> Reaction:
        angle, rate = sample.road_wheel_angle, sample.road_wheel_rate
        road = Road(0.0, sample.bank_angle, sample.grade_angle, 1.0, 1.0, 1.0)
        return self.chassis.reaction(motion, Steer(angle, angle, rate, rate), road, Wind(0.0, 0.0))


def _driven(reaction: Reaction) -> ChassisResponse:
    return ChassisResponse(
        kingpin_torque=reaction.kingpin_left + reaction.kingpin_right,
        **{name: getattr(reaction, name) for name in ChassisResponse._fields if name != "kingpin_torque"},
    )
