"""The diagnoses of the study on real cars: the bank of filters, and the paper's rules."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.core.graph import Bank, scan
from tierod.core.recording import Recording
from tierod.monitors.condition.definition import rolling_monitor
from tierod.monitors.condition.limits import Watching, lasting, sampled, unreachable
from tierod.monitors.condition.rolling_filter import RollingFilter
from tierod.monitors.condition.signals import ALL_WHEELS, hypotheses_of_cars
from tierod_lab.papers.condition.by_bank import declared_of
from tierod_lab.papers.condition.real_recordings import RATE, SENSORS, RealCar
from tierod_lab.papers.condition.rules.actuator_set import actuator_set
from tierod_lab.papers.condition.rules.adaptive_speed import AdaptiveSpeed
from tierod_lab.papers.condition.rules.all_residuals import AllResiduals
from tierod_lab.papers.condition.rules.calibration import ResidualCalibration
from tierod_lab.papers.condition.rules.fit import SETTLING, samples_of
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, Coefficients, ResidualParameters
from tierod_lab.papers.condition.rules.readings import ResidualThreshold
from tierod_lab.papers.condition.rules.residual_set import residual_set
from tierod_lab.papers.condition.rules.routes import steer_of_rolling
from tierod_lab.papers.condition.rules.rule_monitor import RuleMonitor, rule_monitor
from tierod_lab.papers.condition.truth import Declared

SETTLED = 2.0  # Warm-up at the start of a recording, which is not used [s]


def said(bank: Bank, recording: Recording) -> Declared:
    """Declarations of the bank over a recording.

    Args:
        recording: recording, with or without injected faults
    """
    samples = sampled(recording)
    return declared_of(scan(bank, samples.values), samples.time)


def accuracy(car: RealCar, recording: Recording) -> dict[str, float]:
    """Accuracy with which the other sensors of a car estimate each reading [unit of the sensor].

    It is the root mean square error of the filter that leaves the sensor out, on the learning part of the recording.
    """
    samples, base = sampled(recording), RollingFilter.of_vehicle(car.known)
    found = {}
    for each in hypotheses_of_cars():
        if len(each.sensors) == 1:
            (name,) = each.sensors
            reading = samples.values[:, samples.names.index(name)]
            error = reading - scan(base.leaving_out(each), samples.values)[f"prediction.{name}"]
            since = samples.time - samples.time[0]
            looked_at = (since >= SETTLED) & (since < car.learning) & np.isfinite(error)
            found[name] = float(np.sqrt(np.mean(error[looked_at] ** 2)))
    return {name: found[name] for name in SENSORS}


def healthy_ratios(car: RealCar, recording: Recording, start: float, stop: float) -> tuple[float, float, float]:
    """Largest log-likelihood ratios in a part of a fault-free recording [nat].

    Three values: of the short mean, for hypotheses with and without wheels; of the long mean, for any hypothesis.

    Args:
        start, stop: bounds of the part, from the start of the recording [s]
    """
    explanations = hypotheses_of_cars()
    count = len(explanations) - 1
    bank = rolling_monitor(car.known, unreachable(explanations))
    ratios = scan(replace(bank, judge=Watching(bank.judge.decision)), sampled(recording).values).values
    largest = lasting(ratios[round(start * RATE) : round(stop * RATE)]).max(axis=0)
    # The short means of all hypotheses come first, then the long ones, each with the fault-free hypothesis in front.
    fast, slow = largest[1 : count + 1], largest[count + 2 :]
    wheels = np.array([any(name in ALL_WHEELS for name in each.sensors) for each in explanations[1:]])
    return float(fast[wheels].max()), float(fast[~wheels].max()), float(slow.max())


RULES = "rules-discriminating"
MARGIN = 1.5
"""Ratio of a threshold to the largest fault-free residual [-]: larger than the paper's, as there is little data."""
OFFSET_START = 0.5  # Standard deviation of the accelerometer's offset on roads with 5 % of grade [m/s**2]
OFFSET_GROWTH = 0.05
"""Random walk of that offset where the grade changes within a few hundred metres [m/s**2 after a second]."""


def parameters_of(car: RealCar) -> ResidualParameters:
    """Known parameters of a car; those that only the residuals of the steering torques need are placeholders."""
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
    """The rules for a car, with understeer and thresholds from the learning part of its recording.

    Args:
        recording: its recording on one time grid, see `on_grid`
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
            # A residual that hardly moves on the learning part would get a threshold of zero.
            largest = max(float(np.max(np.abs(values - centre))), 1e-3)
            thresholds[name] = ResidualThreshold(MARGIN * largest, centre=centre)
        else:
            thresholds[name] = ResidualThreshold(np.inf)
    calibration = ResidualCalibration(known, thresholds, dict.fromkeys(RESIDUALS, np.nan), len(samples))
    monitor = rule_monitor(parameters, calibration, RULES)
    return replace(monitor, sensors=sensors)


def _on_slopes(speed: AdaptiveSpeed) -> AdaptiveSpeed:
    """The filter of the speed for roads with grade, where gravity acts as a varying offset of the accelerometer."""
    known = speed.speed
    variance = (known.initial_variance[0], OFFSET_START**2)
    growth = (known.process_noise[0], OFFSET_GROWTH**2 / RATE)
    return replace(speed, speed=replace(known, initial_variance=variance, process_noise=growth))


def _understeer(parameters: ResidualParameters, samples: np.ndarray) -> Coefficients:
    """Understeer and offset of the steering angle, by least squares against the steer angle of rolling without slip."""
    left, right, yaw, turned = samples[:, :4].T
    rolling = np.array([steer_of_rolling(*each, parameters) for each in zip(yaw, left, right, strict=True)], float)
    regressors = np.column_stack([0.5 * (left + right) * yaw, np.ones(len(samples))])
    found, *_ = np.linalg.lstsq(regressors, parameters.steering_ratio * turned - rolling, rcond=None)
    return replace(Coefficients(), understeer=float(found[0]), angle_offset=float(found[1]) / parameters.steering_ratio)
