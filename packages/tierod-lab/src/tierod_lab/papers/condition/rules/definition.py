"""The paper's rules as variants of the condition monitor.

The package registers each of them in the group `tierod.variants.condition`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from tierod.core.recording import Recording
from tierod.monitors.baseline import Baseline
from tierod.monitors.condition.definition import PAPER
from tierod.monitors.condition.reaction import EVIDENCE, FaultReaction, Reconfiguration
from tierod.monitors.condition.session import ConditionSession
from tierod.monitors.condition.signals import ConditionSample
from tierod.monitors.condition.wiring import WIRING
from tierod.monitors.decision import Decision, OwnRule
from tierod.monitors.session import Session, Table, Variant
from tierod.vehicles import Vehicle

_DECIDES = "symptom of a residual"  # Name of the decision that declares faults


def _opening(name: str) -> Callable[[Vehicle, float, Baseline | None], Session]:
    def opened(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        from tierod_lab.papers.condition.rules.parameters import CarParameters, calibration_of, name_of
        from tierod_lab.papers.condition.rules.rule_monitor import RulesWithReaction, rule_monitor

        printed = name == "rules-printed"
        car = vehicle.parameters_for(CarParameters)
        monitor = rule_monitor(car, calibration_of(vehicle, printed), name, 1.0 / rate)
        calibrated = name_of(printed) in vehicle.thresholds
        # The models of the rules are no substitutes: they use sensors that may be faulty as well, and their errors in
        # that case were never measured.
        reconfiguration = Reconfiguration.of_vehicle(vehicle, 1.0 / rate, calibrated, filters=False)
        block = RulesWithReaction(monitor, FaultReaction.of(reconfiguration, 1.0 / rate))
        graph = reconfiguration.switchover.graph
        return ConditionSession(f"condition, {name}", block, graph, vehicle, rate, calibrated, _DECIDES, {})

    return opened


_DECISIONS = (
    Decision(
        name=_DECIDES,
        distance="residual over its threshold of the vehicle file",
        rule=OwnRule(
            "above one; the rule of a fault must hold for 0.1 s; candidates fit to 0.75", {"least_score": 0.75}
        ),
        place="block.monitor",
        mean_time_between_false_alarms=None,
        demonstrated=None,
        source="thresholds 1.15 times the largest residual of an hour of fault-free driving; "
        "docs/explanation/papers/condition.md",
        statistic=EVIDENCE,
        levels=(1.0,),
    ),
    *WIRING,
)


def calibrated_tables(
    vehicle: Vehicle, fitted: Sequence[Recording], healthy: Sequence[Recording], source: str, *, printed: bool = False
) -> Mapping[str, Table]:
    """Calibrate the residuals.

    Args:
        fitted, healthy: fault-free drives for the coefficients, and for the thresholds

    Returns:
        the table of the vehicle file by its name; empty where a recording lacks a signal that the residuals need
    """
    from tierod_lab.papers.condition.rules.calibration import calibrate_residuals
    from tierod_lab.papers.condition.rules.parameters import CarParameters, name_of, table_of

    if any(name not in each for each in (*fitted, *healthy) for name in ConditionSample._fields[:8]):
        return {}
    car = vehicle.parameters_for(CarParameters)
    return {name_of(printed): table_of(calibrate_residuals(car, fitted, healthy, printed=printed), source)}


def _variant(name: str, summary: str, calibrate: Callable[..., Mapping[str, Table]] | None = None) -> Variant:
    return Variant(name, summary, PAPER, _opening(name), decisions=_DECISIONS, calibrate=calibrate)


RULES = _variant("rules", "The paper's residuals, thresholds and rules, corrected.", calibrated_tables)
# It judges by the table of the corrected rules, so it has no calibration of its own.
RULES_DISCRIMINATING = _variant("rules-discriminating", "The same with further rules that discriminate faults.")
RULES_PRINTED = _variant(
    "rules-printed",
    "The paper's residuals and rules with their misprints.",
    partial(calibrated_tables, printed=True),
)
