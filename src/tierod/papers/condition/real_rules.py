"""The rules of the paper on recordings of real cars: learnt on the beginning of a recording, at work on the rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.papers.condition.real_recordings import RATE, RealCar
from tierod.papers.condition.rules.actuator_set import actuator_set
from tierod.papers.condition.rules.adaptive_speed import AdaptiveSpeed
from tierod.papers.condition.rules.all_residuals import AllResiduals
from tierod.papers.condition.rules.calibration import ResidualCalibration
from tierod.papers.condition.rules.catalogue import RESIDUALS
from tierod.papers.condition.rules.fit import SETTLING, samples_of
from tierod.papers.condition.rules.parameters import Coefficients, ResidualParameters
from tierod.papers.condition.rules.readings import ResidualThreshold
from tierod.papers.condition.rules.residual_set import residual_set
from tierod.papers.condition.rules.routes import steer_of_rolling
from tierod.papers.condition.rules.rule_monitor import RuleMonitor, rule_monitor

RULES = "rules-discriminating"
MARGIN = 1.5
"""Of a threshold over the largest healthy residual: wider than the paper's, since little healthy driving is known."""
OFFSET_START = 0.5
"""Standard deviation of the accelerometer's offset on roads with 5 % of grade [m/s**2]."""
OFFSET_GROWTH = 0.05
"""And its growth where the grade changes within a few hundred metres [m/s**2 after a second]."""


def parameters_of(car: RealCar) -> ResidualParameters:
    """The car, as far as it is known; what the residuals of the steering's torques would need is left at little.

    Args:
        car: which one
    """
    known = car.known
    names = ("mass", "yaw_inertia", "front_distance", "rear_distance", "steering_ratio", "track_width")
    tyres = ("front_cornering_stiffness", "rear_cornering_stiffness")
    return ResidualParameters(
        **{name: known[name] for name in (*names, *tyres)},
        wheel_radius=0.32,
        column_inertia=0.05,
        rack_stiffness=0.0,
        rack_damping=0.0,
        rack_ratio=0.008,
        nominal_friction=0.0,
    )


def learnt(car: RealCar, recording: Recording) -> RuleMonitor:
    """The rules on a car, its understeer and thresholds from the beginning of the recording.

    Args:
        car: which one
        recording: of it, on one grid
    """
    samples = samples_of(recording)[: round(car.learning * RATE)]
    parameters = parameters_of(car)
    known = _understeer(parameters, samples)
    sensors = residual_set(parameters, known)
    sensors = replace(sensors, speed=_on_slopes(sensors.speed))
    result = scan(AllResiduals(sensors, actuator_set(parameters, known)), samples)
    settled = slice(round(SETTLING * RATE), None)
    thresholds = {}
    for name in RESIDUALS:
        values = result[f"residuals.{name}"][settled][result[f"there.{name}"][settled] > 0.5]
        if len(values):
            centre = float(np.median(values))
            largest = max(float(np.max(np.abs(values - centre))), 1e-3)
            thresholds[name] = ResidualThreshold(MARGIN * largest, centre=centre)
        else:
            thresholds[name] = ResidualThreshold(np.inf)
    calibration = ResidualCalibration(known, thresholds, dict.fromkeys(RESIDUALS, np.nan), len(samples))
    monitor = rule_monitor(parameters, calibration, RULES)
    return replace(monitor, sensors=sensors)


def _on_slopes(speed: AdaptiveSpeed) -> AdaptiveSpeed:
    """The filter of the speed on roads that climb, where gravity is an offset of the accelerometer that changes."""
    known = speed.speed
    variance = (known.initial_variance[0], OFFSET_START**2)
    growth = (known.process_noise[0], OFFSET_GROWTH**2 / RATE)
    return replace(speed, speed=replace(known, initial_variance=variance, process_noise=growth))


def _understeer(parameters: ResidualParameters, samples: np.ndarray) -> Coefficients:
    """Understeer and offset of the steering angle, by least squares on rolling."""
    left, right, yaw, turned = samples[:, :4].T
    rolling = np.array([steer_of_rolling(*each, parameters) for each in zip(yaw, left, right, strict=True)], float)
    regressors = np.column_stack([0.5 * (left + right) * yaw, np.ones(len(samples))])
    found, *_ = np.linalg.lstsq(regressors, parameters.steering_ratio * turned - rolling, rcond=None)
    return replace(Coefficients(), understeer=float(found[0]), angle_offset=float(found[1]) / parameters.steering_ratio)
