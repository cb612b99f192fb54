"""The estimators of Mohtat et al. as variants of the friction monitor; the package registers each of them.

Source: Mohtat et al., Steering friction monitoring by joint state-parameter estimation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tierod.core.graph import Result
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.baseline import Baseline
from tierod.monitors.friction.definition import PAPER, FrictionMonitor, FrictionSession, learnt
from tierod.monitors.friction.verdict import DECISIONS, FrictionVerdict
from tierod.monitors.session import Session, Variant
from tierod.physics.friction import viscous
from tierod.vehicles import Vehicle
from tierod_lab.papers.friction import presets
from tierod_lab.papers.friction.joint_model import driving_torque
from tierod_lab.papers.friction.refined import RefinedFrictionMonitor
from tierod_lab.papers.friction.variance_method import VarianceFrictionMonitor, VarianceGate, VarianceParameters
from tierod_lab.papers.friction.variance_session import VARIANCE_DECISIONS, VarianceSession

EQUATIONS = f"{PAPER}, eqs (5) to (14)"
LIN = f"{PAPER}, eqs (1) and (2), section 4.1, after Lin and Ghoneim"


def _refined(
    name: str, summary: str, source: str, build: Callable[[FrictionParameters], RefinedFrictionMonitor]
) -> Variant:
    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=1.0 / rate)

        def acting(signals: Mapping[str, np.ndarray], result: Result) -> np.ndarray:
            """Remainder of the torque balance of eq (2), inertia torque included."""
            aligning = result["estimate.self_aligning_torque"]
            driving = driving_torque(signals["driver_torque"], signals["motor_torque"], aligning, parameters)
            left: np.ndarray = driving - viscous(signals["steering_wheel_rate"], parameters.column_damping)
            return left

        verdict = FrictionVerdict.of_vehicle(vehicle, 1.0 / rate, *learnt(baseline))
        return FrictionSession(FrictionMonitor(build(parameters), verdict, f"friction, {name}"), vehicle, rate, acting)

    return Variant(name, summary, source, open_, DECISIONS)


def _baseline(name: str, summary: str, gate: VarianceGate | None) -> Variant:
    def open_(vehicle: Vehicle, rate: float, baseline: Any) -> Session:
        # The variance is judged against a threshold: a baseline of friction holds no information on it.
        parameters = replace(vehicle.parameters_for(VarianceParameters), sample_time=1.0 / rate)
        known = vehicle.parameters.get("baseline_variance")
        threshold = known.value if known else math.inf
        block = VarianceFrictionMonitor(parameters, threshold, gate, block_samples=round(rate))
        return VarianceSession(f"friction, {name}", block, rate)

    return Variant(name, summary, LIN, open_, VARIANCE_DECISIONS)


REFINED = _refined(
    "refined",
    "Enabled Kalman filter of motion, self-aligning torque and friction, with the consistent covariance.",
    f"{EQUATIONS}, corrected",
    presets.consistent,
)
REFINED_PRINTED = _refined(
    "refined-printed",
    "The same filter exactly as printed: noise as printed, covariance that ignores the enabling.",
    f"{EQUATIONS} and Table 3",
    presets.printed,
)
REFINED_OPEN = _refined(
    "refined-open",
    "As printed, with more virtual noise of the self-aligning torque, so that the filter tracks it.",
    f"{EQUATIONS}, second reading of Q",
    presets.printed_open,
)
UNSCENTED = _refined(
    "unscented",
    "The same model without linearisation, friction smoothed by tanh.",
    f"{PAPER}, appendix B",
    presets.unscented,
)
BASELINE = _baseline(
    "baseline", "Variance between two self-aligning torques, with the printed conditions.", VarianceGate()
)
BASELINE_UNGATED = _baseline(
    "baseline-ungated", "The same on every sample: the printed conditions rarely hold together.", None
)
