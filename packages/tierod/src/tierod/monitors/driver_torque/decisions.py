"""Decisions of the monitor of the driver's hands, and the design of their thresholds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from tierod.methods.detectors import Detector
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine, alarms_at
from tierod.methods.detectors.stopping_rules import CusumRule, HoldRule
from tierod.monitors.driver_torque.hands import THRESHOLDS
from tierod.monitors.harness.decision import Decision, Demonstrated

INERTIA_SPREAD, STIFFNESS_SPREAD, RATIO_SPREAD, MOTOR_INERTIA_SPREAD = 0.026, 0.064, 0.005, 0.104
"""Relative standard deviations of fault-free cars from their vehicle files [-]: the wheel's inertia as weighed and
learnt; bars scatter, or have a gear in series; gains of angle sensors, for a design value; the motor's inertia, which a
sweep to 30 Hz makes 1.2 times as large."""

OFFSET_SPREAD: Annotated[float, "N*m"] = 0.026
"""Standard deviation of a torque offset beyond the learnt one, which hands may imitate [N*m]; a sixth of the torque
that reveals them."""

LAG_SPREAD: Annotated[float, "s"] = 5e-4
"""Standard deviation of a signal's lag [s]; 1 ms costs a sixth of the accuracy, and at low rates samples are held
longer."""

MISFIT_SPREAD = 0.62
"""Standard deviation of the logarithm of the mean NIS per measurement [-]; three times the expected noise is 3.7 of
them away."""

DOUBTED = 2.0
"""Threshold of these standard deviations for a remark on the mean NIS; one fault-free recording in 44 exceeds it by
chance."""

FIT_DESIGN = RuleDesign(HoldRule(1), values=1e4, shift=6.0, spacing=math.inf)
MISFIT_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=1e4, shift=6.0, spacing=math.inf)
"""One decision at the end of a recording."""

OFF_DESIGN = RuleDesign(
    CusumRule(0.0, sides="upper"),
    values=3.60e8,
    shift=0.094,
    spacing=1e-3,
    line=RunLengthLine(start=8.629, slope=0.3421, observed=3.65e6),
)
"""Design of the CUSUM for hands off at 1 kHz: counted on 2 h of benches that are 2 % off, by `design_thresholds` of the
study of the column. 100 h between false alarms while holding need 32.4 nats; 33 are used. Hands that
leave give a nat in 10.6 ms (thresholds from 8 to 45)."""


COLUMN, INNOVATIONS = "column as the vehicle file says", "innovations as expected"
"""Names of the decisions on the agreement of vehicle file and recording."""


@dataclass(frozen=True)
class FitRules:
    """Rules that decide whether vehicle file and recording agree.

    Args:
        either: rule for a distance with a sign
        above: rule for a distance that can only be too large
    """

    either: Detector = field(default_factory=FIT_DESIGN.block)
    above: Detector = field(default_factory=MISFIT_DESIGN.block)

    def apart(self, difference: float, spread: float) -> bool:
        """Whether a difference exceeds what chance explains.

        Args:
            difference: observed less expected value
            spread: its standard deviation [same unit]
        """
        return alarms_at(self.either, difference / spread)

    def misfit(self, nis: float) -> bool:
        """Whether a mean NIS per measurement exceeds that of a matching column; NaN does not."""
        return nis > 0.0 and alarms_at(self.above, misfit(nis))

    def beyond(self, name: str, distance: float) -> bool:
        """Whether the decision of this name alarms at a distance [standard deviations]."""
        return alarms_at(self.above if name == INNOVATIONS else self.either, distance)


def misfit(nis: float) -> float:
    """Distance of a mean NIS per measurement from that of a matching column [standard deviations].

    Args:
        nis: mean NIS, above zero
    """
    return math.log(nis) / MISFIT_SPREAD


_BENCHES = "benches with parameter errors of 2 %, 10 h and another 2 h (tierod study column)"

DECISIONS = (
    Decision(
        name="hands on",
        distance="log-likelihood ratio of hands on against hands off, nats per sample",
        rule=Cusum(0.0, THRESHOLDS[0], THRESHOLDS[0], "upper"),
        place="block.hands.to_on",
        mean_time_between_false_alarms=None,
        demonstrated=Demonstrated(12.0),
        source=f"{_BENCHES}; 100 h need 6 nats by the fitted line; 30 nats allow for larger parameter errors",
        statistic="evidence_for_hands",
        levels=(1.0,),
    ),
    Decision(
        name="hands off",
        distance="log-likelihood ratio of hands off against hands on, nats per sample",
        rule=Cusum(0.0, THRESHOLDS[1], THRESHOLDS[1], "lower"),
        place="block.hands.to_off",
        mean_time_between_false_alarms=100.0,
        demonstrated=Demonstrated(12.0, 1),
        source=f"{_BENCHES}; extrapolated to over a thousand times the measured distance",
        design=OFF_DESIGN,
        statistic="evidence_for_hands",
        levels=(-1.0,),
    ),
    Decision(
        name=COLUMN,
        distance="inertia of wheel and motor, stiffness, ratio, offset and lag of a signal, each less its expected "
        "value, in standard deviations over fault-free cars",
        rule=FIT_DESIGN.block(),
        place="rules.either",
        mean_time_between_false_alarms=1e4,
        demonstrated=Demonstrated(24.0),
        source="Gaussian scatter of each quantity; benches with parameter errors of 2 %, a minute each (inertia 2 to "
        "5 % off, stiffness 4 to 8 %)",
        unit="recording",
        design=FIT_DESIGN,
    ),
    Decision(
        name=INNOVATIONS,
        distance="log of the mean NIS per measurement, in standard deviations over fault-free columns",
        rule=MISFIT_DESIGN.block(),
        place="rules.above",
        mean_time_between_false_alarms=1e4,
        demonstrated=Demonstrated(24.0),
        source="lognormal NIS; benches with parameter errors of 2 %, a minute each (0.68 to 2.1)",
        unit="recording",
        design=MISFIT_DESIGN,
    ),
)
"""Decisions of every variant."""
