"""Decisions of the lock-to-lock test, and the design of its threshold."""

from __future__ import annotations

import math

from tierod.methods.detectors.rule_design import RuleDesign
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.monitors.harness.decision import Decision, Demonstrated

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
