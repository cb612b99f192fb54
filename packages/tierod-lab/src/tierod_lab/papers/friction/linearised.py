"""The linearised friction monitor of eq (19), and its model."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import tanh
from tierod.methods.estimators.shapes import Belief
from tierod.models.steering_column import FrictionParameters
from tierod.physics.steering import column_torque_of_motor, torque_at_steering_wheel
from tierod_lab.ground.laws import variable_ratio
from tierod_lab.papers.friction.joint_model import FrictionEstimation, SmoothFrictionParameters, state_after
from tierod_lab.papers.friction.presets import joint_filter
from tierod_lab.papers.friction.refined import RefinedFrictionMonitor


@dataclass(frozen=True)
class VariableRatioParameters(SmoothFrictionParameters):
    """Parameters of the joint model with variable ratio, named as in a vehicle file."""

    # relative growth of the ratio with the squared angle [1/rad^2]; zero is a constant ratio
    steering_ratio_growth: Annotated[float, "1/rad**2"] = 0.0
    with_ratio_slope: Annotated[float, ""] = 1.0  # 1 with the term of rho' in eq (19), 0 without
    with_sign_slope: Annotated[float, ""] = 1.0  # 1 with the term of delta in eq (19), 0 without


class LinearisedFrictionEstimation:
    """The joint model of `FrictionEstimation` with all terms of its linearisation.

    The torques rho(theta) M_z and T_f sgn(theta') are products, whose linearisation has the terms
    rho'(theta*) M_z* (theta - theta*) and 2 delta(theta'*) T_f* (theta' - theta'*). The paper omits both and prints the
    second without the factor 2, although d sgn(x)/dx = 2 delta(x). Delta is that of a sign smoothed by tanh over
    `smoothing_rate`: a damping of T_f / smoothing_rate near standstill, and none at several times that rate.

    Source: Mohtat et al., eq (19).
    """

    State = FrictionEstimation.State
    Output = FrictionEstimation.Output
    Parameters = VariableRatioParameters

    class Input(NamedTuple):
        driver_torque: Annotated[float, "N*m"]
        motor_torque: Annotated[float, "N*m"]
        lateral_acceleration: Annotated[float, "m/s**2"]
        direction: Annotated[float, ""]
        angle_there: Annotated[float, "rad"]
        rate_there: Annotated[float, "rad/s"]
        aligning_there: Annotated[float, "N*m"]
        friction_there: Annotated[float, "N*m"]

    @staticmethod
    def transition(x: FrictionEstimation.State, u: Input, p: VariableRatioParameters) -> FrictionEstimation.State:
        ratio = variable_ratio(u.angle_there, p.steering_ratio, p.steering_ratio_growth)
        slope = variable_ratio_slope(u.angle_there, p.steering_ratio, p.steering_ratio_growth)
        turned = x.steering_wheel_angle - u.angle_there
        aligning = torque_at_steering_wheel(x.self_aligning_torque, ratio)
        aligning = aligning + p.with_ratio_slope * torque_at_steering_wheel(u.aligning_there, slope * turned)
        net = u.driver_torque + column_torque_of_motor(u.motor_torque, p.motor_ratio) - aligning - _friction(x, u, p)
        return state_after(x, net, u.lateral_acceleration, p)

    @staticmethod
    def output(x: FrictionEstimation.State, u: Input, p: VariableRatioParameters) -> FrictionEstimation.Output:
        return FrictionEstimation.Output(x.steering_wheel_angle, x.steering_wheel_rate, x.yaw_rate)


def _friction(x: FrictionEstimation.State, u: LinearisedFrictionEstimation.Input, p: VariableRatioParameters) -> Scalar:
    turn = smooth_sign_slope(u.rate_there, p.smoothing_rate) * (x.steering_wheel_rate - u.rate_there)
    return x.friction_torque * u.direction + p.with_sign_slope * u.friction_there * turn


@dataclass(frozen=True)
class LinearisedFrictionMonitor(RefinedFrictionMonitor):
    """The refined monitor on `LinearisedFrictionEstimation`, which takes the operating point as inputs.

    `operating_point` decides whether its angle and rate are measured or estimated; torque and friction are estimates.
    Source: Mohtat et al., appendix B.
    """

    def inputs(self, before: Any, belief: Belief, direction: Any) -> Any:
        """Inputs of the model, with the operating point."""
        plain = super().inputs(before, belief, direction)
        there = before if self.operating_point == "measurement" else belief.mean
        return LinearisedFrictionEstimation.Input(
            plain.driver_torque,
            plain.motor_torque,
            plain.lateral_acceleration,
            plain.direction,
            there.steering_wheel_angle,
            there.steering_wheel_rate,
            belief.mean.self_aligning_torque,
            belief.mean.friction_torque,
        )


def linearised(parameters: FrictionParameters, **terms: float) -> LinearisedFrictionMonitor:
    """The printed monitor with the terms of eq (19) and a large process noise of the self-aligning torque.

    Args:
        parameters: parameters of the joint model; `vehicle.parameters_for(VariableRatioParameters)` includes the growth
            of the ratio where the vehicle file gives `steering_ratio_growth`
        terms: fields of `VariableRatioParameters`, which replace those of `parameters`
    """
    return LinearisedFrictionMonitor(
        joint_filter(
            VariableRatioParameters(**{**dataclasses.asdict(parameters), **terms}),
            input_variance=(0.01, 0.01, 0.1),
            virtual_variance=(1e4, 0.001),
            virtual_noise="scaled by sample time",
            covariance_update="printed",
            initial_friction_variance=1.0,
            model=LinearisedFrictionEstimation,
        )
    )


def variable_ratio_slope(steering_wheel_angle: Scalar, centre_ratio: Scalar, growth: Scalar) -> Scalar:
    """Derivative of `variable_ratio` with respect to the angle [1/rad], rho' of Mohtat et al., eq (19).

    Args:
        steering_wheel_angle: [rad]
        centre_ratio: ratio at the centre [-]
        growth: relative growth with the squared angle [1/rad**2]
    """
    return 2.0 * centre_ratio * growth * steering_wheel_angle


def smooth_sign_slope(rate: Scalar, width: Scalar) -> Scalar:
    """Derivative [s/rad] of the sign function smoothed by a hyperbolic tangent: twice a Dirac delta of finite width.

    Source: d tanh(x / w) / dx; its integral over all rates is 2, as that of d sgn(x) / dx = 2 delta(x) in eq (19) of
    Mohtat et al., printed without the factor.

    Args:
        rate: angular rate [rad/s]
        width: rate at which 76 % of the sign is reached [rad/s]
    """
    level = tanh(rate / width)
    return (1.0 - level * level) / width
