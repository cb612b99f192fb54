"""Drives and estimators of the study of friction accuracy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tierod.block import leaves, skeleton
from tierod.errors import ParameterError, nearest
from tierod.graph import scan
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.conditioning import AngleObserver, SteeringConditioning
from tierod.monitors.friction.monitor import FrictionMonitor
from tierod.monitors.friction.presliding import PreslidingFrictionFilter
from tierod.monitors.friction.presliding_tuning import DEVIATIONS, PROCESS, PreslidingTuning
from tierod.monitors.friction.refined import consistent, printed
from tierod.proving_ground import EpsCar, FrictionCourse, Scatter, SensorNoise, drive
from tierod.recording import Aligned, Recording
from tierod.studies.unknown_friction import LoadedCar, StribeckCar
from tierod.vehicles import load

VEHICLE = "midsize-eps"
"""The vehicle file that every estimator of the study believes in."""

RATE = 100.0
READY_SECONDS = 50.0
"""Enabled time before an estimate counts [s]: as printed by Mohtat et al., section 5."""

CARS: Mapping[str, Any] = {
    "Dahl": EpsCar,
    "Dahl, exponent 0.5": EpsCar,
    "Dahl, exponent 2": EpsCar,
    "Stribeck 20 %": StribeckCar,
    "load-dependent 40 %": LoadedCar,
}
_EXPONENTS = {"Dahl, exponent 0.5": 0.5, "Dahl, exponent 2": 2.0}

SCATTERS: Mapping[str, Scatter | bool] = {
    "none": False,
    "usual": Scatter(),
    "hard": Scatter(tyre_stiffness=0.1, mass=0.08, torque_delay=0.05),
}
"""Spreads of car and sensors: as between cars of one type, and a harder form with late torques. Tyres
scatter by 0.1 there: 0.2 makes one car in twelve oversteer and spin on the motorway."""


@dataclass(frozen=True)
class Case:
    """One drive.

    Args:
        seed: of all chance
        level: of friction [N*m], before the change if there is one
        changed_level: level from half-time on [N*m]; None for no change
        dahl_angle: of the friction [rad]; 0.01 degrees is Coulomb friction
        law: of the friction, a name in `CARS`
        rate_noise: of the steering wheel rate [rad/s]
        scatter: how widely car and sensors are drawn at random, a name in `SCATTERS`
        minutes: duration [min]
    """

    seed: int
    level: float = 4.0
    changed_level: float | None = None
    dahl_angle: float = math.radians(1.0)
    law: str = "Dahl"
    rate_noise: float = 0.01
    scatter: str = "none"
    minutes: float = 13.0

    def recording(self) -> Recording:
        """The drive as sensors see it."""
        if self.law not in CARS:
            raise ParameterError(f"'{self.law}' is not a friction law of this study{nearest(self.law, CARS)}")
        car = CARS[self.law]()
        exponent = _EXPONENTS.get(self.law, 1.0)
        car = replace(car, steering=replace(car.steering, dahl_angle=self.dahl_angle, dahl_exponent=exponent))
        sensors = SensorNoise()
        sensors = replace(sensors, steering_wheel_rate=replace(sensors.steering_wheel_rate, noise=self.rate_noise))
        course: FrictionCourse | float = self.level
        if self.changed_level is not None:
            course = FrictionCourse.step(self.level, self.changed_level, at=30.0 * self.minutes)
        return drive(car, self.minutes, course, seed=self.seed, scatter=SCATTERS[self.scatter], noise=sensors)


def parameters() -> FrictionParameters:
    """What the estimators believe of the car."""
    return load(VEHICLE).parameters_for(FrictionParameters)


def default_monitor() -> FrictionMonitor:
    """The default estimator with its verdict."""
    return FrictionMonitor.of_vehicle(load(VEHICLE))


def single_law_filter() -> PreslidingFrictionFilter:
    """What the default estimator grew from: one exponential law, 5 Hz before it, a play, six coefficients."""
    tried = without("finite", "long", "trail_drop", "load_share", cutoff=5.0, half_width=3e-4)
    return replace(tried, regressor_cutoff=0.49 * RATE)


ESTIMATORS: dict[str, Any] = {
    "default": lambda: PreslidingFrictionFilter.of_vehicle(load(VEHICLE)),
    "single-law estimator": single_law_filter,
    "paper, corrected": lambda: consistent(parameters()),
    "paper, printed": lambda: printed(parameters()),
}
"""Estimators that the study compares: name -> block with outputs `friction_torque` and `enabled`."""


def without(*coefficients: str, cutoff: float = 12.0, half_width: float = 0.0) -> PreslidingFrictionFilter:
    """The default estimator with some coefficients fixed at their priors, or with another conditioning.

    Args:
        coefficients: names in `Coefficients` that are not learnt
        cutoff: of the low-pass before the law [Hz]
        half_width: of the play [rad]
    """
    fixed = dict.fromkeys(coefficients, 0.0)
    tuning = PreslidingTuning(process=PROCESS._replace(**fixed), deviations=DEVIATIONS._replace(**fixed))
    conditioning = SteeringConditioning(cutoff=cutoff, angle=AngleObserver(half_width=half_width))
    return PreslidingFrictionFilter(parameters(), tuning, conditioning)


VARIANTS: dict[str, Any] = {
    "one law in place of three": lambda: without("finite", "long"),
    "no load share": lambda: without("load_share"),
    "no trail drop": lambda: without("trail_drop"),
    "5 Hz before the law": lambda: without(cutoff=5.0),
    "play of 3e-4 rad": lambda: without(half_width=3e-4),
}
"""The default estimator with one of its changes to the single-law estimator taken back."""


def samples_for(block: Any, recording: Recording) -> Aligned:
    """The signals of a block on its time grid."""
    return recording.align([name for name, _ in leaves(skeleton(block.Sample))], RATE)


def settled_estimates(case: Case, estimators: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Estimates after the ready time, one array per estimator; run by worker processes."""
    recording, values = case.recording(), {}
    for name in estimators:
        block = (ESTIMATORS | VARIANTS)[name]()
        result = scan(block, samples_for(block, recording))
        enabled = np.cumsum(result["enabled"]) / RATE
        values[name] = result["friction_torque"][enabled > READY_SECONDS]
    return values


@dataclass(frozen=True)
class VerdictOfCase:
    """What the default monitor said over one drive.

    Args:
        codes: every code it gave after it was ready
        ratios: smallest and largest ratio to the own level while it was judged
        delay: enabled time from the change to "rising" and to "fault" [s], infinite where it never came
        early: whether there was an alarm before the change
        last: estimate at the end [N*m]
        seconds: duration [s]
    """

    codes: frozenset[int]
    ratios: tuple[float, float]
    delay: tuple[float, float]
    early: bool
    last: float
    seconds: float


def verdict_of(case: Case) -> VerdictOfCase:
    """The default monitor over one drive; run by worker processes."""
    monitor = default_monitor()
    result = scan(monitor, samples_for(monitor, case.recording()))
    code, ratio = result["verdict.code"], result["verdict.ratio"]
    enabled = np.cumsum(result["estimate.enabled"]) / RATE
    change = len(code) // 2 if case.changed_level is not None else len(code)
    ready = code >= 2.0
    delays = []
    for wanted in (3.0, 4.0):
        alarms = np.flatnonzero(code[change:] >= wanted)
        delays.append(float(enabled[change + alarms[0]] - enabled[change]) if len(alarms) else math.inf)
    return VerdictOfCase(
        frozenset(int(c) for c in np.unique(code[ready])),
        (float(ratio[ready].min()), float(ratio[ready].max())) if ready.any() else (math.nan, math.nan),
        (delays[0], delays[1]),
        bool((code[:change] >= 3.0).any()),
        float(result["estimate.friction_torque"][-1]),
        len(code) / RATE,
    )
