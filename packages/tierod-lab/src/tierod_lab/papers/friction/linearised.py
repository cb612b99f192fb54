"""The refined monitor with every term of its linearised balance, eq (19)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from tierod.methods.estimators.shapes import Belief
from tierod.models.friction_estimation import FrictionParameters
from tierod_lab.papers.friction.linearised_model import LinearisedFrictionEstimation, VariableRatioParameters
from tierod_lab.papers.friction.presets import joint_filter
from tierod_lab.papers.friction.refined import RefinedFrictionMonitor


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
