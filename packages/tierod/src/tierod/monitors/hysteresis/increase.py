"""Increase of friction over that of the fault-free car: its deviation, the limits that judge it, and the decision."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.findings import Status
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.detectors.rule_design import RuleDesign, alarms_at
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.methods.identification.hysteresis import HysteresisFriction
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.decision import Decision, Demonstrated
from tierod.vehicles.uncertain import GAIN_DEVIATION

INCREASE_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=1000.0, shift=8.0, spacing=math.inf)
"""One decision per test."""

INCREASE = Decision(
    name="friction has risen",
    distance="friction above that of the fault-free loop, in standard deviations from damping, scatter of both loops, "
    "and the nominal friction where no loop of the fault-free car is known",
    rule=INCREASE_DESIGN.block(),
    place="rule",
    mean_time_between_false_alarms=1000.0,
    demonstrated=Demonstrated(12.0),
    source="Gaussian errors; virtual tests on hoist and ground, each against another of the same car",
    unit="recording",
    design=INCREASE_DESIGN,
)
"""Decision on an increase; above its threshold the limits of the vehicle file grade it as rising or fault, below it a
friction above a limit is suspect."""


@dataclass(frozen=True)
class IncreaseLimits:
    """Limits of an increase over the fault-free loop, named as in a vehicle file.

    Args:
        nominal_friction, rising_friction, fault_friction: limits, whose distances from nominal judge an increase
    """

    nominal_friction: Annotated[float, "N*m"]
    rising_friction: Annotated[float, "N*m"]
    fault_friction: Annotated[float, "N*m"]

    @property
    def to_fault(self) -> float:
        """Increase from which it is a fault [N m]."""
        return self.fault_friction - self.nominal_friction

    def status(self, above_nominal: float, deviation: float, rule: HeldThreshold) -> Status:
        """Status of a friction above the base level; suspect where it exceeds a limit but may do so by chance.

        Args:
            above_nominal: friction above the base level [N m]
            deviation: its standard deviation [N m]
            rule: rule on above_nominal over its deviation
        """
        if not above_nominal > self.rising_friction - self.nominal_friction:
            return Status.HEALTHY
        if not alarms_at(rule, above_nominal / max(deviation, 1e-9)):
            return Status.SUSPECT
        return Status.FAULT if above_nominal > self.to_fault else Status.RISING

    def excludes_fault(self, above_nominal: float, deviation: float, rule: HeldThreshold) -> bool:
        """Whether a friction above the base level is that far below a fault; arguments as of `status`."""
        return alarms_at(rule, (self.to_fault - above_nominal) / max(deviation, 1e-9))

    def above(self, base: float) -> dict[str, float]:
        """Frictions [N m] from which a car with the fault-free level `base` is rising or faulty."""
        distances = {"rising": self.rising_friction, "fault": self.fault_friction}
        return {name: base + limit - self.nominal_friction for name, limit in distances.items()}


class Increase(NamedTuple):
    """Friction above that of the fault-free car.

    Args:
        value: friction above the reference [N m]
        reference: name of the reference
        base: friction of the reference [N m]
        parts: standard deviations [N m] by cause that the monitor itself judges, and names; damping and gains are left
            to the interval of the friction where there is no baseline
        fault_free_deviation: standard deviation of the increase if the car is fault-free [N m]
    """

    value: float
    reference: str
    base: float
    parts: dict[str, float]
    fault_free_deviation: float

    @property
    def deviation(self) -> float:
        """Standard deviation by the parts together [N m]."""
        return math.hypot(*self.parts.values())


SCATTER, FAULT_FREE_TEST = "scatter of the loops", "fault-free test"
RATE, GAIN = "rate of turning", GAIN_DEVIATION
"""Parts of the deviation of an increase."""


def over_baseline(found: HysteresisFriction, known: Baseline, gain: float) -> Increase:
    """Increase over a fault-free test of the same car, with the same damping and the same gains of the torques.

    Args:
        found: friction of this test
        known: friction of the fault-free test
        gain: relative standard deviation of the torques' gain, which scales the increase alone [-]
    """
    value = found.friction_torque - known.value
    common = 0.0 if known.rate is None else found.damping_deviation * abs(found.mean_rate - known.rate)
    loops = {SCATTER: found.independent_deviation, FAULT_FREE_TEST: known.deviation, RATE: common}
    parts = loops | {GAIN: abs(gain * value)}
    return Increase(value, "unfaulted", known.value, parts, math.hypot(*loops.values()))


def over_nominal(found: HysteresisFriction, nominal: float, nominal_deviation: float, gain: float) -> Increase:
    """Increase over the nominal friction of the vehicle file.

    Args:
        found: friction of this test
        nominal: friction of a fault-free car [N m]
        nominal_deviation: its standard deviation [N m]
        gain: relative standard deviation of the torques' gain, which scales the whole friction [-]
    """
    value = found.friction_torque - nominal
    own = math.hypot(found.standard_deviation, nominal_deviation)
    # A fault-free car reads its own friction times the gain: that scatter decides whether an increase is chance.
    fault_free = math.hypot(own, gain * nominal)
    return Increase(value, "nominal", nominal, {SCATTER: found.independent_deviation}, fault_free)
