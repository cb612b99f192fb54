"""The two-stage observer: the steering gives the aligning torque, and this and the yaw rate give the sideslip.

Source: Yih, Ryu, Gerdes, Vehicle state estimation using steering torque (2004), eqs (18) to (25).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE
from tierod.core.graph.maths import present, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.observers import Luenberger
from tierod.models.linear import linearise
from tierod_lab.ground.steering.road_wheels import DisturbedSteering
from tierod_lab.methods.pole_placement import discrete_poles, observer_gain
from tierod_lab.papers.sideslip.observers import (
    Found,
    LowSpeed,
    ObserverNoise,
    Seen,
    SteeringTorqueObserver,
    require_observable,
    sampled_of,
)
from tierod_lab.papers.sideslip.schedule import (
    Design,
    ScheduledObserver,
    Scheduling,
    faster_poles,
    scheduled,
    stationary_covariance,
)
from tierod_lab.papers.sideslip.steered_vehicle import Axles, SteeredVehicle, TorqueShownVehicle

DISTURBANCE_POLES = (-60.0, -65.0, -70.0)
"""Poles of the disturbance observer [1/s]; three times as fast as the vehicle at the test speed, slightly apart."""

TWO_STAGE_FACTOR = 2.0
"""Poles of the vehicle's observer over those of the vehicle; more passes more of the disturbance observer's error."""

STEERING_START = (0.3**2, 0.5**2, 100.0**2)
VEHICLE_START = (0.1**2, 0.3**2)  # Initial variances of both stages, in the units of the states


class Stages(NamedTuple):
    """States of both observers."""

    steering: Tree
    vehicle: Tree


@dataclass(frozen=True)
class TwoStageKalman(SteeringTorqueObserver):
    """Both stages with Kalman gains; those of the second adapt to the speed through the covariance.

    Source: Yih, Ryu, Gerdes, eqs (18) to (20) and (22) to (24).
    """

    steering: KalmanFilter
    vehicle: KalmanFilter

    def _start(self) -> Tree:
        return Stages(self.steering.init(), self.vehicle.init())

    def _observe(self, own: Stages, seen: Seen) -> tuple[Tree, Found]:
        outer, inner = self.steering.model, self.vehicle.model
        given = outer.Input(where(seen.running, seen.road_wheel_torque, float("inf")))
        sample = self.steering.Sample(given, outer.Output(seen.road_wheel_angle))
        steering, disturbed = self.steering.step(own.steering, sample)
        torque, angle = steering.mean.self_aligning_torque, steered(seen, steering.mean)
        inputs = inner.Input(angle, where(seen.running, seen.vehicle_speed, float("inf")))
        vehicle, found = self.vehicle.step(
            own.vehicle, self.vehicle.Sample(inputs, inner.Output(seen.yaw_rate, measured_torque(seen, torque)))
        )
        return Stages(steering, vehicle), Found(
            vehicle.mean.sideslip_angle,
            found.variance.sideslip_angle,
            vehicle.mean.yaw_rate,
            steering.mean.road_wheel_angle,
            steering.mean.road_wheel_rate,
            torque,
            disturbed.variance.self_aligning_torque,
            found.nis,
            found.present,
        )


@dataclass(frozen=True)
class TwoStagePoles(SteeringTorqueObserver):
    """Both stages with placed poles; those of the second are placed at every speed.

    Source: Yih, Ryu, Gerdes, eqs (18) to (25).
    """

    steering: Luenberger
    vehicle: ScheduledObserver
    torque_variance: Annotated[float, "N**2*m**2", NOT_NEGATIVE]  # variance of the aligning torque

    def _start(self) -> Tree:
        return Stages(self.steering.init(), self.vehicle.start())

    def _observe(self, own: Stages, seen: Seen) -> tuple[Tree, Found]:
        outer, inner = self.steering.model, self.vehicle.model
        given = outer.Input(where(seen.running, seen.road_wheel_torque, float("inf")))
        sample = self.steering.Sample(given, outer.Output(seen.road_wheel_angle))
        steering, _ = self.steering.step(own.steering, sample)
        torque = steering.self_aligning_torque
        inputs = inner.Input(steered(seen, steering), seen.vehicle_speed)
        measured = inner.Output(seen.yaw_rate, measured_torque(seen, torque))
        vehicle, found = self.vehicle.observe(own.vehicle, inputs, measured, seen.vehicle_speed, seen.running)
        sideslip, grown = found.variances
        return Stages(steering, vehicle), Found(
            found.mean.sideslip_angle,
            sideslip,
            found.mean.yaw_rate,
            steering.road_wheel_angle,
            steering.road_wheel_rate,
            torque,
            self.torque_variance + grown,
            found.nis,
            found.readings,
        )


def steered(seen: Seen, steering: DisturbedSteering.State) -> Scalar:
    """The measured angle of the road wheels [rad], or the disturbance observer's where that is missing."""
    return where(present(seen.road_wheel_angle), seen.road_wheel_angle, steering.road_wheel_angle)


def measured_torque(seen: Seen, torque: Scalar) -> Scalar:
    """The aligning torque [N m] as a measurement of the second stage; missing where no angle has updated it."""
    return where(present(seen.road_wheel_angle), torque, float("inf"))


def two_stage_kalman(p: SteeredVehicle.Parameters, sample_time: float) -> TwoStageKalman:
    """The two-stage observer of a car with Kalman gains."""
    require_observable(p, sample_time)
    noise = ObserverNoise()
    model, process, reading = _steering(noise, sample_time)
    steering = KalmanFilter(
        model, model.Parameters(_part(p, DisturbedSteering), sample_time), (0.0,) * 3, STEERING_START, process, reading
    )
    inner, own, readings = _vehicle(noise, sample_time)
    vehicle = KalmanFilter(
        inner, inner.Parameters(_part(p, TorqueShownVehicle), sample_time), (0.0,) * 2, VEHICLE_START, own, readings
    )
    return TwoStageKalman(LowSpeed.of(p), Axles(p.front_distance, p.rear_distance, sample_time), steering, vehicle)


def two_stage_poles(
    p: SteeredVehicle.Parameters,
    sample_time: float,
    factor: float = TWO_STAGE_FACTOR,
) -> TwoStagePoles:
    """The two-stage observer of a car with placed poles.

    Args:
        sample_time: sampling interval [s]
        factor: poles of the vehicle's observer over those of the vehicle
    """
    require_observable(p, sample_time)
    noise = ObserverNoise()
    model, process, reading = _steering(noise, sample_time)
    # Dry friction is not linear, so the gain is designed without it; the observer itself includes it.
    free = dataclasses.replace(_part(p, DisturbedSteering), road_wheel_friction=0.0)
    system = linearise(model, model.Parameters(free, sample_time), (0.0,) * 3, (0.0,))
    gain = observer_gain(system, discrete_poles(DISTURBANCE_POLES, sample_time))
    spread = stationary_covariance(system, np.array(gain), process, reading).corrected
    steering = Luenberger(model, model.Parameters(_part(p, DisturbedSteering), sample_time), (0.0,) * 3, gain)
    return TwoStagePoles(
        LowSpeed.of(p),
        Axles(p.front_distance, p.rear_distance, sample_time),
        steering,
        _second(p, sample_time, factor, noise),
        float(spread[2, 2]),
    )


def _second(p: SteeredVehicle.Parameters, sample_time: float, factor: float, noise: ObserverNoise) -> ScheduledObserver:
    inner, process, reading = _vehicle(noise, sample_time)
    own = _part(p, TorqueShownVehicle)
    sampled = inner.Parameters(own, sample_time)
    scheduling = Scheduling(TorqueShownVehicle, own, lambda speed: (0.0, speed), sample_time)
    schedule = scheduled(
        scheduling,
        lambda design: decoupled(design, factor, sample_time),
        lambda speed: np.array([[1.0, 0.0], [0.0, 0.0]]),
        process,
        reading,
    )
    return ScheduledObserver.of(inner, sampled, schedule)


def decoupled(design: Design, factor: float, sample_time: float) -> np.ndarray:
    """A gain with real poles, factor times the magnitudes of the vehicle's eigenvalues.

    Two outputs determine both states, so that every error can have its own pole without coupling to the other: of all
    gains with these poles this one is used. Sideslip is then corrected by the aligning torque alone.
    """
    A, C = design.system.A, design.system.C
    return (A - np.diag(faster_poles(design, factor, sample_time))) @ np.linalg.inv(C @ A)


def _steering(noise: ObserverNoise, sample_time: float) -> tuple[Any, tuple[float, ...], tuple[float, ...]]:
    process = (0.02 * noise.road_wheel_rate, noise.road_wheel_rate, noise.self_aligning_torque)
    variances = tuple(q * q * sample_time for q in process)
    return sampled_of(DisturbedSteering, sample_time), variances, (noise.road_wheel_angle_reading**2,)


def _vehicle(noise: ObserverNoise, sample_time: float) -> tuple[Any, tuple[float, ...], tuple[float, ...]]:
    process = (noise.sideslip_angle**2 * sample_time, noise.yaw_rate**2 * sample_time)
    return (
        sampled_of(TorqueShownVehicle, sample_time),
        process,
        (noise.yaw_rate_reading**2, noise.torque_variance(sample_time)),
    )


def _part(p: SteeredVehicle.Parameters, model: Any) -> Any:
    return model.Parameters(*(getattr(p, each.name) for each in dataclasses.fields(model.Parameters)))
