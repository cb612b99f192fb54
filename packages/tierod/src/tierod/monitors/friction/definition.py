"""The friction monitor and its variants.

From `tierod diagnose` to the verdict in eight files:

1. `cli/diagnose.py` reads the options.
2. `monitors/diagnose.py` finds the monitor and feeds it piece by piece.
3. `monitors/harness/run.py` puts every piece on one grid, without stuck signals, and makes the report.
4. `monitors/friction/definition.py`, this file, opens a variant for a vehicle.
5. `monitors/friction/monitor.py`: the block, which is estimator and verdict, and the session that collects.
6. `monitors/friction/presliding.py`, or `refined.py`, estimates friction.
7. `monitors/friction/verdict.py` states what that means: status, since when, why none, and the figures behind it.
8. `monitors/friction/finding.py` puts the last statement into words.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.decisions import DECISIONS, TUNING, VARIANCE_DECISIONS
from tierod.monitors.friction.monitor import (
    FrictionMonitor,
    FrictionSession,
    acting_by_balance,
    acting_by_build_up,
)
from tierod.monitors.friction.presets import consistent, printed, printed_open, unscented
from tierod.monitors.friction.refined import RefinedFrictionMonitor
from tierod.monitors.friction.variance_method import VarianceFrictionMonitor, VarianceGate, VarianceParameters
from tierod.monitors.friction.variance_session import VarianceSession
from tierod.monitors.friction.verdict import FrictionVerdict
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Session, Variant
from tierod.vehicles import Vehicle

PAPER = "Mohtat et al., Steering friction monitoring by joint state-parameter estimation"

Opener = Callable[[Vehicle, float, Baseline | None], Session]

_WIDE = (
    "This estimator allows for errors of its torque balance that last half a second, and so expects a large variance: "
    "a mean NIS far below 1 is normal. A NIS near or above 1 means that the balance does not fit the car."
)


def _presliding(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
    block = FrictionMonitor.of_vehicle(vehicle, 1.0 / rate, *_learnt(baseline))
    return FrictionSession(block, vehicle, rate, acting_by_build_up, _WIDE)


def _learnt(baseline: Baseline | None) -> tuple[float | None, float]:
    """Level and standard deviation of the baseline from earlier recordings [N*m]."""
    return (baseline.value, baseline.deviation) if baseline else (None, 0.0)


def _paper(name: str, build: Callable[[Any], RefinedFrictionMonitor]) -> Opener:
    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=1.0 / rate)
        verdict = FrictionVerdict.of_vehicle(vehicle, 1.0 / rate, *_learnt(baseline))
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


_VARIANTS = (
    Variant(
        "pre-sliding",
        "Regression that also learns the angle over which friction builds up, so that pre-sliding causes no bias.",
        f"beyond {PAPER}; docs/explanation/friction.md",
        _presliding,
        DECISIONS,
    ),
    Variant(
        "refined",
        "Enabled Kalman filter of motion, self-aligning torque and friction, with the consistent covariance.",
        f"{PAPER}, eqs (5) to (14), corrected",
        _paper("refined", consistent),
        DECISIONS,
    ),
    Variant(
        "refined-printed",
        "The same filter exactly as printed: noise as printed, covariance that ignores the enabling.",
        f"{PAPER}, eqs (5) to (14) and Table 3",
        _paper("refined-printed", printed),
        DECISIONS,
    ),
    Variant(
        "refined-open",
        "As printed, with more virtual noise of the self-aligning torque, so that the filter tracks it.",
        f"{PAPER}, eqs (5) to (14), second reading of Q",
        _paper("refined-open", printed_open),
        DECISIONS,
    ),
    Variant(
        "unscented",
        "The same model without linearisation, friction smoothed by tanh.",
        f"{PAPER}, appendix B",
        _paper("unscented", unscented),
        DECISIONS,
    ),
    Variant(
        "baseline",
        "Variance between two self-aligning torques, with the printed conditions.",
        f"{PAPER}, eqs (1) and (2), section 4.1, after Lin and Ghoneim",
        _baseline("baseline", VarianceGate()),
        VARIANCE_DECISIONS,
    ),
    Variant(
        "baseline-ungated",
        "The same on every sample: the printed conditions rarely hold together.",
        f"{PAPER}, eqs (1) and (2), section 4.1, after Lin and Ghoneim",
        _baseline("baseline-ungated", None),
        VARIANCE_DECISIONS,
    ),
)

FRICTION = Monitor(
    name="friction",
    title="Friction of the steering",
    summary="Detects and quantifies rising dry friction of column, gear and rack in natural driving.",
    source=PAPER,
    drive=f"Bends to both sides, steered by hand on city or country roads: {TUNING.ready_time:g} s in which driver and "
    "motor turn the wheel together, some three minutes of mixed driving; a baseline needs some six minutes.",
    required=(
        "steering_wheel_angle",
        "steering_wheel_rate",
        "driver_torque",
        "motor_torque",
        "yaw_rate",
        "lateral_acceleration",
        "vehicle_speed",
    ),
    optional=(),
    rate=100.0,
    minimum_rate=20.0,
    maximum_age=0.1,
    variants={variant.name: variant for variant in _VARIANTS},
    default="pre-sliding",
    learns=True,
    # After a step of friction the torque balance does not fit for up to 57 s (verdict_tuning).
    reaction=60.0,
)
