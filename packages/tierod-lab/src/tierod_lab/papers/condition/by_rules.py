"""The rules of the paper as diagnoses of the study: printed, corrected, and with further rules that isolate faults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.vehicles import load
from tierod_lab.papers.condition.by_bank import declared_of
from tierod_lab.papers.condition.recorded import calibration_set
from tierod_lab.papers.condition.rules.calibration import ResidualCalibration, calibrate_residuals
from tierod_lab.papers.condition.rules.fit import samples_of
from tierod_lab.papers.condition.rules.parameters import ResidualParameters
from tierod_lab.papers.condition.rules.rule_monitor import RuleMonitor, rule_monitor
from tierod_lab.papers.condition.truth import NOTHING, Declared

PRINTED = "rules-printed"  # Variant whose equations keep their misprints


@dataclass
class Known:
    """Calibrated rules, which each process builds on first use, since blocks are not pickled."""

    car: ResidualParameters  # parameters of the vehicle file
    calibrations: Mapping[bool, ResidualCalibration]  # calibration, by whether the misprints are kept
    _monitors: dict[str, RuleMonitor] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_monitors": {}}

    def monitor(self, name: str) -> RuleMonitor:
        """The block of a variant."""
        if name not in self._monitors:
            self._monitors[name] = rule_monitor(self.car, self.calibrations[name == PRINTED], name)
        return self._monitors[name]


def calibrate(number: int, quick: bool) -> Known:
    """Calibrates coefficients and thresholds of a vehicle on its fault-free drives."""
    driven = calibration_set(number, quick, drives=1)
    car = load("smartload").parameters_for(ResidualParameters)
    return Known(car, {each: calibrate_residuals(car, *driven, printed=each) for each in (False, True)})


def declare(known: Known, recording: Recording, name: str) -> Declared:
    """Declarations of a variant of the rules over a drive."""
    return said(known.monitor(name), recording)


def said(monitor: RuleMonitor, recording: Recording) -> Declared:
    """Declarations of rules over a recording."""
    stated = declared_of(scan(monitor, samples_of(recording)), recording["yaw_rate"].time)
    # Rules give neither kind nor size: the zeros of their statements are no estimates.
    return stated._replace(kind=NOTHING, size=NOTHING, deviation=NOTHING)
