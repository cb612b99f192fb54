"""Sensitivity of every residual with fixed and adaptive thresholds, and their effect on the rules."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Recording
from tierod.vehicles import load
from tierod_lab.papers.condition.by_rules import said
from tierod_lab.papers.condition.drives import Drive, actuator_tests, healthy_drives, sensor_tests
from tierod_lab.papers.condition.recorded import calibration_set, recorded
from tierod_lab.papers.condition.rules.calibration import ResidualCalibration, calibrate_residuals
from tierod_lab.papers.condition.rules.parameters import (
    RESIDUALS,
    SENSOR_RESIDUALS,
    Residual,
    ResidualParameters,
    residual,
)
from tierod_lab.papers.condition.rules.readings import Excitation, ResidualThreshold
from tierod_lab.papers.condition.rules.rule_monitor import RuleMonitor, rule_monitor
from tierod_lab.papers.condition.runs import calibrations
from tierod_lab.papers.condition.scoring import DriveScore, score
from tierod_lab.papers.condition.signatures import (
    Signatures,
    disagreements,
    of_kinds,
    signatures,
    theory_and_measurement,
    uses,
)
from tierod_lab.papers.condition.summary import summary
from tierod_lab.papers.condition.truth import truth_of
from tierod_lab.studies.effort import Effort

USUAL = Excitation(8.0, 0.2, 2.0, 0.5)
"""Excitation of a lively drive of the demonstrator, at which adaptive thresholds are quoted."""


@dataclass(frozen=True)
class JudgedResidual:
    """One residual with its decision."""

    residual: Residual  # entry of the catalogue
    deviation: Annotated[float, "unit of the signal"]  # fault-free standard deviation, in its unit
    threshold: ResidualThreshold  # threshold, fixed or adaptive

    @property
    def distance(self) -> str:
        """Decision variable of the rule, as text."""
        return "off its healthy median, in thresholds" if self.threshold.centre else "off zero, in thresholds"

    @property
    def sigmas(self) -> float:
        """Threshold at the excitation `USUAL`, in standard deviations."""
        return float(self.threshold.at(USUAL)) / self.deviation

    @property
    def condition(self) -> str:
        """Enabling condition, as text."""
        words = {
            "moving": "above walking speed",
            "gentle": "below 6 m/s2 across",
            "steady": "while the asked torque does not jump",
        }
        asked = [text for name, text in words.items() if getattr(self.residual, name)]
        return ", ".join(asked) or "always"


def judged(name: str, calibration: ResidualCalibration) -> JudgedResidual:
    """A residual with its decision by a calibration.

    Raises:
        ParameterError: there is no such residual
    """
    return JudgedResidual(residual(name), calibration.deviations[name], calibration.thresholds[name])


TEXT = (
    "The residuals of the corrected equations with one vehicle. A fault should be seen by residuals whose equations "
    "use its sensor, and by no others. Thresholds are 1.15 times the largest residual of a healthy hour; those that "
    "adapt are a sum of what speed, yaw acceleration, lateral acceleration and steering rate add, fitted on the same "
    "hour, and taken where they are lower on average.",
)
VEHICLE = 1
RULES = "rules-discriminating"
_WHEELS = ("r7", "r9", "r11", "r13")
SOURCE = "Li, Frey, Gauterin, Figure 7 and section 3.9"


def items(effort: Effort) -> Iterator[Item]:
    tests = sensor_tests(VEHICLE)[:: 7 if effort.quick else 1]
    known = _calibrated(effort)
    monitors = {name: rule_monitor(_car(), each, RULES) for name, each in known.items()}
    recordings = [recorded(each) for each in tests]
    yield Heading("Sensitivity of every residual", TEXT)
    seen = signatures(tests, recordings, monitors["fixed"])
    yield of_kinds(seen)
    yield from _signature_claims(seen)
    losses = actuator_tests(VEHICLE)[:: 4 if effort.quick else 1]
    both = {**seen, **signatures(losses, [recorded(each) for each in losses], monitors["fixed"])}
    yield theory_and_measurement(both)
    yield disagreements(both)
    yield _threshold_table(known)
    healthy = healthy_drives(0.05 if effort.quick else 1.0, (VEHICLE,))
    yield _rules_table(monitors, tests, recordings, healthy)


def _car() -> ResidualParameters:
    return load("smartload").parameters_for(ResidualParameters)


def _calibrated(effort: Effort) -> dict[str, ResidualCalibration]:
    (rules,) = calibrations((RULES,), (VEHICLE,), effort).values()
    adapting = calibrate_residuals(_car(), *calibration_set(VEHICLE, effort.quick, drives=1), adaptive=True)
    return {"fixed": rules.calibrations[False], "adapting": adapting}


def _signature_claims(seen: Signatures) -> Iterator[Claim]:
    blind = max(
        (
            found[each.name].share
            for (sensor, _), found in seen.items()
            for each in SENSOR_RESIDUALS
            if not uses(each.name, sensor)
        ),
        default=0.0,
    )
    wheels = [
        found[name].share for (sensor, _), found in seen.items() if sensor.startswith("wheel_speed") for name in _WHEELS
    ]
    yield Claim(
        "residuals.blind",
        "No residual is abnormal for a sensor that its equation does not use.",
        SOURCE,
        None,
        blind,
        at_most(0.01),
    )
    yield Claim(
        "residuals.wheels",
        "r7, r9, r11 and r13 are all abnormal while a wheel speed is faulty.",
        SOURCE,
        None,
        min(wheels, default=float("nan")),
        at_least(0.95),
    )


def _threshold_table(known: Mapping[str, ResidualCalibration]) -> Table:
    rows = []
    for name, each in RESIDUALS.items():
        fixed, adapting = judged(name, known["fixed"]), judged(name, known["adapting"])
        threshold = adapting.threshold
        widest = f"{threshold.base:.3g} and more" if threshold.adapts else f"{threshold.base:.3g}"
        rows.append(
            (
                name,
                each.unit or "-",
                f"{fixed.deviation:.3g}",
                f"{fixed.threshold.base:.3g}",
                f"{fixed.sigmas:.1f}",
                widest,
                f"{adapting.sigmas:.1f}",
                fixed.condition,
            )
        )
    header = ("residual", "unit", "sigma", "fixed", "in sigma", "adapting", "in sigma, lively", "judged")
    return Table("Thresholds of the residuals", header, tuple(rows))


def _rules_table(
    monitors: Mapping[str, RuleMonitor],
    tests: Sequence[Drive],
    recordings: Sequence[Recording],
    healthy: Sequence[Drive],
) -> Table:
    rows = []
    quiet = [(drive, recorded(drive)) for drive in healthy]
    for name, monitor in monitors.items():
        found: list[DriveScore] = []
        own = []
        for drive, recording in zip(tests, recordings, strict=True):
            declared = said(monitor, recording)
            found.append(score(drive, truth_of(drive, recording), declared))
            fault = drive.injected[0]
            there = (declared.time >= fault.start) & (declared.time < fault.end)
            named, unsure = declared.said("faulty", fault.element), declared.said("not_testable", fault.element)
            own.append(float(np.mean((named == there)[~(there & unsure & ~named)])))
        alarms = sum(
            score(drive, truth_of(drive, recording), said(monitor, recording)).false_alarms
            for drive, recording in quiet
        )
        whole = summary(found)
        hours = sum(drive.seconds for drive in healthy) / 3600.0
        rows.append(
            (
                name,
                f"{whole.accuracy:.3f} / {whole.worst:.3f}",
                f"{np.mean(own):.3f} / {min(own):.3f}",
                f"{whole.wrong:.3f}",
                f"{alarms} in {hours:.2g} h",
            )
        )
    header = ("thresholds", "accuracy", "without what the rules call not testable", "wrong sensor", "false alarms")
    return Table("Rules that discriminate with fixed and adapting thresholds", header, tuple(rows))
