"""Assist, return and damping by the steering's control unit, as blocks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range
from tierod.core.graph.maths import limit
from tierod.physics.assist import active_return_share, active_return_torque, assist_speed_factor, assist_torque
from tierod_lab.ground.cars.body import START, Path, path_rate
from tierod_lab.ground.control.driver import HumanDriver
from tierod_lab.ground.integration import runge_kutta
from tierod_lab.ground.parts import Demand, Driver, Hand, Memory, Motion, Reaction, Road, Seen, Wheels


class AssistMemory(NamedTuple):
    """State of the unit between two steps."""

    driver_torque: Scalar  # torque of the previous step [N*m]
    filtered_torque: Scalar  # driver torque behind the lead filter [N*m]
    torque: Scalar  # requested torque at the column [N*m]


@dataclass(frozen=True)
class Characteristic:
    """The assist map, see `tierod.physics.assist.assist_torque`."""

    linear_gain: Annotated[float, "", NOT_NEGATIVE] = 2.0
    quadratic_gain: Annotated[float, "1/(N*m)", NOT_NEGATIVE] = 1.5
    dead_band: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    half_speed: Annotated[float, "m/s", POSITIVE] = 15.0

    def torque(self, driver_torque: Scalar, speed: Scalar, maximum: Scalar) -> Scalar:
        """Assist at the column [N*m] for a driver torque [N*m] and a speed [m/s], up to a maximum [N*m]."""
        return assist_torque(
            driver_torque, speed, self.linear_gain, self.quadratic_gain, self.dead_band, self.half_speed, maximum
        )


@dataclass(frozen=True)
class ActiveReturn:
    """Torque that returns a released wheel to the centre, see `tierod.physics.assist`; by default at most 3 N*m."""

    rate_gain: Annotated[float, "1/s", NOT_NEGATIVE] = 1.5
    maximum_rate: Annotated[float, "rad/s", POSITIVE] = 3.0
    gain: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 1.0
    best_speed: Annotated[float, "m/s", POSITIVE] = 6.0
    fade_torque: Annotated[float, "N*m", POSITIVE] = 1.0

    def torque(self, angle: Scalar, rate: Scalar, speed: Scalar, driver_torque: Scalar) -> Scalar:
        """Torque at the column [N*m]."""
        share = active_return_share(speed, driver_torque, self.best_speed, self.fade_torque)
        return share * active_return_torque(angle, rate, self.rate_gain, self.maximum_rate, self.gain)


@dataclass(frozen=True)
class AssistUnit:
    """Assist by characteristic and speed, active return and damping; a control unit sampled at the step of the car.

    The driver torque passes a lead filter, without which a high gain makes the loop of torsion bar and motor unstable.
    Return and damping act on the rate below the torsion bar, which the unit computes from steering wheel and twist:
    with the rate above the bar they would excite it.
    """

    characteristic: Characteristic = field(default_factory=Characteristic)
    active_return: ActiveReturn = field(default_factory=ActiveReturn)
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.2
    damping_speed: Annotated[float, "m/s", POSITIVE] = 15.0
    lead_time: Annotated[float, "s", NOT_NEGATIVE] = 0.008
    lag_time: Annotated[float, "s", NOT_NEGATIVE] = 0.0005
    maximum_torque: Annotated[float, "N*m", POSITIVE] = 60.0
    # limit of the request's rate of change, at the column; with a tenth of it, a wheel released under full assist would
    # keep oscillating
    torque_rate: Annotated[float, "N*m/s", POSITIVE] = 20e3
    bar_stiffness: Annotated[float, "N*m/rad", POSITIVE] = 140.0
    motor_ratio: Annotated[float, "", POSITIVE] = 20.0
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def remembered(self) -> AssistMemory:
        return AssistMemory(0.0, 0.0, 0.0)

    def decide(
        self, memory: AssistMemory, driver_torque: Scalar, speed: Scalar, angle: Scalar, rate: Scalar
    ) -> tuple[AssistMemory, Scalar]:
        filtered = self._lead(memory, driver_torque)
        rate = rate - (driver_torque - memory.driver_torque) / (self.step_time * self.bar_stiffness)
        wanted = self.characteristic.torque(filtered, speed, self.maximum_torque)
        wanted = wanted + self.active_return.torque(angle, rate, speed, driver_torque)
        wanted = wanted - self.damping * (1.0 - assist_speed_factor(speed, self.damping_speed)) * rate
        wanted = limit(wanted, -self.maximum_torque, self.maximum_torque)
        most = self.torque_rate * self.step_time
        torque = limit(wanted, memory.torque - most, memory.torque + most)
        return AssistMemory(driver_torque, filtered, torque), torque / self.motor_ratio

    def _lead(self, memory: AssistMemory, driver_torque: Scalar) -> Scalar:
        step, lead, lag = self.step_time, 2.0 * self.lead_time, 2.0 * self.lag_time
        torque = (step + lead) * driver_torque + (step - lead) * memory.driver_torque
        return (torque + (lag - step) * memory.filtered_torque) / (step + lag)


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
