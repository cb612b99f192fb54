"""The filter of the joint friction model, and the low-pass before it."""

from __future__ import annotations

from typing import Any, Literal

from tierod.core.errors import ParameterError
from tierod.methods.estimators.gaussian import GaussianFilter
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.filters.butterworth import Butterworth
from tierod.models.friction_estimation import FrictionEstimation, FrictionParameters
from tierod.monitors.friction.refined_signals import FrictionSample

VirtualNoise = Literal["scaled by sample time", "per sample"]
CovarianceUpdate = Literal["printed", "schmidt"]


def equal_low_pass(cutoff: float, sample_time: float = 0.01) -> Butterworth:
    """The low-pass that the monitors of six signals take where the rate is noisy.

    Args:
        cutoff: 5 Hz restores the estimate at a rate noise of 0.05 rad/s, see docs/explanation/friction.md [Hz]
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
    estimator: type[GaussianFilter] = KalmanFilter,
    model: Any = FrictionEstimation,
) -> GaussianFilter:
    """The filter of the joint model with Q and R named as in eqs (11) and (12).

    Args:
        parameters: of the joint model
        input_variance: Q of driver torque [(N m)^2], motor torque [(N m)^2], lateral acceleration [(m/s^2)^2]
        virtual_variance: Q of self-aligning torque and friction torque [(N m)^2]
        virtual_noise: reading of the last two rows of G: "scaled by sample time" (printed, eq 8: dt) or "per sample"
            (1 in place of dt)
        covariance_update: "printed" (Table 3) or "schmidt" (consistent with the enabled gain)
        initial_friction_variance: P_T [(N m)^2], not printed; it decides how fast the estimate leaves its start.
            With the printed covariance it is forgotten before the gate first opens, whatever it was
        initial_friction: [N m]; 3 as printed
        measurement_variance: of angle [rad^2], rate and yaw rate [rad^2/s^2]; 1e-4 as printed
        estimator: kind of filter
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
        input_noise=(*input_variance, None),
        maskable=("friction_torque",),
        covariance_update=covariance_update,
        hold_missing_input=False,
    )
