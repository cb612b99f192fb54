"""The estimators that the study compares, by name; all assume the parameters of one vehicle file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from typing import Any

from tierod.models.steering_column import FrictionParameters
from tierod.monitors.friction.definition import FrictionMonitor
from tierod.monitors.friction.estimator import DEVIATIONS, PROCESS, PreslidingFrictionFilter, PreslidingTuning
from tierod.monitors.friction.signals import AngleObserver, SteeringConditioning
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.friction.linearised import linearised
from tierod_lab.papers.friction.presets import consistent, equal_low_pass, printed, printed_open, unscented
from tierod_lab.papers.friction.refined import RefinedFrictionMonitor
from tierod_lab.papers.friction.variance_method import VarianceFrictionMonitor, VarianceGate, VarianceParameters

VEHICLE = "midsize-eps"
GRAVITY = 9.81
RATIO_GROWTH = 0.06
"""Growth of the steering ratio with the squared angle that estimators with a variable ratio assume [1/rad**2]."""

DEFAULT = "default"  # tierod's own estimator, with its verdict
PRINTED = "paper, printed"
POSTERIOR = "paper, printed, operating point estimated"
PER_SAMPLE = "paper, printed, virtual rows of G one"
PNEUMATIC = "paper, printed, rows of G one, pneumatic trail alone"
OPEN = "paper, printed, aligning torque open"
CORRECTED = "paper, corrected"
UNSCENTED = "paper, unscented"
RATIO = "paper, variable ratio"
RATIO_SLOPE = "paper, variable ratio and its slope"
ALL_TERMS = "paper, all terms of eq (19)"
PRINTED_SMOOTH = "paper, printed, 5 Hz low-pass"
CORRECTED_SMOOTH = "paper, corrected, 5 Hz low-pass"
SINGLE_LAW = "single-law estimator"

ONE_LAW = "default, one law in place of three"
NO_LOAD = "default, no load share"
NO_DROP = "default, no trail drop"
RIGID = "default, the bar taken as rigid"
NO_ROAD = "default, no weight, turn slip or drive force"
ROAD = ("weight_lever", "turn_slip", "drive_share")
"""Coefficients of the road's torques on the steered wheels beside the self-aligning torque."""

OF_VARIANCE = {variance: f"paper, printed, P0 {variance:g}" for variance in (6e-4, 1e-2, 0.1, 1.0, 25.0)}
"""Initial variance P0 of friction [(N*m)**2] -> name of the printed filter; 6e-4 is its steady-state variance."""

BASELINE = "baseline"
BASELINE_SIGN = "baseline, printed sign"
BASELINE_GATED = "baseline, printed gate"
BASELINE_IN_G = "baseline, printed gate in g"


@cache
def vehicle() -> Vehicle:
    """Vehicle file that every estimator of the study assumes, whatever car is driven."""
    return load(VEHICLE)


def _parameters() -> FrictionParameters:
    return vehicle().parameters_for(FrictionParameters)


def _with_pneumatic_trail() -> FrictionParameters:
    """Parameters with the pneumatic trail alone, as the paper words it: half of the trail that acts."""
    return replace(_parameters(), trail=0.5 * _parameters().trail)


def without(
    *coefficients: str, cutoff: float = 12.0, half_width: float = 0.0, rigid: bool = False
) -> PreslidingFrictionFilter:
    """The default estimator without some of its learnt coefficients, or with another conditioning.

    Args:
        coefficients: names in `Coefficients` that stay zero
        cutoff: cutoff frequency of the low-pass before the friction law [Hz]
        half_width: half width of the play in the angle [rad]
        rigid: whether the torsion bar is taken as rigid
    """
    none = dict.fromkeys(coefficients, 0.0)
    starts = {f"initial_{name}": 0.0 for name in coefficients if name in ROAD}
    tuning = PreslidingTuning(process=PROCESS._replace(**none), deviations=DEVIATIONS._replace(**none), **starts)
    conditioning = SteeringConditioning(cutoff=cutoff, angle=AngleObserver(half_width=half_width))
    parameters = replace(_parameters(), torsion_bar_stiffness=math.inf) if rigid else _parameters()
    return PreslidingFrictionFilter(parameters, tuning, conditioning)


def _single_law() -> PreslidingFrictionFilter:
    """Predecessor of the default estimator: one exponential law behind a low-pass of 5 Hz and a play, rigid bar."""
    left_out = ("finite", "long", "trail_drop", "load_share", *ROAD)
    # 49 Hz is just below the Nyquist frequency: this estimator had no low-pass behind the friction law.
    return replace(without(*left_out, cutoff=5.0, half_width=3e-4, rigid=True), regressor_cutoff=49.0)


def monitor(level: tuple[float, float] | None = None) -> FrictionMonitor:
    """The default estimator with its verdict.

    Args:
        level: baseline of the car from an earlier drive and its standard deviation [N*m]; None learns it
    """
    return FrictionMonitor.of_vehicle(vehicle(), 0.01, *(level or (None, 0.0)))


def _of_variance(variance: float) -> RefinedFrictionMonitor:
    """The printed filter with an initial variance of friction [(N*m)**2]."""
    return printed(_parameters(), initial_friction_variance=variance)


def _with_terms(ratio_slope: float, sign_slope: float) -> RefinedFrictionMonitor:
    """The printed filter with a variable ratio; the terms of eq (19) are on (1) or off (0)."""
    return linearised(
        _parameters(), steering_ratio_growth=RATIO_GROWTH, with_ratio_slope=ratio_slope, with_sign_slope=sign_slope
    )


def _baseline(gate: VarianceGate | None = None, literal_sign: bool = False) -> VarianceFrictionMonitor:
    parameters = vehicle().parameters_for(VarianceParameters)
    return VarianceFrictionMonitor(parameters, math.inf, gate=gate, literal_sign=literal_sign)


def _gate_in_g() -> VarianceGate:
    """The printed gate with its limits of lateral acceleration in g: in m/s^2, as printed, it hardly ever opens."""
    return VarianceGate(minimum_acceleration=0.1 * GRAVITY, maximum_acceleration=0.5 * GRAVITY)


ESTIMATORS: Mapping[str, Callable[[], Any]] = {
    PRINTED: lambda: printed(_parameters()),
    POSTERIOR: lambda: printed(_parameters(), operating_point="estimate"),
    PER_SAMPLE: lambda: printed(_parameters(), virtual_noise="per sample"),
    PNEUMATIC: lambda: printed(_with_pneumatic_trail(), virtual_noise="per sample"),
    OPEN: lambda: printed_open(_parameters()),
    CORRECTED: lambda: consistent(_parameters()),
    UNSCENTED: lambda: unscented(_parameters()),
    RATIO: lambda: _with_terms(0.0, 0.0),
    RATIO_SLOPE: lambda: _with_terms(1.0, 0.0),
    ALL_TERMS: lambda: _with_terms(1.0, 1.0),
    **{name: partial(_of_variance, variance) for variance, name in OF_VARIANCE.items()},
    PRINTED_SMOOTH: lambda: replace(printed(_parameters()), low_pass=equal_low_pass(5.0)),
    CORRECTED_SMOOTH: lambda: replace(consistent(_parameters()), low_pass=equal_low_pass(5.0)),
    SINGLE_LAW: _single_law,
    ONE_LAW: lambda: without("finite", "long"),
    NO_LOAD: lambda: without("load_share"),
    NO_DROP: lambda: without("trail_drop"),
    RIGID: lambda: without(rigid=True),
    NO_ROAD: lambda: without(*ROAD),
}
"""Name -> maker of a block with outputs `friction_torque` and `enabled`; for `DEFAULT` see `monitor`."""

BASELINES: Mapping[str, Callable[[], VarianceFrictionMonitor]] = {
    BASELINE: _baseline,
    BASELINE_SIGN: lambda: _baseline(literal_sign=True),
    BASELINE_GATED: lambda: _baseline(VarianceGate()),
    BASELINE_IN_G: lambda: _baseline(_gate_in_g()),
}
"""Name -> maker of a form of the baseline monitor, whose feature is a variance over 15 s."""
