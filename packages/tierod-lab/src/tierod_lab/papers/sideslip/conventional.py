"""The conventional observer: sideslip, yaw rate, steering angle and rate in one state vector with one gain."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.graph.analysis import jacobian
from tierod.core.graph.maths import where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.linear_algebra import congruence
from tierod.models.linear import LinearSystem, discretise
from tierod_lab.methods.pole_placement import place
from tierod_lab.papers.sideslip.axles import Axles
from tierod_lab.papers.sideslip.observer import (
    Found,
    ObserverNoise,
    Seen,
    SteeringTorqueObserver,
    finer_steps,
    low_speed,
    require_observable,
)
from tierod_lab.papers.sideslip.schedule import Design, ScheduledObserver, Scheduling, faster_poles, scheduled
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle, aligning_torque

START = (0.1**2, 0.3**2, 0.3**2, 0.5**2)  # Initial variance of the state, in the units of the states

FACTOR = 10.0  # Observer poles over those of the system, as printed


def sampled_model(sample_time: float) -> Any:
    """Discrete model of the vehicle with its steering."""
    return discretise(SteeredVehicle, "midpoint", finer_steps(sample_time))


def variances(noise: ObserverNoise, sample_time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Process and measurement noise variances of the four-state model, per sample."""
    process = (noise.sideslip_angle, noise.yaw_rate, 0.02 * noise.road_wheel_rate, noise.road_wheel_rate)
    reading = (noise.yaw_rate_reading, noise.road_wheel_angle_reading)
    return tuple(q * q * sample_time for q in process), tuple(r * r for r in reading)


@dataclass(frozen=True)
class ConventionalKalman(SteeringTorqueObserver):
    """The conventional observer with Kalman gains, which adapt to the speed through the covariance.

    Args:
        filter: Kalman filter of the discrete `SteeredVehicle`

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

    Args:
        observer: observer of the discrete `SteeredVehicle`

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


def conventional_kalman(
    p: SteeredVehicle.Parameters, sample_time: float, noise: ObserverNoise | None = None
) -> ConventionalKalman:
    """The conventional observer of a car with Kalman gains.

    Args:
        sample_time: sampling interval [s]

    Raises:
        ParameterError: a car that the observer cannot follow, see `require_observable`
    """
    require_observable(p, sample_time)
    model = sampled_model(sample_time)
    process, reading = variances(noise or ObserverNoise(), sample_time)
    sampled = model.Parameters(p, sample_time)
    filter_ = KalmanFilter(model, sampled, (0.0,) * 4, START, process, reading, full_covariance=True)
    return ConventionalKalman(low_speed(p), Axles(p.front_distance, p.rear_distance, sample_time), filter_)


def conventional_poles(
    p: SteeredVehicle.Parameters, sample_time: float, factor: float = FACTOR, noise: ObserverNoise | None = None
) -> ConventionalPoles:
    """The conventional observer of a car with placed poles.

    Args:
        sample_time: sampling interval [s]
        factor: observer poles over those of the system; they are real
        noise: noise of sensors and model, for the standard deviation of the estimate

    Raises:
        ParameterError: a car that the observer cannot follow, see `require_observable`, or an observer that is not
            stable at every speed
    """
    require_observable(p, sample_time)
    model = sampled_model(sample_time)
    process, reading = variances(noise or ObserverNoise(), sample_time)
    free = dataclasses.replace(p, road_wheel_friction=0.0)
    scheduling = Scheduling(SteeredVehicle, free, lambda speed: (0.0, speed), sample_time)

    def asked(speed: float) -> np.ndarray:
        inputs = model.Input(0.0, speed)
        row = [_aligning(model.State(*unit), inputs, p) for unit in np.eye(4).tolist()]
        return np.array([[1.0, 0.0, 0.0, 0.0], row])

    schedule = scheduled(scheduling, lambda design: placed(design, factor, sample_time), asked, process, reading)
    observer = ScheduledObserver.of(model, model.Parameters(p, sample_time), schedule)
    return ConventionalPoles(low_speed(p), Axles(p.front_distance, p.rear_distance, sample_time), observer)


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
