"""Thresholds of the verdict on friction, each with its reason, and the design of their false alarm rates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from tierod.core.errors import ParameterError
from tierod.methods.detectors import Cusum
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine
from tierod.methods.detectors.stopping_rules import ExcessRule, HoldRule
from tierod.monitors.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.friction.signals import SAMPLE_TIME
from tierod.vehicles.classes import ASSUMED_GAIN_DEVIATION


@dataclass(frozen=True)
class AlarmTuning:
    """Conditions under which an excess becomes an alarm."""

    # enabled time before any verdict [s]; 50 as printed by Mohtat et al., section 5
    ready_time: Annotated[float, "s"] = 50.0
    # enabled time over which the baseline is learnt, after ready_time [s]; averages a wander of 1 to 2 % (simulated)
    learning_time: Annotated[float, "s"] = 100.0
    # learning time after which the ratio is used [s]; one time constant of the estimator
    shortest_learning: Annotated[float, "s"] = 20.0
    # excess over the learnt level above which nothing is learnt [-]; twice what fault-free drives reached
    learning_tolerance: Annotated[float, ""] = 0.1
    # rising_ratio, fault_ratio: limits of friction over the baseline [-]; 1.2 and 1.6. Fault-free drives with scatter
    # stayed within 0.96 to 1.05
    rising_ratio: Annotated[float, ""] = 1.2
    fault_ratio: Annotated[float, ""] = 1.6
    # standard deviation of a fault-free estimate about its baseline [-]: 0.036 in wind, ruts and banked bends (24
    # drives), 0.008 on usual roads (48 cars, simulated); unit of the excess
    wander: Annotated[float, ""] = 0.036
    # time integral of the excess at which the alarm is raised, as a share of the limit [s]: 10 % for 2.5 s, or 50 % for
    # 0.5 s; see `RISING_DESIGN`
    excess: Annotated[float, "s"] = 0.25
    # upper bound of that integral [s], so that an alarm ends soon after friction has fallen
    ceiling: Annotated[float, "s"] = 1.0
    # standard deviation of the common torque gain, relative [-]: two torques of 10 % each; part of that of friction;
    # `torque_gain_deviation` of a vehicle file replaces it
    gain_deviation: Annotated[float, ""] = ASSUMED_GAIN_DEVIATION
    # standard deviations by which friction must exceed an absolute limit, and by which a given baseline is raised [-];
    # with 1, one fault-free car in 14 000 is "rising" at a gain deviation of 8 %
    confidence: Annotated[float, ""] = 1.0
    # multiple of the level below which friction counts as unchanged, which dates the onset [-]
    onset_ratio: Annotated[float, ""] = 1.05
    # standard deviation over friction above which the value is withheld [-]; half of the smallest change is 0.1
    largest_deviation: Annotated[float, ""] = 0.15
    # mean build-up below which friction cannot be separated from stiffness [-]; strokes shorter than the Dahl angle
    # give 0.3, usual roads 0.8 to 0.95 (simulated)
    smallest_excitation: Annotated[float, ""] = 0.5
    # largest residual of the torque balance, rms, as a share of friction [-]. With a misfit above `fitting_misfit`, 63
    # fault-free drives gave at most 0.10, gusts and ruts 0.21 for 19 s; a wrong sign of the rate 0.36 to 0.54, a yaw
    # rate in degrees 0.13 to 0.29 (simulated)
    largest_residual: Annotated[float, ""] = 0.15
    # misfit up to which the balance fits, whatever the friction [-]; friction of 2 N*m is small beside its errors
    fitting_misfit: Annotated[float, ""] = 1.5
    # uninterrupted enabled time without fit after which the verdict is withheld [s]; after a step of friction the
    # balance misfits for up to 57 s (4 to 25 N*m). It must have fitted once before the first verdict
    unfit_time: Annotated[float, "s"] = 100.0
    # learnt damping below which the signals contradict each other [N*m*s/rad]; 72 fault-free drives stayed above -0.1,
    # a wrong sign of the rate gives -3.1 to -5.6, a lateral acceleration in g -2.3 to -4 (simulated)
    smallest_damping: Annotated[float, "N*m*s/rad"] = -0.5
    # share of friction per rad/s by which friction may fall with the rate (Stribeck) [s/rad]: a line through F e
    # exp(-(w / 0.3 rad/s)^2) up to 1 rad/s falls by 1.06 e F. Allows 0.5 at 4 N*m; with a wrong sign of the rate the
    # damping is -0.7 to -2.6 of friction (simulated, 4 to 25 N*m)
    falling_share: Annotated[float, "s/rad"] = 0.125
    # largest factor on the self-aligning torque, and reciprocal of the smallest [-]; cars whose trail scatters by 30 %
    # end at 0.43 to 3.2, a lateral acceleration in g at 6 to 10, a yaw rate in degrees at 0.04 to 0.09 (simulated)
    largest_aligning_factor: Annotated[float, ""] = 5.0
    # share of nominal friction below which an estimate is implausible [-]: four standard deviations of a new steering
    # (0.5 of 4 N*m, Mohtat et al., Table 1). A clipped motor torque gives 0.36 to 0.6, a halved one 0.59 to 0.73
    # (simulated)
    smallest_friction: Annotated[float, ""] = 0.5

    @property
    def alarm(self) -> Cusum:
        """CUSUM of the excess over a limit [s], for values times the sample time; the limit itself is the drift."""
        return Cusum(0.0, self.excess / self.wander, self.ceiling / self.wander, "upper")

    def __post_init__(self) -> None:
        if not self.wander > 0.0:
            raise ParameterError(f"wander is {self.wander}; expected a share of friction above zero")
        if not 0.0 <= self.confidence * self.gain_deviation < 1.0:
            raise ParameterError(
                f"confidence * gain_deviation is {self.confidence * self.gain_deviation}; expected a share of friction "
                "from 0 to below 1, or no absolute limit is ever reached"
            )


TUNING = AlarmTuning()

STATISTICS = ("excess_over_rising_limit", "excess_over_fault_limit")
"""Traces of the CUSUM sums, each divided by the alarm threshold."""

HOUR = 3600.0 / SAMPLE_TIME  # Samples per judged hour; about a quarter of mixed driving is judged

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
        place="",
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
            {"confidence": 1.0, "gain_deviation": 0.08, "excess": TUNING.excess},
        ),
        place="",
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
