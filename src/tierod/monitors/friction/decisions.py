"""Decisions of the friction monitor, and the design of their limits."""

from __future__ import annotations

import math

from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.detectors.excess_rule import ExcessRule
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.monitors.friction.conditioning import SAMPLE_TIME
from tierod.monitors.friction.verdict_tuning import AlarmTuning
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule

TUNING = AlarmTuning()

STATISTICS = ("excess_over_rising_limit", "excess_over_fault_limit")
"""Traces of the CUSUM sums, each divided by the alarm threshold."""

HOUR = 3600.0 / SAMPLE_TIME
"""Samples per judged hour; about a quarter of mixed driving is judged."""

RISING_DESIGN = RuleDesign(
    ExcessRule(TUNING.rising_ratio * TUNING.excess / TUNING.wander / SAMPLE_TIME, sides="upper"),
    values=65.0 * HOUR,
    shift=(1.6 - 1.0) / TUNING.wander,
    spacing=SAMPLE_TIME,
    line=RunLengthLine(start=7.014, slope=1.793, observed=1.5 * HOUR),
)
"""Design of the ratio from which friction is rising, in units of the wander. Alarms were counted on 24 drives of 13
minutes in wind, ruts and banked bends, each judged against a baseline from another day on other tyres. Ratios of 1.02
to 1.09 gave 147 to 6 alarms in 1.5 judged hours; the logarithm of the mean time between alarms is linear in the ratio
and is extrapolated to 1.2."""

ABSOLUTE_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=13_900.0, shift=8.0, spacing=math.inf)
"""One decision per car: the limit of 1.2 times nominal with its margin is 3.8 standard deviations of the common torque
gain away."""

BASELINE = tuple(
    Decision(
        name=f"{name}, baseline",
        distance=f"friction over {ratio:g} times the car's baseline, less one, in standard deviations of a fault-free "
        f"car's estimate ({TUNING.wander:g}), times the sample time in seconds",
        rule=TUNING.alarm,
        place="block.verdict.alarm",
        mean_time_between_false_alarms=mean,
        demonstrated=Demonstrated(6.8),
        source="24 drives in wind, ruts and banked bends, extrapolated; false alarms are rarer on other roads; hours "
        "of judged time",
        design=RISING_DESIGN if name == "rising" else None,
        statistic=statistic,
        levels=(1.0,),
    )
    for name, ratio, mean, statistic in (
        ("rising", TUNING.rising_ratio, 65.0, STATISTICS[0]),
        ("fault", TUNING.fault_ratio, None, STATISTICS[1]),
    )
)

ABSOLUTE = tuple(
    Decision(
        name=f"{name}, vehicle file",
        distance="friction over the limit, in standard deviations of the torques' common gain (8 %) and of the "
        "estimate",
        rule=OwnRule(
            "the same cumulative sum, for friction less one standard deviation; 1.2 times nominal is 3.8 standard "
            "deviations away",
            {"tuning.confidence": 1.0, "tuning.gain_deviation": 0.08, "tuning.excess": TUNING.excess},
        ),
        place="block.verdict",
        mean_time_between_false_alarms=mean,
        demonstrated=Demonstrated(152.0, 1),
        source="Gaussian gain errors of 8 %; cars of the virtual fleet, whose estimates scatter by 7.6 to 8.5 %",
        unit="car",
        design=ABSOLUTE_DESIGN if name == "rising" else None,
        statistic=statistic,
        levels=(1.0,),
    )
    for name, mean, statistic in (("rising", 13_900.0, STATISTICS[0]), ("fault", None, STATISTICS[1]))
)

DECISIONS = (*BASELINE, *ABSOLUTE)
"""Decisions of every variant with the running verdict: rising and fault, by baseline and by vehicle file."""

VARIANCE_DECISIONS = (
    Decision(
        name="fault, variance of two torques",
        distance="median variance of the later half of the windows, over `baseline_variance` of the vehicle file",
        rule=HeldThreshold(1.0, 1, "upper"),
        place="block.alarm",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(24.0),
        source="baseline_variance is the 99 % quantile over the windows of healthy drives; demonstrated without the "
        "gate, whose conditions held too rarely for a verdict in any of these drives",
        unit="recording",
        statistic="variance",
        level="threshold",
    ),
)
"""Decision of the baseline method of the paper."""
