"""Definition of the condition monitor: sensors and actuators of an automated vehicle, or sensors of a car."""

from __future__ import annotations

from dataclasses import replace

from tierod.core.graph import Bank
from tierod.diagnosis.trouble_codes import TroubleCodes
from tierod.models.single_track import Wander
from tierod.monitors.baseline import Baseline
from tierod.monitors.condition.decision import Decision, SmallLeads
from tierod.monitors.condition.judge import BANK_DECIDES, ConditionJudge, SpanOfFault
from tierod.monitors.condition.kinds import KindOfFault
from tierod.monitors.condition.limits import GAP, MARGIN, MAXIMUM_AGE, has_own_limits, limits_of
from tierod.monitors.condition.low_grip import OF_SKIDDING, ploughing, skidding, sliding
from tierod.monitors.condition.reaction import FILTER, FaultReaction, Reconfiguration, substitution_graph
from tierod.monitors.condition.rolling_filter import RollingFilter
from tierod.monitors.condition.session import Car, ConditionSession
from tierod.monitors.condition.signals import (
    ALL_WHEELS,
    ELEMENTS,
    OF_AUTOMATED,
    OF_CARS,
    SENSOR_TABLE,
    SENSORS,
    ConditionSample,
    hypotheses,
    hypotheses_of_cars,
    rolls,
)
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter, prices
from tierod.monitors.condition.weighing import Limits, Testability, Weighing
from tierod.monitors.condition.wiring import WIRING
from tierod.monitors.decision import declared
from tierod.monitors.registry import variants_with_plugins
from tierod.monitors.session import Monitor, Variant
from tierod.vehicles import Vehicle

WITH_WHEELS, WITHOUT_WHEELS, SLOW = 9.0, 2.15, 0.45
"""Limits for a rolling car [nat]: fast mean of hypotheses with wheels and of those without, slow mean of all.

By the rule of `limits` they are 1.5 times what lies 2 nat (slow mean: 1 nat) above the largest fault-free ratio, and at
least 0.5 (0.3) nat: bumps reach 3.3 in the first half of a highway minute of a RAV4, hypotheses without wheels -0.6 in
9 s of another car's tight bends, and the slow mean -1.7.
"""
ALIKE = 2.0 * Wander().steering
"""Correlation time of the prediction's errors [s], as slow as the error of the steering ratio."""


def condition_monitor(vehicle: Vehicle, sample_time: float = 0.01, codes: TroubleCodes | None = None) -> Bank:
    """Condition monitor of a vehicle, with or without a calibration."""
    return rolling_monitor(vehicle, None, sample_time, codes) if rolls(vehicle) else _whole(vehicle, sample_time, codes)


def _whole(vehicle: Vehicle, sample_time: float, codes: TroubleCodes | None) -> Bank:
    """Bank for a vehicle with known torques: lanes of all hypotheses, and one lane of sliding tyres."""
    base, explanations = LeaveOutFilter.of_vehicle(vehicle, sample_time), hypotheses()
    calibrated, limits = has_own_limits(vehicle), limits_of(vehicle)
    kinds = tuple(KindOfFault.of_sensor(name, sample_time) for name in OF_AUTOMATED)
    if not calibrated:
        # Kinds and magnitudes must allow for the lasting prediction errors of a vehicle without calibration.
        ways = substitution_graph(calibrated=False).substitutes
        errors = [next(way.deviation for way in ways[name] if way.name == FILTER) for name in OF_AUTOMATED]
        kinds = tuple(replace(kind, unknown=error) for kind, error in zip(kinds, errors, strict=True))
    lanes = (*(base.leaving_out(each) for each in explanations), sliding(base))
    weighing = Weighing(explanations, limits, sample_time, prices=prices(base.sensor_noise, base.plausible))
    reaction = FaultReaction.of(Reconfiguration.of_vehicle(vehicle, sample_time, calibrated), sample_time, codes)
    judge = ConditionJudge(Decision(weighing), kinds, reaction, spans=SpanOfFault(sample_time))
    return Bank(lanes, judge)


def rolling_limits() -> Limits:
    """Limits of all hypotheses for a rolling car but the fault-free one, without limits of its own."""
    faults = hypotheses_of_cars()[1:]
    fast = tuple(WITHOUT_WHEELS if {*ALL_WHEELS}.isdisjoint(each.sensors) else WITH_WHEELS for each in faults)
    return Limits(fast, (SLOW,) * len(faults), GAP, MARGIN)


def rolling_monitor(
    vehicle: Vehicle, limits: Limits | None = None, sample_time: float = 0.01, codes: TroubleCodes | None = None
) -> Bank:
    """Condition monitor of a car without known torques, by its motion alone."""
    base, explanations = RollingFilter.of_vehicle(vehicle, sample_time), hypotheses_of_cars()
    kinds = tuple(
        replace(
            KindOfFault.of_sensor(each.name, sample_time),
            unknown=each.error_on_cars,
            alike=ALIKE,
            lasting=ALIKE,
            withholds=True,
        )
        for each in (SENSOR_TABLE[SENSORS.index(name)] for name in OF_CARS)
    )
    own = limits_of(vehicle, explanations) if has_own_limits(vehicle) else rolling_limits()
    decision = rolling_decision(base, limits or own, sample_time)
    reaction = FaultReaction.of(Reconfiguration.of_car(base.vehicle, sample_time), sample_time, codes)
    return Bank(rolling_lanes(base), ConditionJudge(decision, kinds, reaction, OF_CARS, SpanOfFault(sample_time)))


def rolling_lanes(base: RollingFilter) -> tuple[RollingFilter, ...]:
    """Filters of all hypotheses for a rolling car, and the two of sliding tyres at the end."""
    return (*(base.leaving_out(each) for each in hypotheses_of_cars()), ploughing(base), skidding(base))


def rolling_decision(base: RollingFilter, limits: Limits, sample_time: float = 0.01) -> Decision:
    costs = prices(base.sensor_noise, base.plausible)
    weighing = Weighing(hypotheses_of_cars(), limits, sample_time, prices=costs)
    # A sensor that a car never has must not widen limits that were designed without it.
    testability = Testability(poorer=1.0, remaining=3.0, judged=OF_CARS)
    return Decision(weighing, low_grip=OF_SKIDDING, testability=testability, small_leads=SmallLeads())


PAPER = "Li, Frey, Gauterin, Sensors 23 (2023) 887"

BANK_DECISIONS = (*declared(ConditionJudge, "block.judge"), *WIRING)


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
    subject="Sensors and actuators",
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
