"""Common base of the paper's observers of sideslip, and the conventional one, with Kalman gains or placed poles.

Source: Yih, Ryu, Gerdes, Vehicle state estimation using steering torque (2004), eqs (13) to (17).
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import all_of, limit, maximum, present, sqrt, where
from tierod.core.graph.trace import jacobian
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import congruence
from tierod.models.linear import LinearSystem, discretise, linearise
from tierod_lab.methods.pole_placement import place
from tierod_lab.papers.sideslip.schedule import Design, ScheduledObserver, Scheduling, faster_poles, scheduled
from tierod_lab.papers.sideslip.steered_vehicle import Axles, Slips, SteeredVehicle, aligning_torque

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

    sideslip_angle: Annotated[Scalar, "rad"]
    sideslip_angle_deviation: Annotated[Scalar, "rad"]
    self_aligning_torque: Annotated[Scalar, "N*m"]
    self_aligning_torque_deviation: Annotated[Scalar, "N*m"]
    nis: Annotated[Scalar, ""]  # nis, readings: normalised innovation squared of the sample, and its number of readings
    readings: Annotated[Scalar, ""]
    held: Annotated[Scalar, ""]  # 1 where nothing could be estimated and the last estimate is held
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

    @classmethod
    def of(cls, p: SteeredVehicle.Parameters) -> LowSpeed:
        """Speed range and low-speed output for a car with these parameters."""
        return cls(p.rear_distance / (p.front_distance + p.rear_distance))

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
        return ObserverState(self._start(), 0.0, Slips(0.0, 0.0, 0.0, 0.0))

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


def require_observable(p: SteeredVehicle.Parameters, sample_time: float) -> None:
    """Refuse a car that the observers cannot follow."""
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


def sampled_of(model: Any, sample_time: float) -> Any:
    """Discrete form of a model of the paper."""
    return discretise(model, "midpoint", finer_steps(sample_time))


def finer_steps(sample_time: float) -> int:
    """Integration steps within a sample: a millisecond each, far from the stability limit of the models."""
    return max(1, math.ceil(sample_time / 1e-3 - 1e-6))


START = (0.1**2, 0.3**2, 0.3**2, 0.5**2)  # Initial variance of the state, in the units of the states

CONVENTIONAL_FACTOR = 10.0  # Observer poles over those of the system, as printed


def _variances(noise: ObserverNoise, sample_time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Process and measurement noise variances of the four-state model, per sample."""
    process = (noise.sideslip_angle, noise.yaw_rate, 0.02 * noise.road_wheel_rate, noise.road_wheel_rate)
    reading = (noise.yaw_rate_reading, noise.road_wheel_angle_reading)
    return tuple(q * q * sample_time for q in process), tuple(r * r for r in reading)


@dataclass(frozen=True)
class ConventionalKalman(SteeringTorqueObserver):
    """The conventional observer with Kalman gains, which adapt to the speed through the covariance.

    Source: Yih, Ryu, Gerdes, eqs (13) to (15).
    """

    filter: KalmanFilter

    def _start(self) -> Tree:
        return self.filter.init()

    def _observe(self, own: Tree, seen: Seen) -> tuple[Tree, Found]:
        # Infinity marks a missing input, for which the filter holds its estimate.
        model, speed = self.filter.model, where(seen.running, seen.vehicle_speed, float("inf"))
        inputs = model.Input(seen.road_wheel_torque, speed)
        measured = model.Output(seen.yaw_rate, seen.road_wheel_angle)
        own, estimate = self.filter.step(own, self.filter.Sample(inputs, measured))
        safe = model.Input(seen.road_wheel_torque, seen.vehicle_speed)

        def torque(mean: SteeredVehicle.State) -> Scalar:
            return _aligning(mean, safe, self.filter.parameters.continuous)

        rows = jacobian(lambda mean: (torque(mean),), own.mean)
        (spread,) = congruence(rows, own.covariance)
        return own, Found(
            own.mean.sideslip_angle,
            estimate.variance.sideslip_angle,
            own.mean.yaw_rate,
            own.mean.road_wheel_angle,
            own.mean.road_wheel_rate,
            torque(own.mean),
            spread,
            estimate.nis,
            estimate.present,
        )


@dataclass(frozen=True)
class ConventionalPoles(SteeringTorqueObserver):
    """The conventional observer with poles placed at every speed.

    Source: Yih, Ryu, Gerdes, eqs (14) to (17).
    """

    observer: ScheduledObserver

    def _start(self) -> Tree:
        return self.observer.start()

    def _observe(self, own: Tree, seen: Seen) -> tuple[Tree, Found]:
        model = self.observer.model
        inputs = model.Input(seen.road_wheel_torque, seen.vehicle_speed)
        measured = model.Output(seen.yaw_rate, seen.road_wheel_angle)
        own, found = self.observer.observe(own, inputs, measured, seen.vehicle_speed, seen.running)
        torque = _aligning(found.mean, inputs, self.observer.parameters.continuous)
        sideslip, spread = found.variances
        return own, Found(
            found.mean.sideslip_angle,
            sideslip,
            found.mean.yaw_rate,
            found.mean.road_wheel_angle,
            found.mean.road_wheel_rate,
            torque,
            spread,
            found.nis,
            found.readings,
        )


def conventional_kalman(p: SteeredVehicle.Parameters, sample_time: float) -> ConventionalKalman:
    """The conventional observer of a car with Kalman gains."""
    require_observable(p, sample_time)
    model = sampled_of(SteeredVehicle, sample_time)
    process, reading = _variances(ObserverNoise(), sample_time)
    sampled = model.Parameters(p, sample_time)
    filter_ = KalmanFilter(model, sampled, (0.0,) * 4, START, process, reading, full_covariance=True)
    return ConventionalKalman(LowSpeed.of(p), Axles(p.front_distance, p.rear_distance, sample_time), filter_)


def conventional_poles(
    p: SteeredVehicle.Parameters, sample_time: float, factor: float = CONVENTIONAL_FACTOR
) -> ConventionalPoles:
    """The conventional observer of a car with placed poles.

    Args:
        sample_time: sampling interval [s]
        factor: observer poles over those of the system; they are real
    """
    require_observable(p, sample_time)
    model = sampled_of(SteeredVehicle, sample_time)
    process, reading = _variances(ObserverNoise(), sample_time)
    free = dataclasses.replace(p, road_wheel_friction=0.0)
    scheduling = Scheduling(SteeredVehicle, free, lambda speed: (0.0, speed), sample_time)

    def asked(speed: float) -> np.ndarray:
        inputs = model.Input(0.0, speed)
        row = [_aligning(model.State(*unit), inputs, p) for unit in np.eye(4).tolist()]
        return np.array([[1.0, 0.0, 0.0, 0.0], row])

    schedule = scheduled(scheduling, lambda design: placed(design, factor, sample_time), asked, process, reading)
    observer = ScheduledObserver.of(model, model.Parameters(p, sample_time), schedule)
    return ConventionalPoles(LowSpeed.of(p), Axles(p.front_distance, p.rear_distance, sample_time), observer)


def placed(design: Design, factor: float, sample_time: float) -> np.ndarray:
    """A gain with real poles, factor times the magnitudes of the system's eigenvalues.

    With two outputs the gain is not unique. Here the error of the yaw rate has its own pole and drives no other error;
    the other three errors are observed through the steering angle alone, for which the gain is unique. The gain is thus
    smooth over the speed and valid in neutral steer, where the sideslip is not observable from the yaw rate.
    """
    A = design.system.A
    poles = faster_poles(design, factor, sample_time)
    rest, yaw = [0, 2, 3], 1
    own, others = poles[1], poles[[0, 2, 3]]
    part = LinearSystem.of(A[np.ix_(rest, rest)], np.array([[0.0, 1.0, 0.0]]))
    predictor = np.zeros((4, 2))
    predictor[:, 0] = A[:, yaw]
    predictor[yaw, 0] -= own
    predictor[rest, 1] = place(part, tuple(others))[:, 0]
    predictor[yaw, 1] = A[yaw, 2]
    # The design is that of a predictor; the corrector's gain is A^-1 times it.
    return np.linalg.solve(A, predictor)


def _aligning(mean: SteeredVehicle.State, inputs: SteeredVehicle.Input, p: SteeredVehicle.Parameters) -> Scalar:
    torque: Scalar = aligning_torque(*SteeredVehicle.parts(mean, inputs), p)
    return torque
