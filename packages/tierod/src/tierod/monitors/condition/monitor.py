"""Condition monitor as one block: a filter for every hypothesis, the judge, substitutes and trouble codes.

`diagnose`, the benchmarks, `Stream` and generated C all run this block. A car whose file describes no torques gets the
bank of a rolling car, which judges wheel speeds, yaw rate and steering angle by the motion alone.
"""

from __future__ import annotations

from dataclasses import replace

from tierod.core.graph import Bank
from tierod.diagnosis.trouble_codes import TroubleCodes
from tierod.models.rolling_car import Wander
from tierod.monitors.condition.bank.decision import Decision, SmallLeads
from tierod.monitors.condition.bank.judge import ConditionJudge
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.low_grip import sliding
from tierod.monitors.condition.bank.rolling_filter import RollingFilter
from tierod.monitors.condition.bank.sliding_lanes import OF_SKIDDING, ploughing, skidding
from tierod.monitors.condition.bank.testability import Testability
from tierod.monitors.condition.bank.tuning import prices
from tierod.monitors.condition.bank.weighing import Limits, Weighing
from tierod.monitors.condition.calibration.limits import GAP, MARGIN, has_own_limits, limits_of
from tierod.monitors.condition.hypotheses import hypotheses, hypotheses_of_cars
from tierod.monitors.condition.kinds.kind import KindOfFault
from tierod.monitors.condition.reaction import FaultReaction
from tierod.monitors.condition.signals import ALL_WHEELS, OF_AUTOMATED, OF_CARS, SENSOR_TABLE, SENSORS
from tierod.monitors.condition.spans import SpanOfFault
from tierod.monitors.condition.structure import rolls
from tierod.monitors.condition.substitutes import FILTER, Reconfiguration, substitution_graph
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
    """Condition monitor of a vehicle, with or without a calibration.

    Args:
        vehicle: vehicle with the parameters of `AutomatedVehicle`, or else of `RollingCar`
        sample_time: sampling interval [s]
        codes: table of trouble codes; None takes the shipped one

    Raises:
        ParameterError: parameters are missing
    """
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
    """Condition monitor of a car without known torques: wheel speeds, yaw rate and steering angle by the motion alone.

    Args:
        vehicle: vehicle with the parameters of `RollingCar`
        limits: limits of all hypotheses but the fault-free one; None takes those of the vehicle file, or else those
            from real cars
        sample_time: sampling interval [s]
        codes: table of trouble codes; None takes the shipped one

    Raises:
        ParameterError: parameters are missing
    """
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
    """Filters of all hypotheses for a rolling car, and the two of sliding tyres at the end.

    Args:
        base: filter of the fault-free hypothesis
    """
    return (*(base.leaving_out(each) for each in hypotheses_of_cars()), ploughing(base), skidding(base))


def rolling_decision(base: RollingFilter, limits: Limits, sample_time: float = 0.01) -> Decision:
    """Decision between the hypotheses for a rolling car.

    Args:
        base: filter of the fault-free hypothesis
        limits: limits of all hypotheses but the fault-free one
        sample_time: sampling interval [s]
    """
    costs = prices(base.sensor_noise, base.plausible)
    weighing = Weighing(hypotheses_of_cars(), limits, sample_time, prices=costs)
    # A sensor that a car never has must not widen limits that were designed without it.
    testability = Testability(poorer=1.0, remaining=3.0, judged=OF_CARS)
    return Decision(weighing, low_grip=OF_SKIDDING, testability=testability, small_leads=SmallLeads())
