"""What the combined sideslip estimator tells of its belief: angles, forces, friction used, unknowns, deviations."""

from __future__ import annotations

from typing import Any, NamedTuple

from tierod.core.graph.derivatives import jacobian
from tierod.core.graph.maths import absolute, arctan, exp, limit, sqrt
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.linear_algebra import congruence, diagonal
from tierod.methods.estimators.shapes import Belief
from tierod.monitors.sideslip.combined_sample import CombinedEstimate

UNSEEN = 5e-4
"""Standard deviation of the sideslip angle [rad] that stays whatever the filter believes: of what no state of the model
stands for. As found on drives of the virtual car, where it makes 95 % bands hold about what they say."""

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


class Derived(NamedTuple):
    """What follows from the states and gets a standard deviation of its own."""

    sideslip_angle: Any
    self_aligning_torque: Any
    front_friction_used: Any


def told(filter: KalmanFilter, belief: Belief, inputs: Any) -> dict[str, Any]:
    """Fields of `CombinedEstimate` that follow from a belief.

    Args:
        filter: whose belief it is
        belief: after a sample
        inputs: of the model, every one finite
    """
    parameters = filter.parameters

    def derived(mean: Any) -> Derived:
        forces = filter.model.forces(mean, inputs, parameters)
        return Derived(
            arctan(mean.lateral_speed / inputs.vehicle_speed),
            forces.self_aligning_torque,
            absolute(forces.front.lateral) / forces.front.greatest,
        )

    variance = Derived(*diagonal(congruence(jacobian(derived, belief.mean), belief.covariance)))
    at, forces = derived(belief.mean), filter.model.forces(belief.mean, inputs, parameters)
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
        "rear_friction_used": absolute(forces.rear.lateral) / forces.rear.greatest,
        **_unknowns(filter, belief),
    }


def _unknowns(filter: KalmanFilter, belief: Belief) -> dict[str, Any]:
    """The unknowns, their standard deviations and identified shares; as given where they are no states."""
    names = filter.model.State._fields
    variances = dict(zip(names, diagonal(belief.covariance), strict=True))
    priors = dict(zip(names, filter.initial_variance, strict=True))
    known: dict[str, Any] = {}
    for name, field in FIELDS.items():
        value = getattr(belief.mean, name) if name in variances else 0.0
        variance, prior = variances.get(name, 0.0), priors.get(name, 1.0)
        scale = exp(value) if name.startswith("log_") else 1.0
        known[field] = scale if name.startswith("log_") else value
        known[f"{field}_deviation"] = scale * sqrt(variance)
        known[f"{field}_identified"] = limit(1.0 - variance / prior, 0.0, 1.0) if name in variances else 0.0
    return {field: value for field, value in known.items() if field in CombinedEstimate._fields}
