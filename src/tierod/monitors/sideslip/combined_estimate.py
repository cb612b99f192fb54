"""Sample and estimate of the combined sideslip estimator, and how the estimate follows from the filter's belief."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.graph.derivatives import jacobian
from tierod.core.graph.maths import absolute, arctan, cos, exp, limit, maximum, sin, sqrt
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.linear_algebra import congruence, diagonal
from tierod.methods.estimators.shapes import Belief
from tierod.physics.magic_formula import scaled_slip_of

UNSEEN = 5e-4
"""Standard deviation of the sideslip angle [rad] that stays whatever the filter states: of what no state of the model
stands for. As found on drives of the virtual car, where it makes 95 % bands hold about 95 %."""

FIELDS = {
    "log_front_stiffness": "front_stiffness",
    "log_rear_stiffness": "rear_stiffness",
    "log_friction": "friction",
    "bank_angle": "bank_angle",
    "side_force": "side_force",
    "side_moment": "side_moment",
    "lateral_acceleration_bias": "lateral_acceleration_bias",
    "yaw_rate_bias": "yaw_rate_bias",
    "road_wheel_angle_offset": "road_wheel_angle_offset",
    "log_steering_friction": "steering_friction",
    "log_trail": "trail",
}
"""Unknown of the model -> field of the estimate."""


class CombinedSample(NamedTuple):
    """One sample, NaN where the car lacks a signal.

    Args:
        vehicle_speed: forward; without it, and below walking pace, the last estimate is held
        road_wheel_angle: mean of both front wheels
        yaw_rate, lateral_acceleration, longitudinal_acceleration: of the inertial unit
        road_wheel_torque: of the actuator about the kingpins, for a car steered by wire
    """

    vehicle_speed: Annotated[Scalar, "m/s"]
    road_wheel_angle: Annotated[Scalar, "rad"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    lateral_acceleration: Annotated[Scalar, "m/s**2"]
    longitudinal_acceleration: Annotated[Scalar, "m/s**2"]
    road_wheel_torque: Annotated[Scalar, "N*m"]


class CombinedEstimate(NamedTuple):
    """Estimate after a sample; a `_deviation` is one standard deviation, `identified` the share of the prior
    variance that the data took away.

    Args:
        sideslip_angle: at the centre of gravity
        lateral_speed, corrected_yaw_rate: of the centre of gravity, without the gyroscope's bias
        front_slip_angle, rear_slip_angle: of the axles, positive where the force is to the left
        front_lateral_force, rear_lateral_force: of the axles, across the wheels
        self_aligning_torque: of the front axle, opposes positive steer
        front_friction_used, rear_friction_used: lateral force over the greatest that the axle can make now
        limit_ahead: 1 where `front_friction_used` is above the tuning's share by its standard deviations, and not held
        limit_distance: by how many of them it is
        front_stiffness, rear_stiffness: true over given cornering stiffness
        friction: true over given friction coefficient
        bank_angle: of the road
        side_force, side_moment: of wind
        steering_friction: dry friction of the steering, true over given
        nis, readings: normalised innovation squared of the sample, and over how many readings
        held: 1 where nothing could be estimated and the last estimate stands
        restarted: 1 where the innovations had been too large for a second, and the filter started anew
        yaw_noise_scale, acceleration_noise_scale: variance of the noise over the least one, see `NoiseScale`
    """

    sideslip_angle: Annotated[Scalar, "rad"]
    sideslip_angle_deviation: Annotated[Scalar, "rad"]
    lateral_speed: Annotated[Scalar, "m/s"]
    corrected_yaw_rate: Annotated[Scalar, "rad/s"]
    front_slip_angle: Annotated[Scalar, "rad"]
    rear_slip_angle: Annotated[Scalar, "rad"]
    front_lateral_force: Annotated[Scalar, "N"]
    rear_lateral_force: Annotated[Scalar, "N"]
    self_aligning_torque: Annotated[Scalar, "N*m"]
    self_aligning_torque_deviation: Annotated[Scalar, "N*m"]
    front_friction_used: Annotated[Scalar, ""]
    front_friction_used_deviation: Annotated[Scalar, ""]
    rear_friction_used: Annotated[Scalar, ""]
    limit_ahead: Annotated[Scalar, ""]
    limit_distance: Annotated[Scalar, ""]
    front_stiffness: Annotated[Scalar, ""]
    front_stiffness_deviation: Annotated[Scalar, ""]
    front_stiffness_identified: Annotated[Scalar, ""]
    rear_stiffness: Annotated[Scalar, ""]
    rear_stiffness_deviation: Annotated[Scalar, ""]
    rear_stiffness_identified: Annotated[Scalar, ""]
    friction: Annotated[Scalar, ""]
    friction_deviation: Annotated[Scalar, ""]
    friction_identified: Annotated[Scalar, ""]
    bank_angle: Annotated[Scalar, "rad"]
    bank_angle_deviation: Annotated[Scalar, "rad"]
    bank_angle_identified: Annotated[Scalar, ""]
    side_force: Annotated[Scalar, "N"]
    side_force_deviation: Annotated[Scalar, "N"]
    side_force_identified: Annotated[Scalar, ""]
    steering_friction: Annotated[Scalar, ""]
    steering_friction_deviation: Annotated[Scalar, ""]
    lateral_acceleration_bias: Annotated[Scalar, "m/s**2"]
    yaw_rate_bias: Annotated[Scalar, "rad/s"]
    road_wheel_angle_offset: Annotated[Scalar, "rad"]
    nis: Annotated[Scalar, ""]
    readings: Annotated[Scalar, ""]
    held: Annotated[Scalar, ""]
    restarted: Annotated[Scalar, ""]
    yaw_noise_scale: Annotated[Scalar, ""]
    acceleration_noise_scale: Annotated[Scalar, ""]


class Derived(NamedTuple):
    """Quantities derived from the states, each with a standard deviation of its own."""

    sideslip_angle: Annotated[Scalar, "rad"]
    self_aligning_torque: Annotated[Scalar, "N*m"]
    front_friction_used: Annotated[Scalar, ""]
    front_scaled_slip: Annotated[Scalar, ""]


def derived_fields(filter: KalmanFilter, belief: Belief, inputs: Tree, limit_share: Scalar) -> dict[str, Scalar]:
    """Fields of `CombinedEstimate` that follow from a belief.

    Args:
        filter: whose belief it is
        belief: after a sample
        inputs: of the model, every one finite
        limit_share: of the greatest front force, from which `limit_distance` counts

    The limit is looked for in the scaled slip, which grows on where the force no longer does: near the peak a slip that
    is hardly known would give a force that seems known.
    """
    parameters = filter.parameters

    def derived(mean: Tree) -> Derived:
        forces = filter.model.forces(mean, inputs, parameters)
        return Derived(
            arctan(mean.lateral_speed / inputs.vehicle_speed),
            forces.self_aligning_torque,
            absolute(forces.front.lateral) / forces.front.greatest,
            absolute(sin(forces.front.angle) / cos(forces.front.angle)),
        )

    variance = Derived(*diagonal(congruence(jacobian(derived, belief.mean), belief.covariance)))
    at, forces = derived(belief.mean), filter.model.forces(belief.mean, inputs, parameters)
    beyond = at.front_scaled_slip - scaled_slip_of(limit_share, parameters.car.front_force_shape)
    return {
        "sideslip_angle": at.sideslip_angle,
        "sideslip_angle_deviation": sqrt(variance.sideslip_angle + UNSEEN * UNSEEN),
        "lateral_speed": belief.mean.lateral_speed,
        "corrected_yaw_rate": belief.mean.yaw_rate,
        "front_slip_angle": arctan(forces.front_slip),
        "rear_slip_angle": arctan(forces.rear_slip),
        "front_lateral_force": forces.front.lateral,
        "rear_lateral_force": forces.rear.lateral,
        "self_aligning_torque": at.self_aligning_torque,
        "self_aligning_torque_deviation": sqrt(variance.self_aligning_torque),
        "front_friction_used": at.front_friction_used,
        "front_friction_used_deviation": sqrt(variance.front_friction_used),
        "limit_distance": beyond / maximum(sqrt(variance.front_scaled_slip), 1e-9),
        "rear_friction_used": absolute(forces.rear.lateral) / forces.rear.greatest,
        **_unknowns(filter, belief),
    }


def _unknowns(filter: KalmanFilter, belief: Belief) -> dict[str, Scalar]:
    """The unknowns, their standard deviations and identified shares; as given where they are no states."""
    names = filter.model.State._fields
    variances = dict(zip(names, diagonal(belief.covariance), strict=True))
    priors = dict(zip(names, filter.initial_variance, strict=True))
    known: dict[str, Scalar] = {}
    for name, field in FIELDS.items():
        value = getattr(belief.mean, name) if name in variances else 0.0
        variance, prior = variances.get(name, 0.0), priors.get(name, 1.0)
        scale = exp(value) if name.startswith("log_") else 1.0
        known[field] = scale if name.startswith("log_") else value
        known[f"{field}_deviation"] = scale * sqrt(variance)
        known[f"{field}_identified"] = limit(1.0 - variance / prior, 0.0, 1.0) if name in variances else 0.0
    return {field: value for field, value in known.items() if field in CombinedEstimate._fields}
