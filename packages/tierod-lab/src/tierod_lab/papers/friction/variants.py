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
from tierod.monitors.friction.definition import PAPER, Acting, FrictionMonitor, FrictionSession, Opener, learnt
from tierod.monitors.friction.verdict import DECISIONS, FrictionVerdict
from tierod.monitors.session import Session, Variant
from tierod.physics.friction import viscous
from tierod.vehicles import Vehicle
from tierod_lab.papers.friction.joint_model import driving_torque
from tierod_lab.papers.friction.presets import consistent, printed, printed_open, unscented
from tierod_lab.papers.friction.refined import RefinedFrictionMonitor
from tierod_lab.papers.friction.variance_method import VarianceFrictionMonitor, VarianceGate, VarianceParameters
from tierod_lab.papers.friction.variance_session import VARIANCE_DECISIONS, VarianceSession


def acting_by_balance(parameters: FrictionParameters) -> Acting:
    """Function for the acting friction: the remainder of the torque balance of eq (2), inertia torque included."""

    def acting(signals: Mapping[str, np.ndarray], result: Result) -> np.ndarray:
        aligning = result["estimate.self_aligning_torque"]
        driving = driving_torque(signals["driver_torque"], signals["motor_torque"], aligning, parameters)
        left: np.ndarray = driving - viscous(signals["steering_wheel_rate"], parameters.column_damping)
        return left

    return acting


def _paper(name: str, build: Callable[[Any], RefinedFrictionMonitor]) -> Opener:
    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=1.0 / rate)
        verdict = FrictionVerdict.of_vehicle(vehicle, 1.0 / rate, *learnt(baseline))
        block = FrictionMonitor(build(parameters), verdict, f"friction, {name}")
        return FrictionSession(block, vehicle, rate, acting_by_balance(parameters))

    return open_


def _baseline(name: str, gate: VarianceGate | None) -> Opener:
    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        # The variance is judged against a threshold: a baseline of friction holds no information on it.
        parameters = replace(vehicle.parameters_for(VarianceParameters), sample_time=1.0 / rate)
        known = vehicle.parameters.get("baseline_variance")
        threshold = known.value if known else math.inf
        block = VarianceFrictionMonitor(parameters, threshold, gate, block_samples=round(rate))
        return VarianceSession(f"friction, {name}", block, rate)

    return open_


REFINED = Variant(
    "refined",
    "Enabled Kalman filter of motion, self-aligning torque and friction, with the consistent covariance.",
    f"{PAPER}, eqs (5) to (14), corrected",
    _paper("refined", consistent),
    DECISIONS,
)

REFINED_PRINTED = Variant(
    "refined-printed",
    "The same filter exactly as printed: noise as printed, covariance that ignores the enabling.",
    f"{PAPER}, eqs (5) to (14) and Table 3",
    _paper("refined-printed", printed),
    DECISIONS,
)

REFINED_OPEN = Variant(
    "refined-open",
    "As printed, with more virtual noise of the self-aligning torque, so that the filter tracks it.",
    f"{PAPER}, eqs (5) to (14), second reading of Q",
    _paper("refined-open", printed_open),
    DECISIONS,
)

UNSCENTED = Variant(
    "unscented",
    "The same model without linearisation, friction smoothed by tanh.",
    f"{PAPER}, appendix B",
    _paper("unscented", unscented),
    DECISIONS,
)

BASELINE = Variant(
    "baseline",
    "Variance between two self-aligning torques, with the printed conditions.",
    f"{PAPER}, eqs (1) and (2), section 4.1, after Lin and Ghoneim",
    _baseline("baseline", VarianceGate()),
    VARIANCE_DECISIONS,
)

BASELINE_UNGATED = Variant(
    "baseline-ungated",
    "The same on every sample: the printed conditions rarely hold together.",
    f"{PAPER}, eqs (1) and (2), section 4.1, after Lin and Ghoneim",
    _baseline("baseline-ungated", None),
    VARIANCE_DECISIONS,
)
