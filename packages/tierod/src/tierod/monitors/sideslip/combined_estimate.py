"""Sample and estimate of the combined sideslip estimator, and the estimate's derivation from the filter's belief."""

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
"""Floor of the sideslip angle's standard deviation [rad], for errors that no state of the model describes. Measured on
drives of the virtual car, where with it 95 % bands contain about 95 %."""

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
    """Input sample, NaN where the car lacks a signal.

    Args:
        vehicle_speed: forward speed; without it, and below walking pace, the last estimate is held
        road_wheel_angle: mean of both front wheels
        yaw_rate, lateral_acceleration, longitudinal_acceleration: readings of the inertial unit
        road_wheel_torque: torque of the actuator about the kingpins, for a car steered by wire
    """

    vehicle_speed: Annotated[Scalar, "m/s"]
    road_wheel_angle: Annotated[Scalar, "rad"]
    yaw_rate: Annotated[Scalar, "rad/s"]
    lateral_acceleration: Annotated[Scalar, "m/s**2"]
    longitudinal_acceleration: Annotated[Scalar, "m/s**2"]
    road_wheel_torque: Annotated[Scalar, "N*m"]


class CombinedEstimate(NamedTuple):
    """Estimate after a sample; a `_deviation` is one standard deviation, `identified` the share by which the data
    reduced the prior variance.

    Args:
        sideslip_angle: sideslip angle at the centre of gravity
        lateral_speed, corrected_yaw_rate: motion of the centre of gravity, without the gyroscope's bias
        front_slip_angle, rear_slip_angle: slip angles of the axles, positive where the force is to the left
        front_lateral_force, rear_lateral_force: forces of the axles, across the wheels
        self_aligning_torque: torque of the front axle, opposing positive steer
        front_friction_used, rear_friction_used: lateral force over the greatest that the axle can produce now
        limit_ahead: 1 where front slip exceeds the slip at the tuning's share of the greatest force by the required
            standard deviations, and the estimate is not held
        limit_distance: that excess in standard deviations
        front_stiffness, rear_stiffness: true over given cornering stiffness
        friction: true over given friction coefficient
        bank_angle: bank of the road
        side_force, side_moment: effects of wind
        steering_friction: dry friction of the steering, true over given
        nis, readings: normalised innovation squared of the sample, and its number of readings
        held: 1 where nothing could be estimated and the last estimate is held
        restarted: 1 where the filter was lost and restarted
        yaw_noise_scale, acceleration_noise_scale: variance of the noise over its minimum, see `NoiseScale`
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
    """Quantities derived from the states, each with its own standard deviation."""

    sideslip_angle: Annotated[Scalar, "rad"]
    self_aligning_torque: Annotated[Scalar, "N*m"]
    front_friction_used: Annotated[Scalar, ""]
    front_scaled_slip: Annotated[Scalar, ""]


def derived_fields(filter: KalmanFilter, belief: Belief, inputs: Tree, limit_share: Scalar) -> dict[str, Scalar]:
    """Fields of `CombinedEstimate` that follow from a belief.

    Args:
        filter: filter of the belief
        belief: belief after a sample
        inputs: inputs of the model, all finite
        limit_share: share of the greatest front force at which `limit_distance` is zero

    The limit is tested on the scaled slip, which keeps growing where the force no longer does: near the peak an
    uncertain slip would give a force that appears certain.
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
    """Unknowns with standard deviations and identified shares; the given value where one is not a state."""
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
