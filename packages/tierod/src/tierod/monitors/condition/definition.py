"""Definition of the condition monitor: sensors and actuators of an automated vehicle, or sensors of a car."""

from __future__ import annotations

from tierod.monitors.condition.bank.decision import Decision
from tierod.monitors.condition.calibration.grid import MAXIMUM_AGE
from tierod.monitors.condition.calibration.limits import has_own_limits
from tierod.monitors.condition.decisions import BANK_DECIDES, BANK_DECISIONS, PAPER
from tierod.monitors.condition.monitor import condition_monitor
from tierod.monitors.condition.session import Car, ConditionSession
from tierod.monitors.condition.signals import ELEMENTS, ConditionSample
from tierod.monitors.condition.structure import rolls
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Variant
from tierod.monitors.registry import variants_with_plugins
from tierod.vehicles import Vehicle

_MOTION = (
    "the vehicle file does not describe torques and forces of the steering and the drives: wheel speeds, yaw rate and "
    "steering angle are judged by the motion of the car alone, with limits that {}",
    "a fault of both wheels of an axle at once cannot be detected: slip looks the same",
    "a wrong scale of the steering wheel angle is not judged: another steering ratio looks the same; "
    "'tierod identify vehicle' gives the ratio that the drive shows",
)
OF_OTHERS, OF_OWN = "come from two real cars", "were designed on its own drives"


def _bank(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> ConditionSession:
    block, calibrated, car = condition_monitor(vehicle, 1.0 / rate), has_own_limits(vehicle), None
    if rolls(vehicle):
        notes = tuple(each.format(OF_OWN if calibrated else OF_OTHERS) for each in _MOTION)
        calibrated, car = False, Car(block.lanes[0].vehicle, notes)
    graph = block.judge.reaction.reconfiguration.switchover.graph
    decision: Decision = block.judge.decision
    known = [name for name in ELEMENTS if decision.weighing.number(name) is not None]
    multiples = {name: decision.testability.multiple(decision.weighing, name) for name in known}
    return ConditionSession("condition, bank", block, graph, vehicle, rate, calibrated, BANK_DECIDES, multiples, car)


BANK = Variant(
    "bank",
    "About fifty Kalman filters, each without the elements that it suspects, compared by their likelihood.",
    f"beyond {PAPER}; docs/explanation/condition.md",
    _bank,
    decisions=BANK_DECISIONS,
)

CONDITION = Monitor(
    name="condition",
    title="Sensors and actuators of the vehicle",
    summary="Finds which of six sensors and four actuators is faulty, with kind and size of the fault, and replaces "
    "its value.",
    source=PAPER,
    drive="Any drive on a dry road with bends to both sides, acceleration and braking: a fault is found while the "
    "motion shows it, and an element that a drive does not excite is called not testable.",
    # A missing signal gets a state of its own; without any signal the verdict is "not available".
    required=(),
    optional=ConditionSample._fields,
    rate=100.0,
    minimum_rate=10.0,
    # A held reading would look like a stuck sensor; the filters predict without one instead.
    maximum_age=MAXIMUM_AGE,
    variants=variants_with_plugins("condition", {"bank": "tierod.monitors.condition.definition:BANK"}),
    default="bank",
    # Stuck sensors are faults that this monitor declares itself.
    subjects=ConditionSample._fields,
)
