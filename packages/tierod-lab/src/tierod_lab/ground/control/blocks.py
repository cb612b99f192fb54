"""Driver and assist unit as separate blocks, for vehicles that are computed elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import Range
from tierod_lab.ground.cars.body import START, Path, path_rate
from tierod_lab.ground.control.assist import AssistMemory, AssistUnit
from tierod_lab.ground.control.driver import HumanDriver
from tierod_lab.ground.integration import runge_kutta
from tierod_lab.ground.parts import Demand, Driver, Hand, Memory, Motion, Reaction, Road, Seen, Wheels


class AssistInputs(NamedTuple):
    """Inputs of an assist unit."""

    driver_torque: Annotated[Scalar, "N*m"]
    vehicle_speed: Annotated[Scalar, "m/s"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]


class AssistOutputs(NamedTuple):
    """Request of an assist unit, at the motor's shaft."""

    motor_target_torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class AssistController:
    """Assist unit of a car as a block."""

    unit: AssistUnit = field(default_factory=AssistUnit)

    Sample = AssistInputs

    def init(self) -> AssistMemory:
        return self.unit.remembered()

    def step(self, state: AssistMemory, sample: AssistInputs) -> tuple[AssistMemory, AssistOutputs]:
        memory, torque = self.unit.decide(state, *sample)
        return memory, AssistOutputs(torque)


class Sensed(NamedTuple):
    """Inputs of a driver: motion of the vehicle, the road, and motion of the steering wheel."""

    vehicle_speed: Annotated[Scalar, "m/s"]
    lateral_speed: Annotated[Scalar, "m/s"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]
    road: Road
    demand: Demand


class Driven(NamedTuple):
    """Outputs of a driver, and position of the vehicle relative to its path."""

    hand_torque: Annotated[Scalar, "N*m"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    drive_force: Annotated[Scalar, "N"]
    distance: Annotated[Scalar, "m"]
    lateral_offset: Annotated[Scalar, "m"]
    heading_error: Annotated[Scalar, "rad"]


class DrivingMotion(NamedTuple):
    """Continuous states of a driver: muscles, and the motion along the path."""

    driver: Motion
    path: Path


class DrivingState(NamedTuple):
    """State of a driver between two steps."""

    motion: DrivingMotion
    driver: Memory


@dataclass(frozen=True)
class Driving:
    """Driver on a path, for a vehicle whose motion is computed elsewhere; see `Car` for the same with a virtual car."""

    driver: Driver = field(default_factory=HumanDriver)
    step_time: Annotated[float, "s", Range(1e-5, 2e-2)] = 1e-3

    Sample = Sensed

    def init(self) -> DrivingState:
        return DrivingState(DrivingMotion(self.driver.init(), START), self.driver.remembered())

    def step(self, state: DrivingState, sample: Sensed) -> tuple[DrivingState, Driven]:
        motion, hand = state.motion, Hand(sample.steering_wheel_angle, sample.steering_wheel_rate)
        reaction = _reaction(sample.vehicle_speed, sample.lateral_speed, sample.yaw_rate)
        seen = Seen(
            sample.vehicle_speed, 0.0, sample.lateral_speed, sample.yaw_rate,
            motion.path.lateral_offset, motion.path.heading_error, sample.road.curvature, hand,
        )  # fmt: skip
        memory, intent = self.driver.decide(state.driver, seen, sample.demand)

        def slope(now: DrivingMotion) -> DrivingMotion:
            return DrivingMotion(
                self.driver.derivative(now.driver, intent, hand, sample.demand),
                path_rate(now.path, reaction, sample.road.curvature),
            )

        torque = self.driver.hand_torque(motion.driver, hand, sample.demand)
        reached = getattr(motion.driver, "angle", intent.steering_wheel_angle)
        path = motion.path
        done = Driven(torque, reached, intent.force, path.distance, path.lateral_offset, path.heading_error)
        return DrivingState(runge_kutta(slope, motion, self.step_time), memory), done


def _reaction(speed: Scalar, lateral_speed: Scalar, yaw_rate: Scalar) -> Reaction:
    nothing: dict[str, Any] = dict.fromkeys(Reaction._fields, 0.0)
    wheels = Wheels(0.0, 0.0, 0.0, 0.0)
    known = {"speed": speed, "lateral_speed": lateral_speed, "yaw_rate": yaw_rate}
    return Reaction(**{**nothing, "loads": wheels, "wheel_speeds": wheels, **known})
