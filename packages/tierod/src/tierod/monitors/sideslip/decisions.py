"""Decisions of the sideslip monitor, and the design of their thresholds."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.detectors.rule_design import RuleDesign
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.sideslip.combined_tuning import CombinedTuning
from tierod.monitors.sideslip.expected import Tolerances
from tierod.monitors.sideslip.sensors_over_drive import OFFSET_DESIGN

USUAL_MISFIT = 0.48
"""Standard deviation of the logarithm of the mean NIS [-]; a consistent filter has a NIS of 1, parameters that are
wrong by half give 0.4 to 2.7 (simulated), taken as two standard deviations either way."""

MISFIT_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=500.0, shift=4.0, spacing=math.inf)
"""One decision at the end of a recording, designed for cars whose parameters are wrong by half."""

MOST_RESTARTS: Annotated[float, "1/min"] = 2.0
"""Restarts of the filter per minute above which its parameters do not fit; one difficult minute may cost one."""

LEAST_COVERAGE = 0.8
"""Share of the time for which the 95 % band must contain a recorded truth [-]; less cannot be chance, and shows a band
that is too narrow."""


OFFSET_DECISION = Decision(
    name="offset of the yaw rate",
    distance="mean yaw rate of the standing car, or its mean difference from steering and lateral acceleration, or "
    "from steering and rear wheel speeds, in standard deviations of a calibrated sensor's offset (0.12 degrees per "
    "second)",
    rule=OFFSET_DESIGN.block(),
    place="drive.sensors.offset_rule",
    mean_time_between_false_alarms=1e6,
    demonstrated=Demonstrated(24.0),
    source="Gaussian offsets; drives of the virtual car, random and mixed",
    unit="recording",
    design=OFFSET_DESIGN,
)

MISFIT_DECISION = Decision(
    name="parameters do not fit",
    distance="log of the mean NIS per reading, in standard deviations over cars whose parameters are wrong by half",
    rule=MISFIT_DESIGN.block(),
    place="misfit_rule",
    mean_time_between_false_alarms=500.0,
    demonstrated=Demonstrated(24.0),
    source="lognormal NIS; drives of the virtual car, random and mixed (0.48 to 0.52)",
    unit="recording",
    design=MISFIT_DESIGN,
)

BAND_DECISION = Decision(
    name="band beside a recorded truth",
    distance="share of the time for which the 95 % band contains the truth",
    rule=OwnRule("less than 80 % of 5 s or more", {"least_coverage": LEAST_COVERAGE}),
    place="",
    mean_time_between_false_alarms=None,
    demonstrated=Demonstrated(24.0),
    source="drives of the virtual car, random and mixed (0.96 to 1)",
    unit="recording",
    levels=(LEAST_COVERAGE,),
    below=True,
)

LIMITS = Tolerances()

SIGNALS_DECISION = Decision(
    name="signals contradict each other or the vehicle file",
    distance="reduction of the squared normalised deviations by one wrong scale or zero",
    rule=OwnRule(
        f"above {LIMITS.decides:g}, and a scale that is wrong by {LIMITS.least:.0%} or more".replace("%", " %"),
        {"tolerances.decides": LIMITS.decides, "tolerances.least": LIMITS.least},
    ),
    place="",
    mean_time_between_false_alarms=None,
    demonstrated=Demonstrated(24.0),
    source="virtual cars with brochure values and real cars with their own files",
    unit="recording",
    levels=(LIMITS.decides,),
)

FILE_DECISION = replace(
    SIGNALS_DECISION,
    name="vehicle file of another car",
    distance="reduction of the squared normalised deviations by another wheelbase, understeer, place of the "
    "accelerometer and track",
    rule=OwnRule(f"above {LIMITS.file_decides:g}", {"tolerances.file_decides": LIMITS.file_decides}),
    levels=(LIMITS.file_decides,),
)

DECISIONS = (OFFSET_DECISION, MISFIT_DECISION, BAND_DECISION, SIGNALS_DECISION, FILE_DECISION)
"""Decisions of every variant."""

COMBINED_DECISIONS = (
    *DECISIONS,
    Decision(
        name="limit of the front axle ahead",
        distance="front slip less the slip at 0.7 of the greatest front force, in standard deviations of the estimate",
        rule=HeldThreshold(CombinedTuning().limit_certainty, 1, "upper"),
        place="_estimator.limit_rule",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(0.91),
        source="tierod study sideslip: an announcement is false with less than 60 % of the grip in use; with more it "
        "is intended, so no run length is designed",
        statistic="limit_distance",
        levels=(CombinedTuning().limit_certainty,),
    ),
    Decision(
        name="filter lost",
        distance="restarts of the filter per minute of estimation; it restarts where the innovations over 1 s are "
        "twice as large as expected",
        rule=OwnRule(
            "more than 2 per minute, and more than one; mean NIS above 4",
            {"most_restarts": MOST_RESTARTS, "_estimator.most_misfit": CombinedTuning().most_misfit},
        ),
        place="",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(24.0),
        source="drives of the virtual car, random and mixed (none at all)",
        unit="recording",
    ),
)
"""Decisions of the combined estimator."""
