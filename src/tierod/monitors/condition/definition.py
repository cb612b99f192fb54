"""The monitor of sensors and actuators of an automated vehicle, as users see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from tierod.models.rolling_car import RollingCar
from tierod.monitors.condition.calibration.grid import MAXIMUM_AGE
from tierod.monitors.condition.calibration.limits import has_own_limits
from tierod.monitors.condition.residuals.in_vehicle_file import calibration_of, name_of
from tierod.monitors.condition.residuals.parameters import ResidualParameters
from tierod.monitors.condition.rolling_bank import rolling_bank
from tierod.monitors.condition.rule_monitor import rule_monitor
from tierod.monitors.condition.said import said_by_bank, said_by_rules
from tierod.monitors.condition.session import EVIDENCE, Car, ConditionSession, filtered_by_bank
from tierod.monitors.condition.signals import ConditionSample
from tierod.monitors.condition.structure import rolls
from tierod.monitors.condition.vehicle_bank import bank_of
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.harness.session import Monitor, Variant
from tierod.vehicles import Vehicle

PAPER = (
    "Li, Frey, Gauterin, Model-based condition monitoring of the sensors and actuators of an electric and automated "
    "vehicle, Sensors 23 (2023)"
)

_BANK_DECIDES, _RULES_DECIDE = "fault of a sensor or actuator", "symptom of a residual"
"""Names of the decisions by which faults are declared."""

_MOTION = (
    "the vehicle file tells nothing of torques and forces of the steering and the drives: wheel speeds, yaw rate and "
    "steering angle are judged by the motion of the car alone, with limits that come from two real cars",
    "both rear wheels at once are not judged: nothing else tells the speed",
)


def _bank(vehicle: Vehicle, rate: float, own_level: Baseline | None) -> ConditionSession:
    if rolls(vehicle):
        car = Car(replace(vehicle.parameters_for(RollingCar.Parameters), sample_time=1.0 / rate), _MOTION)
        bank = rolling_bank(vehicle, sample_time=1.0 / rate)
        return ConditionSession(
            "condition, bank", bank, said_by_bank, filtered_by_bank, vehicle, rate, False, _BANK_DECIDES, car
        )
    bank, calibrated = bank_of(vehicle, 1.0 / rate), has_own_limits(vehicle)
    said = said_by_bank, filtered_by_bank
    return ConditionSession("condition, bank", bank, *said, vehicle, rate, calibrated, _BANK_DECIDES)


def _rules(name: str) -> Callable[[Vehicle, float, Baseline | None], ConditionSession]:
    """What opens a session of a variant of the rules."""

    def opened(vehicle: Vehicle, rate: float, own_level: Baseline | None) -> ConditionSession:
        printed = name == "rules-printed"
        car = vehicle.parameters_for(ResidualParameters)
        block = rule_monitor(car, calibration_of(vehicle, printed), name, 1.0 / rate)
        calibrated = name_of(printed) in vehicle.thresholds
        # Their models go by sensors that may be at fault too, and nobody has measured what they are off by then.
        said = said_by_rules, None
        return ConditionSession(f"condition, {name}", block, *said, vehicle, rate, calibrated, _RULES_DECIDE)

    return opened


_WIRING = Decision(
    name="wrong wiring, scale or time",
    distance="correlation, ratio and shift of signals that tell the same, over the first three minutes",
    rule=OwnRule(
        "signs opposed, size off by 1.4, or shift of 0.15 s, in each of three parts; 1.13 and 0.045 s once calibrated",
        {"scale": 1.4, "late": 0.15},
    ),
    place="_wiring",
    mean_time_between_false_alarms=None,
    demonstrated=None,
    source="tierod.monitors.condition.recording_checks.wiring; "
    "its limits were chosen on healthy drives of three virtual demonstrators",
    unit="recording",
)

_BANK_DECISIONS = (
    Decision(
        name=_BANK_DECIDES,
        distance="log-likelihood ratio of the filter that leaves it out, per sample, means over 0.05 and 0.5 s",
        rule=OwnRule(
            "beyond the vehicle file's limits, 2 nat ahead of all others, 3 samples in a row, 10 for an actuator, "
            "20 for both steering motors",
            {
                "samples": 3.0,
                "samples_of_actuators": 10.0,
                "samples_of_both_motors": 20.0,
                "impossible": 12.0,
                "gate": 6.0,
                "weighing.limits.gap": 2.0,
                "weighing.limits.margin": 1.0,
            },
        ),
        place="block.judge.decision",
        mean_time_between_false_alarms=1000.0,
        demonstrated=Demonstrated(3.0),
        source="tierod.monitors.condition.calibration.limits, "
        "for a vehicle that 'tierod identify thresholds' has calibrated",
        statistic=EVIDENCE,
        levels=(2.0,),
    ),
    _WIRING,
)

_RULE_DECISIONS = (
    Decision(
        name=_RULES_DECIDE,
        distance="residual over its threshold of the vehicle file",
        rule=OwnRule(
            "above one; the rule of a fault must hold for 0.1 s; candidates fit to 0.75", {"least_score": 0.75}
        ),
        place="block.rules",
        mean_time_between_false_alarms=None,
        demonstrated=None,
        source="thresholds 1.15 times the largest residual of an hour of healthy driving; "
        "docs/explanation/papers/condition.md",
        statistic=EVIDENCE,
        levels=(1.0,),
    ),
    _WIRING,
)

CONDITION = Monitor(
    name="condition",
    title="Sensors and actuators of the vehicle",
    summary="Finds which of six sensors and four actuators is at fault, of what kind and size, and replaces its value.",
    source=PAPER,
    # Whatever is missing has a state of its own; with nothing at all, "not available" is the verdict.
    required=(),
    optional=ConditionSample._fields,
    rate=100.0,
    minimum_rate=10.0,
    # A held reading would be one that stands still; the filter goes on without.
    maximum_age=MAXIMUM_AGE,
    variants={
        "bank": Variant(
            "bank",
            "Some fifty Kalman filters, each leaving out what it suspects, weighed by their likelihood.",
            f"beyond {PAPER}; docs/explanation/condition.md",
            _bank,
            decisions=_BANK_DECISIONS,
        ),
        **{
            name: Variant(name, summary, PAPER, _rules(name), decisions=_RULE_DECISIONS)
            for name, summary in {
                "rules": "The paper's residuals, thresholds and rules, corrected.",
                "rules-discriminating": "The same with further rules that tell faults apart.",
                "rules-printed": "The paper's residuals and rules with their misprints.",
            }.items()
        },
    },
    default="bank",
    # A sensor that stands still is a fault of its own here.
    subjects=ConditionSample._fields,
)
