"""Decision rules of the condition monitor, as shown in reports."""

from __future__ import annotations

from tierod.monitors.condition.session import EVIDENCE
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule

PAPER = (
    "Li, Frey, Gauterin, Model-based condition monitoring of the sensors and actuators of an electric and automated "
    "vehicle, Sensors 23 (2023)"
)

BANK_DECIDES = "fault of a sensor or actuator"
"""Name of the decision that declares faults."""

WIRING = Decision(
    name="wrong wiring, scale or time",
    distance="correlation, ratio and time shift of signals that measure the same quantity, over the first three "
    "minutes",
    rule=OwnRule(
        "opposite signs, ratio of 1.4, or shift of 0.15 s, in each of three parts; 1.13 and 0.045 s once calibrated",
        {"scale": 1.4, "late": 0.15},
    ),
    place="_wiring",
    mean_time_between_false_alarms=None,
    demonstrated=None,
    source="tierod.monitors.condition.recording_checks.wiring; "
    "its limits were chosen on healthy drives of three virtual demonstrators",
    unit="recording",
)

BANK_DECISIONS = (
    Decision(
        name=BANK_DECIDES,
        distance="log-likelihood ratio, per sample, of the filter without the suspect, means over 0.05 and 0.5 s",
        rule=OwnRule(
            "above the vehicle file's limits and 2 nat above all others, 3 samples in a row, 10 for an actuator, 20 "
            "for both steering motors",
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
    WIRING,
)
