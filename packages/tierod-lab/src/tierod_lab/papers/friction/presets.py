"""Readings of the paper's joint filter: as printed, with open noise, consistent, and unscented."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

from tierod.core.errors import ParameterError
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.filters import Butterworth
from tierod.models.steering_column import FrictionParameters
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.friction.joint_model import (
    FrictionEstimation,
    SmoothFrictionEstimation,
    SmoothFrictionParameters,
)
from tierod_lab.papers.friction.refined import FrictionSample, OperatingPoint, RefinedFrictionMonitor, Sticking

VirtualNoise = Literal["scaled by sample time", "per sample"]
CovarianceUpdate = Literal["printed", "schmidt"]


def equal_low_pass(cutoff: float, sample_time: float = 0.01) -> Butterworth:
    """The low-pass for the monitors of six signals where the rate is noisy.

    Args:
        cutoff: cutoff frequency [Hz]; 5 restores the estimate at a rate noise of 0.05 rad/s, see
            docs/explanation/friction.md
        sample_time: dt [s]
    """
    return Butterworth(FrictionSample, sample_time, maximum_gap=0.1, cutoff=cutoff)


def joint_filter(
    parameters: FrictionParameters,
    *,
    input_variance: tuple[float, float, float],
    virtual_variance: tuple[float, float],
    virtual_noise: VirtualNoise,
    covariance_update: CovarianceUpdate,
    initial_friction_variance: float,
    initial_friction: float = 3.0,
    measurement_variance: float = 1e-4,
    estimator: type[KalmanFilter] = KalmanFilter,
    model: Any = FrictionEstimation,
) -> KalmanFilter:
    """The filter of the joint model with Q and R named as in eqs (11) and (12).

    Args:
        input_variance: Q of driver torque [(N m)^2], motor torque [(N m)^2], lateral acceleration [(m/s^2)^2]
        virtual_variance: Q of self-aligning torque and friction torque [(N m)^2]
        virtual_noise: reading of the last two rows of G: "scaled by sample time" (printed, eq 8: dt) or "per sample"
            (1 in place of dt)
        covariance_update: "printed" (Table 3) or "schmidt" (consistent with the enabled gain)
        initial_friction_variance: P_T [(N m)^2], not printed; it decides how fast the estimate leaves its start.
            With the printed covariance values from 0.1 on make no difference: they fade before the gate first opens
        initial_friction: [N m]; 3 as printed
        measurement_variance: variance of angle [rad^2], rate and yaw rate [rad^2/s^2]; 1e-4 as printed
        model: the joint model, linear in its direction or smooth

    The rest of P0 is not printed either: 1e-2 for the motions, 100 (N m)^2 for the self-aligning torque [assumed].
    """
    if virtual_noise not in ("scaled by sample time", "per sample"):
        raise ParameterError(
            f"virtual_noise is '{virtual_noise}'; "
            "expected 'scaled by sample time' (dt in G, as printed) or 'per sample' (1)"
        )
    scale = parameters.sample_time**2 if virtual_noise == "scaled by sample time" else 1.0
    return estimator(
        model=model,
        parameters=parameters,
        initial_mean=(0.0, 0.0, 0.0, 0.0, initial_friction),
        initial_variance=(1e-2, 1e-2, 1e-2, 100.0, initial_friction_variance),
        process_noise=(None, None, None, scale * virtual_variance[0], scale * virtual_variance[1]),
        measurement_noise=(measurement_variance,) * 3,
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
) -> RefinedFrictionMonitor:
    """The monitor as printed: literal Q of eq (11), dt in the virtual rows of G, covariance update of Table 3.

    The self-aligning torque is hardly tracked with it (41 N m root mean square) and friction reads 0.4 to 0.9 N m high.

    Args:
        initial_friction_variance: P_T [(N m)^2]; from 3 N m, 12.5 N m reads 8.0 N m after the printed 50 s of enabled
            time with 1, and 6.5 N m with the steady value of 6e-4 (`tierod study friction`)
        operating_point: see `RefinedFrictionMonitor`, appendix B
        virtual_noise: reading of G; "per sample" tracks the self-aligning torque at the price of more scatter
    """
    return RefinedFrictionMonitor(
        joint_filter(
            parameters,
            input_variance=(0.01, 0.01, 0.1),
            virtual_variance=(1.0, 0.001),
            virtual_noise=virtual_noise,
            covariance_update="printed",
            initial_friction_variance=initial_friction_variance,
        ),
        operating_point=operating_point,
    )


def printed_open(
    parameters: FrictionParameters,
    *,
    initial_friction_variance: float = 1.0,
    operating_point: OperatingPoint = "measurement",
) -> RefinedFrictionMonitor:
    """The printed monitor with Q = 1e4 of the self-aligning torque, so that it is tracked.

    Args:
        initial_friction_variance: P_T [(N m)^2], as in `printed`
        operating_point: see `RefinedFrictionMonitor`, appendix B
    """
    return RefinedFrictionMonitor(
        joint_filter(
            parameters,
            input_variance=(0.01, 0.01, 0.1),
            virtual_variance=(1e4, 0.001),
            virtual_noise="scaled by sample time",
            covariance_update="printed",
            initial_friction_variance=initial_friction_variance,
        ),
        operating_point=operating_point,
    )


def consistent(
    parameters: FrictionParameters,
    *,
    initial_friction_variance: float = 25.0,
    operating_point: OperatingPoint = "measurement",
) -> RefinedFrictionMonitor:
    """The corrected monitor: Schmidt-Joseph covariance, Q = diag(1, 1, 0.1, 1e4, 0.1), sticking.

    Q of the torques is 1 (N m)^2 instead of 0.01, which covers the model error; the standard deviation of the
    self-aligning torque is then 6.5 N m, and the variance of friction is meaningful.

    Args:
        initial_friction_variance: P_T [(N m)^2]; (5 N m)^2 covers every level of the paper, and the estimate has
            converged after 10 s of enabled time
        operating_point: see `RefinedFrictionMonitor`, appendix B
    """
    return RefinedFrictionMonitor(
        joint_filter(
            parameters,
            input_variance=(1.0, 1.0, 0.1),
            virtual_variance=(1e4, 0.1),
            virtual_noise="scaled by sample time",
            covariance_update="schmidt",
            initial_friction_variance=initial_friction_variance,
        ),
        operating_point=operating_point,
        sticking=Sticking(),
    )


def unscented(
    parameters: FrictionParameters,
    *,
    smoothing_rate: float = 0.02,
    initial_friction_variance: float = 25.0,
) -> RefinedFrictionMonitor:
    """The unscented variant that the paper names as future work: friction T_f tanh(rate/eps), consistent covariance.

    In simulation it gains less than 0.2 N m over the consistent Kalman filter. A wider tanh (0.05 rad/s) reads 5 %
    higher, which compensates part of the pre-sliding bias by coincidence.

    Args:
        smoothing_rate: eps, rate at which tanh reaches 76 % [rad/s]
        initial_friction_variance: P_T [(N m)^2], as in `consistent`

    Source: Mohtat et al., appendix B and section 6; Q_Mz = 1e4 and Q_Tf = 0.001 [assumed].
    """
    smooth = SmoothFrictionParameters(**dataclasses.asdict(parameters), smoothing_rate=smoothing_rate)
    return RefinedFrictionMonitor(
        joint_filter(
            smooth,
            input_variance=(0.01, 0.01, 0.1),
            virtual_variance=(1e4, 0.001),
            virtual_noise="scaled by sample time",
            covariance_update="schmidt",
            initial_friction_variance=initial_friction_variance,
            estimator=UnscentedFilter,
            model=SmoothFrictionEstimation,
        )
    )
