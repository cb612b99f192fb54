"""Common base of the paper's observers: sample, operation at low speed, and the cars they can follow."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import all_of, limit, maximum, present, sqrt, where
from tierod.models.linear import linearise
from tierod_lab.papers.sideslip.axles import Axles, Slips
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle

MOST = 1.8  # Largest eigenvalue magnitude times step for which the integration method decays; it diverges from two on


class ObserverSample(NamedTuple):
    """Input of an observer of the paper, NaN where missing."""

    vehicle_speed: Annotated[Scalar, "m/s"]  # forward speed, which schedules the observer
    yaw_rate: Annotated[Scalar, "rad/s"]  # measured yaw rate
    road_wheel_angle: Annotated[Scalar, "rad"]  # mean of both front wheels
    road_wheel_torque: Annotated[Scalar, "N*m"]  # torque of the actuator at the road wheels


class Seen(NamedTuple):
    """A sample with finite inputs."""

    running: Annotated[Scalar, ""]  # whether the observer runs
    vehicle_speed: Annotated[Scalar, "m/s"]  # finite, and not below the slowest
    yaw_rate: Annotated[Scalar, "rad/s"]  # yaw_rate, road_wheel_angle: as measured
    road_wheel_angle: Annotated[Scalar, "rad"]
    road_wheel_torque: Annotated[Scalar, "N*m"]  # finite


class Found(NamedTuple):
    """Estimates of an observer from a sample: values, their variances, and the innovations."""

    sideslip_angle: Annotated[Scalar, "rad"]
    sideslip_variance: Annotated[Scalar, "rad**2"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    road_wheel_angle: Annotated[Scalar, "rad"]
    road_wheel_rate: Annotated[Scalar, "rad/s"]
    self_aligning_torque: Annotated[Scalar, "N*m"]
    torque_variance: Annotated[Scalar, "N**2*m**2"]
    nis: Annotated[Scalar, ""]
    readings: Annotated[Scalar, ""]


class ObserverEstimate(NamedTuple):
    """Output of an observer of the paper: a `SideslipEstimate`, and its other states."""

    # sideslip_angle, sideslip_angle_deviation: sideslip at the centre of gravity, and its standard deviation
    sideslip_angle: Annotated[Scalar, "rad"]
    sideslip_angle_deviation: Annotated[Scalar, "rad"]
    # self_aligning_torque, self_aligning_torque_deviation: torque of the front tyres, opposing positive steer
    self_aligning_torque: Annotated[Scalar, "N*m"]
    self_aligning_torque_deviation: Annotated[Scalar, "N*m"]
    nis: Annotated[Scalar, ""]  # nis, readings: normalised innovation squared of the sample, and its number of readings
    readings: Annotated[Scalar, ""]
    held: Annotated[Scalar, ""]  # 1 where nothing could be estimated and the last estimate is held
    # estimated_yaw_rate, estimated_road_wheel_angle, estimated_road_wheel_rate: the other states
    estimated_yaw_rate: Annotated[Scalar, "rad/s"]
    estimated_road_wheel_angle: Annotated[Scalar, "rad"]
    estimated_road_wheel_rate: Annotated[Scalar, "rad/s"]


class ObserverState(NamedTuple):
    """State of the observer, last sideslip angle, and slip angles of the axles."""

    own: Tree
    sideslip_angle: Annotated[Scalar, "rad"]
    slips: Slips


@dataclass(frozen=True)
class LowSpeed:
    """Speed range of the observer, and its output where the car crawls."""

    # distance of the rear axle from the centre of gravity over the wheelbase
    rear_share: Annotated[float, "", POSITIVE]
    # speed below which nothing is estimated; wheel speed sensors resolve nothing slower
    slowest: Annotated[float, "m/s", POSITIVE] = 0.5
    # speed above which the observer alone counts. Between the two the output blends into the sideslip of tyres without
    # slip, rear_share times the steer, to which the model tends at low speed
    settled: Annotated[float, "m/s", POSITIVE] = 1.0

    def seen(self, sample: ObserverSample) -> Seen:
        """The sample with finite inputs."""
        torque, speed = sample.road_wheel_torque, sample.vehicle_speed
        running = all_of(present(speed), speed > self.slowest, present(torque))
        return Seen(
            running,
            where(running, maximum(speed, self.slowest), self.slowest),
            sample.yaw_rate,
            sample.road_wheel_angle,
            where(present(torque), torque, 0.0),
        )

    def blended(self, sideslip_angle: Scalar, road_wheel_angle: Scalar, speed: Scalar) -> Scalar:
        """Sideslip angle [rad] of the observer, blended into that of rolling without slip where the car crawls."""
        share = limit((speed - self.slowest) / (self.settled - self.slowest), 0.0, 1.0)
        rolling = self.rear_share * road_wheel_angle
        return rolling + share * (sideslip_angle - rolling)


@dataclass(frozen=True)
class ObserverNoise:
    """Sensor noise (of one reading) and model noise (standard deviation after one second).

    Chosen on drives of two virtual cars at 6.7 and 25 m/s: less noise of the yaw rate's model suits crosswind and bank
    better and nonlinear tyres worse, more the reverse.
    """

    # yaw_rate_reading, road_wheel_angle_reading: standard deviations of the sensors
    yaw_rate_reading: Annotated[float, "rad/s", POSITIVE] = 0.003
    road_wheel_angle_reading: Annotated[float, "rad", POSITIVE] = 2e-4
    sideslip_angle: Annotated[float, "rad/s**0.5", POSITIVE] = 0.003  # unmodelled lateral forces, over mass and speed
    yaw_rate: Annotated[float, "rad/s**1.5", POSITIVE] = 0.04  # unmodelled yaw moments
    # unmodelled torques of the steering: friction, power assist
    road_wheel_rate: Annotated[float, "rad/s**1.5", POSITIVE] = 0.6
    # random walk of the aligning torque in the disturbance observer
    self_aligning_torque: Annotated[float, "N*m/s**0.5", POSITIVE] = 120.0
    # error of the aligning torque that the disturbance observer passes to the second stage
    torque_reading: Annotated[float, "N*m", POSITIVE] = 20.0
    torque_time: Annotated[float, "s", NOT_NEGATIVE] = 0.03  # correlation time of that error

    def torque_variance(self, sample_time: float) -> float:
        """Variance [N2 m2] of a white reading with the same information as one with a correlated error."""
        return self.torque_reading**2 * max(1.0, 2.0 * self.torque_time / sample_time)


@dataclass(frozen=True)
class SteeringTorqueObserver(ABC):
    """Base of the observers of the paper; the estimate is held where nothing can be estimated.

    The standard deviation of the sideslip angle covers noise and unmodelled forces, and errors of stiffness, trail and
    neglected tyre lag.
    """

    low_speed: LowSpeed  # speed range in which it runs
    axles: Axles  # uncertainty of the axles

    Sample = ObserverSample

    def init(self) -> ObserverState:
        return ObserverState(self._start(), 0.0, self.axles.start())

    def step(self, state: ObserverState, sample: ObserverSample) -> tuple[ObserverState, ObserverEstimate]:
        seen = self.low_speed.seen(sample)
        own, found = self._observe(state.own, seen)
        blended = self.low_speed.blended(found.sideslip_angle, found.road_wheel_angle, seen.vehicle_speed)
        slips = self.axles.follow(
            state.slips, found.sideslip_angle, found.yaw_rate, found.road_wheel_angle, seen.vehicle_speed, seen.running
        )
        after = ObserverState(own, where(seen.running, blended, state.sideslip_angle), slips)
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
        """Initial state of the particular observer."""

    @abstractmethod
    def _observe(self, own: Tree, seen: Seen) -> tuple[Tree, Found]:
        """Process one sample; the own state is held where the observer does not run."""


def low_speed(p: SteeredVehicle.Parameters) -> LowSpeed:
    """Speed range and low-speed output for a car with these parameters."""
    return LowSpeed(p.rear_distance / (p.front_distance + p.rear_distance))


def require_observable(p: SteeredVehicle.Parameters, sample_time: float) -> None:
    """Refuse a car that the observers cannot follow.

    Args:
        sample_time: sampling interval [s]

    Raises:
        ParameterError: no trail, so that the torque holds no information on the tyres; or a motion too fast for the
            step, with its eigenvalue
    """
    trail = p.mechanical_trail + p.pneumatic_trail
    if not trail * p.front_cornering_stiffness > 0.0:
        raise ParameterError(
            f"mechanical_trail and pneumatic_trail together are {trail:g} m and front_cornering_stiffness is "
            f"{p.front_cornering_stiffness:g} N/rad: the aligning torque then does not depend on sideslip_angle; both "
            "must be above zero"
        )
    if not 0.0 < sample_time <= 0.1:
        raise ParameterError(f"the sample time is {sample_time} s; expected more than 0 and at most 0.1 s")
    step = sample_time / finer_steps(sample_time)
    system = linearise(SteeredVehicle, p, (0.0,) * 4, (0.0, LowSpeed.slowest))
    fastest = max(np.linalg.eigvals(system.A), key=abs)
    if abs(fastest) * step > MOST:
        raise ParameterError(
            f"at {LowSpeed.slowest:g} m/s the car has an eigenvalue of {fastest.real:.4g} 1/s, too fast for steps of "
            f"{step:g} s; check road_wheel_inertia, road_wheel_damping, road_wheel_friction and yaw_inertia"
        )


def finer_steps(sample_time: float) -> int:
    """Integration steps within a sample: a millisecond each, far from the stability limit of the models."""
    return max(1, math.ceil(sample_time / 1e-3 - 1e-6))
