"""A bank of made-up lanes with the judge of the monitor."""

from monitors.condition.made_up_lanes import HYPOTHESES, lane
from tierod.core.graph import Bank
from tierod.monitors.condition.decision import Decision
from tierod.monitors.condition.judge import ConditionJudge
from tierod.monitors.condition.kinds import KindOfFault
from tierod.monitors.condition.reaction import FaultReaction, Reconfiguration
from tierod.monitors.condition.signals import OF_AUTOMATED
from tierod.monitors.condition.weighing import Limits, Weighing
from tierod.vehicles import load


def made_up_bank():
    count = len(HYPOTHESES) - 1
    decision = Decision(Weighing(HYPOTHESES, Limits((3.0,) * count, (1.0,) * count, gap=1.0, margin=1.0)))
    reaction = FaultReaction.of(Reconfiguration.of_vehicle(load("smartload")))
    kinds = tuple(KindOfFault.of_sensor(name) for name in OF_AUTOMATED)
    return Bank(tuple(map(lane, HYPOTHESES)), ConditionJudge(decision, kinds, reaction))
