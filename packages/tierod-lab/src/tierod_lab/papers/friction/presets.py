"""Readings of the paper's joint filter: as printed, with open noise, consistent, unscented, and all of eq (19)."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.steering_column import FrictionParameters
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.friction.joint_model import (
    FrictionEstimation,
    SmoothFrictionEstimation,
    SmoothFrictionParameters,
)
from tierod_lab.papers.friction.refined import (
    LinearisedFrictionEstimation,
    LinearisedFrictionMonitor,
    OperatingPoint,
    RefinedFrictionMonitor,
    Sticking,
    VariableRatioParameters,
)

VirtualNoise = Literal["scaled by sample time", "per sample"]

PRINTED_NOISE = (0.01, 0.01, 0.1)
"""Q of driver torque and motor torque [(N m)^2], and of lateral acceleration [(m/s^2)^2], eq (11)."""
OPEN = (1e4, 0.001)
"""Q of self-aligning torque, which is then tracked, and of friction [(N m)^2]; printed are 1 and 0.001."""


def joint_filter(
    parameters: FrictionParameters,
    *,
    input_variance: tuple[float, float, float] = PRINTED_NOISE,
    virtual_variance: tuple[float, float] = OPEN,
    virtual_noise: VirtualNoise = "scaled by sample time",
    covariance_update: Literal["printed", "schmidt"] = "printed",
    initial_friction_variance: float = 1.0,
    estimator: type[KalmanFilter] = KalmanFilter,
    model: Any = FrictionEstimation,
) -> KalmanFilter:
    """The filter of the joint model with Q and R named as in eqs (11) and (12).

    Args:
        input_variance, virtual_variance: Q as in `PRINTED_NOISE` and `OPEN`
        virtual_noise: the last two rows of G: "scaled by sample time" (printed, eq 8: dt) or "per sample" (1)
        covariance_update: "printed" (Table 3) or "schmidt" (consistent with the enabled gain)
        initial_friction_variance: P_T [(N m)^2], not printed; it decides how fast the estimate leaves its start.
            With the printed covariance values from 0.1 on make no difference: they fade before the gate first opens

    The rest of P0 is not printed either: 1e-2 for the motions, 100 (N m)^2 for the self-aligning torque [assumed].
    """
    scale = parameters.sample_time**2 if virtual_noise == "scaled by sample time" else 1.0
    return estimator(
        model=model,
        parameters=parameters,
        initial_mean=(0.0, 0.0, 0.0, 0.0, 3.0),  # friction of 3 N m, as printed
        initial_variance=(1e-2, 1e-2, 1e-2, 100.0, initial_friction_variance),
        process_noise=(None, None, None, scale * virtual_variance[0], scale * virtual_variance[1]),
        measurement_noise=(1e-4,) * 3,  # of angle [rad^2], rate and yaw rate [rad^2/s^2], as printed
        input_noise=(*input_variance, *[None] * (len(model.Input._fields) - len(input_variance))),
        maskable=("friction_torque",),
        covariance_update=covariance_update,
        hold_missing_input=False,
    )


def printed(
    parameters: FrictionParameters,
    *,
    initial_friction_variance: float = 1.0,
    operating_point: OperatingPoint = "measurement",
    virtual_noise: VirtualNoise = "scaled by sample time",
    virtual_variance: tuple[float, float] = (1.0, 0.001),
) -> RefinedFrictionMonitor:
    """The monitor as printed: literal Q of eq (11), dt in the virtual rows of G, covariance update of Table 3.

    The self-aligning torque is hardly tracked with it (41 N m root mean square) and friction reads 0.4 to 0.9 N m high.

    Args:
        initial_friction_variance: P_T [(N m)^2]; from 3 N m, 12.5 N m reads 8.0 N m after the printed 50 s of enabled
            time with 1, and 6.5 N m with the steady value of 6e-4 (`tierod study friction`)
        virtual_noise: reading of G; "per sample" tracks the self-aligning torque at the price of more scatter
    """
    noise: dict[str, Any] = {"virtual_variance": virtual_variance, "virtual_noise": virtual_noise}
    return RefinedFrictionMonitor(
        joint_filter(parameters, **noise, initial_friction_variance=initial_friction_variance),
        operating_point=operating_point,
    )


def printed_open(parameters: FrictionParameters, **how: Any) -> RefinedFrictionMonitor:
    """The printed monitor with Q = 1e4 of the self-aligning torque, so that it is tracked; arguments of `printed`."""
    return printed(parameters, virtual_variance=OPEN, **how)


def consistent(parameters: FrictionParameters) -> RefinedFrictionMonitor:
    """The corrected monitor: Schmidt-Joseph covariance, Q = diag(1, 1, 0.1, 1e4, 0.1), sticking.

    Q of the torques is 1 (N m)^2 instead of 0.01, which covers the model error; the standard deviation of the
    self-aligning torque is then 6.5 N m, and the variance of friction is meaningful. P_T of (5 N m)^2 covers every
    level of the paper, and the estimate has converged after 10 s of enabled time.
    """
    return RefinedFrictionMonitor(
        joint_filter(
            parameters,
            input_variance=(1.0, 1.0, 0.1),
            virtual_variance=(1e4, 0.1),
            covariance_update="schmidt",
            initial_friction_variance=25.0,
        ),
        sticking=Sticking(),
    )


def unscented(parameters: FrictionParameters, *, smoothing_rate: float = 0.02) -> RefinedFrictionMonitor:
    """The unscented variant that the paper names as future work: friction T_f tanh(rate/eps), consistent covariance.

    A wider tanh (0.05 rad/s) reads 5 % higher, which compensates part of the pre-sliding bias by coincidence.

    Args:
        smoothing_rate: eps, rate at which tanh reaches 76 % [rad/s]

    Source: Mohtat et al., appendix B and section 6; Q_Mz = 1e4 and Q_Tf = 0.001 [assumed].
    """
    return RefinedFrictionMonitor(
        joint_filter(
            SmoothFrictionParameters(**dataclasses.asdict(parameters), smoothing_rate=smoothing_rate),
            covariance_update="schmidt",
            initial_friction_variance=25.0,
            estimator=UnscentedFilter,
            model=SmoothFrictionEstimation,
        )
    )


def linearised(parameters: FrictionParameters, **terms: float) -> LinearisedFrictionMonitor:
    """The printed monitor with the terms of eq (19) and a large process noise of the self-aligning torque.

    Args:
        parameters: parameters of the joint model; `vehicle.parameters_for(VariableRatioParameters)` includes the growth
            of the ratio where the vehicle file gives `steering_ratio_growth`
        terms: fields of `VariableRatioParameters`, which replace those of `parameters`
    """
    known = VariableRatioParameters(**{**dataclasses.asdict(parameters), **terms})
    return LinearisedFrictionMonitor(joint_filter(known, model=LinearisedFrictionEstimation))
