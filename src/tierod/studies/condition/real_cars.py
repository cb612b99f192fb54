"""Faults put into recordings of real cars: found, told apart, and silence where nothing was put in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tierod.graph import scan
from tierod.monitors.condition.residuals.actuator_set import actuator_set
from tierod.monitors.condition.residuals.adaptive_speed import AdaptiveSpeed
from tierod.monitors.condition.residuals.all_residuals import AllResiduals
from tierod.monitors.condition.residuals.calibration import ResidualCalibration
from tierod.monitors.condition.residuals.catalogue import RESIDUALS
from tierod.monitors.condition.residuals.fit import SETTLING, samples_of
from tierod.monitors.condition.residuals.parameters import Coefficients
from tierod.monitors.condition.residuals.residual_set import residual_set
from tierod.monitors.condition.residuals.rolling import steer_of_rolling
from tierod.monitors.condition.residuals.thresholds import ResidualThreshold
from tierod.monitors.condition.rule_monitor import RuleMonitor, rule_monitor
from tierod.proving_ground.faults import injected
from tierod.recording import Recording
from tierod.studies.claims import Claim, at_least, exactly
from tierod.studies.condition import tables
from tierod.studies.condition.by_rules import said
from tierod.studies.condition.drives import Drive
from tierod.studies.condition.faults import LOSS, OFFSET, OFFSETS, OUTLIER, OUTLIER_FACTOR, Injected
from tierod.studies.condition.real_recordings import CARS, DATA, RATE, SENSORS, RealCar
from tierod.studies.condition.runs import VARIANTS
from tierod.studies.condition.scoring import DriveScore, score
from tierod.studies.condition.sensors import GOAL
from tierod.studies.condition.summary import isolated, summary
from tierod.studies.condition.truth import Truth
from tierod.studies.content import Heading, Item, Table
from tierod.studies.registry import Effort

RULES = "rules-discriminating"
MARGIN = 1.5
"""Of a threshold over the largest healthy residual: wider than the paper's, since little healthy driving is known."""
OFFSET_START = 0.5
"""Standard deviation of the accelerometer's offset on roads with 5 % of grade [m/s**2]."""
OFFSET_GROWTH = 0.05
"""And its growth where the grade changes within a few hundred metres [m/s**2 after a second]."""
TEXT = (
    "A minute of a RAV4 on a highway and 20 s of a passenger car in tight bends, with the sensors that both have: "
    "rear wheel speeds, yaw rate, steering angle, accelerations (those of the passenger car from its front wheels). "
    "What needs torques or the tie-rod force is not there. Understeer and thresholds are learnt from the beginning; "
    "then each sensor fails at three instants: lost, with an offset of the tests' size and either sign, and an "
    "outlier of a second.",
)


def items(effort: Effort) -> Iterator[Item]:
    """Faults found and told apart in both recordings."""
    if RULES not in VARIANTS:
        return
    yield Heading("Real cars", TEXT)
    rows, claims = [], []
    for car in CARS:
        recording = car.recording()
        if recording is None:
            note = f"The recording is not here; name the folder that holds it with {DATA}."
            claims.append(Claim(f"cars.{car.vehicle}", f"Faults in a {car.name}.", GOAL, None, None, None, "", note))
            continue
        quiet, found = judged(car, recording, effort.quick)
        known, told = summary(found), isolated(found)
        alarms = quiet.false_alarms
        rows.append(
            (
                car.name,
                str(len(found)),
                str(known.missed),
                str(known.not_testable),
                f"{told.right:.3f}",
                f"{told.ambiguous:.3f}",
                f"{known.wrong:.3f}",
                f"{np.median(known.delays_shown) if len(known.delays_shown) else np.nan:.2f}",
                str(alarms),
            )
        )
        yield tables.named(f"What went by which name: {car.name}", found)
        claims += _claims(car, quiet, found)
    header = ("car", "faults", "missed", "never showed", "named rightly", "ambiguous", "time wrong", "median delay [s]")
    if rows:
        note = "The last column counts declarations after the learning in the recording as it was made."
        yield Table("Faults put into recordings of real cars", (*header, "false alarms"), tuple(rows), note)
    yield from claims


def _claims(car: RealCar, quiet: DriveScore, found: list[DriveScore]) -> list[Claim]:
    known, told = summary(found), isolated(found)
    return [
        Claim(f"cars.{car.vehicle}-{key}", f"{claim}, {car.name}.", GOAL, None, measured, goal)
        for key, claim, measured, goal in (
            ("missed", "Injected faults missed", known.missed, exactly(0.0)),
            ("named", "Injected faults named and nothing else", told.right, at_least(0.9)),
            ("wrong", "Time of the faults with a sound sensor named", known.wrong, exactly(0.0)),
            ("alarms", "False alarms where nothing was injected", quiet.false_alarms, exactly(0.0)),
        )
    ]


def judged(car: RealCar, recording: Recording, quick: bool = False) -> tuple[DriveScore, list[DriveScore]]:
    """Scores of the recording as it is, after the learning, and with every injected fault.

    Args:
        car: whose recording it is
        recording: on one grid
        quick: whether one instant of each fault has to do
    """
    monitor = learnt(car, recording)
    quiet = _scored(car, recording, monitor, ())
    starts = car.starts[:1] if quick else car.starts
    faults = [each for start in starts for sensor in SENSORS for each in _faults(sensor, start, car.lasting)]
    return quiet, [_scored(car, recording, monitor, (each,)) for each in faults]


def _faults(sensor: str, start: float, lasting: float) -> tuple[Injected, ...]:
    end, size = start + lasting, OFFSETS[sensor]
    return (
        Injected(sensor, LOSS, start=start, end=end),
        Injected(sensor, OFFSET, size, start, end),
        Injected(sensor, OFFSET, -size, start, end),
        Injected(sensor, OUTLIER, OUTLIER_FACTOR, start, start + 1.0),
    )


def _scored(car: RealCar, sound: Recording, monitor: RuleMonitor, faults: tuple[Injected, ...]) -> DriveScore:
    """What the rules say after the learning; the recording before the fault is the truth."""
    made = injected(sound, [each.fault for each in faults]) if faults else sound
    declared = said(monitor, made)
    judged_from = np.searchsorted(declared.time, declared.time[0] + car.learning)
    off = {each.element: made[each.element].values - sound[each.element].values for each in faults}
    drive = Drive(car.name, float(declared.time[-1]), 0, 0, faults)
    cut = {name: {key: each[judged_from:] for key, each in getattr(declared, name).items()} for name in _CUT}
    truth = Truth(
        {name: each[judged_from:] for name, each in off.items()},
        {name: sound[name].values[judged_from:] for name in off},
        {},
    )
    return score(drive, truth, declared._replace(time=declared.time[judged_from:], **cut))


_CUT = ("faulty", "candidates", "not_testable", "value")


def learnt(car: RealCar, recording: Recording) -> RuleMonitor:
    """The rules on a car, its understeer and thresholds from the beginning of the recording.

    Args:
        car: which one
        recording: of it, on one grid
    """
    samples = samples_of(recording)[: round(car.learning * RATE)]
    known = _understeer(car, samples)
    parameters = car.parameters
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


def _understeer(car: RealCar, samples: np.ndarray) -> Coefficients:
    """Understeer and offset of the steering angle, by least squares on rolling."""
    left, right, yaw, turned = samples[:, :4].T
    parameters = car.parameters
    rolling = np.array([steer_of_rolling(*each, parameters) for each in zip(yaw, left, right, strict=True)], float)
    regressors = np.column_stack([0.5 * (left + right) * yaw, np.ones(len(samples))])
    found, *_ = np.linalg.lstsq(regressors, parameters.steering_ratio * turned - rolling, rcond=None)
    return replace(Coefficients(), understeer=float(found[0]), angle_offset=float(found[1]) / parameters.steering_ratio)
