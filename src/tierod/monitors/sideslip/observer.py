"""What the observers of the paper have in common: their sample, when they run, and what they give at low speed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import all_of, limit, maximum, present, sqrt, where
from tierod.monitors.sideslip.axles import Axles, Slips


class ObserverSample(NamedTuple):
    """What an observer of the paper reads, NaN where missing.

    Args:
        vehicle_speed: forward; with it the observer changes
        yaw_rate: measured
        road_wheel_angle: mean of both front wheels
        road_wheel_torque: of the actuator at the road wheels
    """

    vehicle_speed: Annotated[float, "m/s"]
    yaw_rate: Annotated[float, "rad/s"]
    road_wheel_angle: Annotated[float, "rad"]
    road_wheel_torque: Annotated[float, "N*m"]


class Seen(NamedTuple):
    """A sample made safe.

    Args:
        running: whether the observer runs
        vehicle_speed: finite and not below the slowest
        yaw_rate, road_wheel_angle: as measured
        road_wheel_torque: finite
    """

    running: Any
    vehicle_speed: Any
    yaw_rate: Any
    road_wheel_angle: Any
    road_wheel_torque: Any


class Found(NamedTuple):
    """What an observer tells of a sample: values, their variances, and the innovations."""

    sideslip_angle: Any
    sideslip_variance: Any
    yaw_rate: Any
    road_wheel_angle: Any
    road_wheel_rate: Any
    self_aligning_torque: Any
    torque_variance: Any
    nis: Any
    readings: Any


class ObserverEstimate(NamedTuple):
    """What an observer of the paper gives out: a `SideslipEstimate`, and its other states.

    Args:
        sideslip_angle, sideslip_angle_deviation: at the centre of gravity, and one standard deviation of it
        self_aligning_torque, self_aligning_torque_deviation: of the front tyres, opposing positive steer
        nis, readings: normalised innovation squared of the sample, and over how many readings
        held: 1 where nothing could be estimated and the last estimate stands
        estimated_yaw_rate, estimated_road_wheel_angle, estimated_road_wheel_rate: the other states
    """

    sideslip_angle: Annotated[float, "rad"]
    sideslip_angle_deviation: Annotated[float, "rad"]
    self_aligning_torque: Annotated[float, "N*m"]
    self_aligning_torque_deviation: Annotated[float, "N*m"]
    nis: Annotated[float, ""]
    readings: Annotated[float, ""]
    held: Annotated[float, ""]
    estimated_yaw_rate: Annotated[float, "rad/s"]
    estimated_road_wheel_angle: Annotated[float, "rad"]
    estimated_road_wheel_rate: Annotated[float, "rad/s"]


class ObserverState(NamedTuple):
    """Of the observer itself, the sideslip angle it said last, and the slip angles of the axles then."""

    own: Any
    sideslip_angle: Any
    slips: Slips


@dataclass(frozen=True)
class LowSpeed:
    """When the observer runs, and what it gives where the car crawls.

    Args:
        slowest: below it nothing is estimated: wheel speed sensors see nothing slower
        settled: above it the observer alone is believed. Between the two the sideslip of a car without slip at its
            tyres takes over, rear_share times the steer, to which the model tends as the speed falls
        rear_share: distance of the rear axle from the centre of gravity over the wheelbase
    """

    rear_share: Annotated[float, "", POSITIVE]
    slowest: Annotated[float, "m/s", POSITIVE] = 0.5
    settled: Annotated[float, "m/s", POSITIVE] = 1.0

    def seen(self, sample: ObserverSample) -> Seen:
        """A sample made safe."""
        torque, speed = sample.road_wheel_torque, sample.vehicle_speed
        running = all_of(present(speed), speed > self.slowest, present(torque))
        return Seen(
            running,
            where(running, maximum(speed, self.slowest), self.slowest),
            sample.yaw_rate,
            sample.road_wheel_angle,
            where(present(torque), torque, 0.0),
        )

    def blended(self, sideslip_angle: Any, road_wheel_angle: Any, speed: Any) -> Any:
        """Sideslip angle [rad] of the observer, or of rolling without slip where the car crawls."""
        share = limit((speed - self.slowest) / (self.settled - self.slowest), 0.0, 1.0)
        rolling = self.rear_share * road_wheel_angle
        return rolling + share * (sideslip_angle - rolling)


@dataclass(frozen=True)
class ObserverNoise:
    """Noise of sensors (of one reading) and of what the model lacks (after one second).

    Chosen on drives of two virtual cars at 6.7 and 25 m/s: less noise of the yaw rate's model serves crosswind and bank
    better and curved tyres worse, more the other way round.

    Args:
        yaw_rate_reading, road_wheel_angle_reading: of the sensors, standard deviations
        sideslip_angle: of lateral forces that the model lacks, over mass and speed
        yaw_rate: of yaw moments that it lacks
        road_wheel_rate: of torques of the steering that it lacks: friction, power assist
        self_aligning_torque: by which the aligning torque moves, for the disturbance observer
        torque_reading: error of the aligning torque that the disturbance observer hands on
        torque_time: over which that error lasts
    """

    yaw_rate_reading: Annotated[float, "rad/s", POSITIVE] = 0.003
    road_wheel_angle_reading: Annotated[float, "rad", POSITIVE] = 2e-4
    sideslip_angle: Annotated[float, "rad/s**0.5", POSITIVE] = 0.003
    yaw_rate: Annotated[float, "rad/s**1.5", POSITIVE] = 0.04
    road_wheel_rate: Annotated[float, "rad/s**1.5", POSITIVE] = 0.6
    self_aligning_torque: Annotated[float, "N*m/s**0.5", POSITIVE] = 120.0
    torque_reading: Annotated[float, "N*m", POSITIVE] = 20.0
    torque_time: Annotated[float, "s", NOT_NEGATIVE] = 0.03

    def torque_variance(self, sample_time: float) -> float:
        """Variance [N2 m2] of a white reading that tells as much as one whose error lasts."""
        return self.torque_reading**2 * max(1.0, 2.0 * self.torque_time / sample_time)


@dataclass(frozen=True)
class SteeringTorqueObserver(ABC):
    """Base of the observers of the paper: one sample on, held where nothing can be estimated.

    The standard deviation of the sideslip angle holds what noise and forces that the model lacks make of it, and what
    stiffness, trail and late tyres may make wrong.

    Args:
        low_speed: when it runs
        axles: how well they are known
    """

    low_speed: LowSpeed
    axles: Axles

    Sample = ObserverSample

    def init(self) -> ObserverState:
        """Straight ahead."""
        return ObserverState(self._start(), 0.0, self.axles.start())

    def step(self, state: ObserverState, sample: ObserverSample) -> tuple[ObserverState, ObserverEstimate]:
        """One sample on."""
        seen = self.low_speed.seen(sample)
        own, found = self._observe(state.own, seen)
        blended = self.low_speed.blended(found.sideslip_angle, found.road_wheel_angle, seen.vehicle_speed)
        slips = self.axles.follow(
            state.slips, found.sideslip_angle, found.yaw_rate, found.road_wheel_angle, seen.vehicle_speed, seen.running
        )
        after = ObserverState(
            own,
            where(seen.running, blended, state.sideslip_angle),
            slips,
        )
        return after, ObserverEstimate(
            after.sideslip_angle,
            sqrt(found.sideslip_variance + self.axles.variance(slips)),
            found.self_aligning_torque,
            sqrt(found.torque_variance),
            where(seen.running, found.nis, 0.0),
            where(seen.running, found.readings, 0.0),
            where(seen.running, 0.0, 1.0),
            found.yaw_rate,
            found.road_wheel_angle,
            found.road_wheel_rate,
        )

    @abstractmethod
    def _start(self) -> Tree:
        """State of the observer itself."""

    @abstractmethod
    def _observe(self, own: Tree, seen: Seen) -> tuple[Tree, Found]:
        """One sample on: the own state is held where the observer does not run."""


def low_speed(p: Any) -> LowSpeed:
    """What is given where a car of these parameters crawls."""
    return LowSpeed(p.rear_distance / (p.front_distance + p.rear_distance))
