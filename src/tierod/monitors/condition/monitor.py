"""The condition monitor as one block: a filter for every hypothesis, the judge, substitutes and trouble codes.

`diagnose`, the benchmarks, `Stream` and generated C all run this block. A car whose file describes no torques gets the
bank of a rolling car: wheel speeds, yaw rate and steering angle, judged by its motion alone.
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
from tierod.monitors.condition.calibration.limits import has_own_limits, limits_of
from tierod.monitors.condition.hypotheses import hypotheses, hypotheses_of_cars
from tierod.monitors.condition.kinds.kind import KindOfFault
from tierod.monitors.condition.reaction import FaultReaction
from tierod.monitors.condition.signals import ALL_WHEELS, OF_AUTOMATED, OF_CARS, SENSOR_TABLE, SENSORS
from tierod.monitors.condition.structure import rolls
from tierod.monitors.condition.substitutes import FILTER, Reconfiguration, substitution_graph
from tierod.vehicles import Vehicle

WITH_WHEELS, WITHOUT_WHEELS, SLOW = 9.0, 2.15, 0.45
"""Limits of hypotheses with and without wheels, over the short time, and of all over the long one [nat], for a rolling
car.

As `limits` designs them, 1.5 times what lies 2 (long: 1) nat above the largest healthy ratio and at least 0.5 (0.3):
bumps reach 3.3 in the first half of a highway minute of a RAV4, all else -0.6 in 9 s of another car's tight bends, and
the long time -1.7.
"""
GAP, MARGIN = 2.0, 1.0
"""As those of the bank of the whole vehicle."""
ALIKE = 2.0 * Wander().steering
"""Errors of predictions count once in so long a time [s]: those of the steering's ratio fade so slowly."""


def condition_monitor(vehicle: Vehicle, sample_time: float = 0.01, codes: TroubleCodes | None = None) -> Bank:
    """The monitor of a vehicle, calibrated or not.

    Args:
        vehicle: with the parameters of `AutomatedVehicle`, or else of `RollingCar`
        sample_time: [s]
        codes: table of trouble codes; the shipped one if None

    Raises:
        ParameterError: parameters that are missing
    """
    return rolling_monitor(vehicle, None, sample_time, codes) if rolls(vehicle) else _whole(vehicle, sample_time, codes)


def _whole(vehicle: Vehicle, sample_time: float, codes: TroubleCodes | None) -> Bank:
    """Bank for a vehicle whose torques are known: lanes of all hypotheses, and one of sliding tyres."""
    base, explanations = LeaveOutFilter.of_vehicle(vehicle, sample_time), hypotheses()
    calibrated, limits = has_own_limits(vehicle), limits_of(vehicle)
    kinds = tuple(KindOfFault.of_sensor(name, sample_time) for name in OF_AUTOMATED)
    if not calibrated:
        # Kinds and magnitudes reckon with the errors of predictions of vehicles that were not calibrated.
        ways = substitution_graph(calibrated=False).substitutes
        errors = [next(way.deviation for way in ways[name] if way.name == FILTER) for name in OF_AUTOMATED]
        kinds = tuple(replace(kind, unknown=error) for kind, error in zip(kinds, errors, strict=True))
    lanes = (*(base.leaving_out(each) for each in explanations), sliding(base))
    weighing = Weighing(explanations, limits, sample_time, prices=prices(base.sensor_noise, base.plausible))
    reaction = FaultReaction.of(Reconfiguration.of_vehicle(vehicle, sample_time, calibrated), sample_time, codes)
    return Bank(lanes, ConditionJudge(Decision(weighing), kinds, reaction))


def rolling_limits() -> Limits:
    """Limits of all hypotheses about a rolling car but healthy."""
    faults = hypotheses_of_cars()[1:]
    fast = tuple(WITHOUT_WHEELS if {*ALL_WHEELS}.isdisjoint(each.sensors) else WITH_WHEELS for each in faults)
    return Limits(fast, (SLOW,) * len(faults), GAP, MARGIN)


def rolling_monitor(
    vehicle: Vehicle, limits: Limits | None = None, sample_time: float = 0.01, codes: TroubleCodes | None = None
) -> Bank:
    """The monitor of a car whose torques are not known: wheel speeds, yaw rate and steering angle by its motion.

    Args:
        vehicle: with the parameters of `RollingCar`
        limits: for all hypotheses but healthy; if None those of the vehicle file, or else of real cars
        sample_time: [s]
        codes: table of trouble codes; the shipped one if None

    Raises:
        ParameterError: parameters that are missing
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
    return Bank(rolling_lanes(base), ConditionJudge(decision, kinds, reaction, OF_CARS))


def rolling_lanes(base: RollingFilter) -> tuple[RollingFilter, ...]:
    """A filter for every hypothesis about a rolling car, and those of sliding tyres.

    Args:
        base: the filter that suspects nothing
    """
    return (*(base.leaving_out(each) for each in hypotheses_of_cars()), ploughing(base), skidding(base))


def rolling_decision(base: RollingFilter, limits: Limits, sample_time: float = 0.01) -> Decision:
    """Decision between the filters of a rolling car.

    Args:
        base: the filter that suspects nothing
        limits: of all hypotheses but healthy
        sample_time: [s]
    """
    costs = prices(base.sensor_noise, base.plausible)
    weighing = Weighing(hypotheses_of_cars(), limits, sample_time, prices=costs)
    # What is never there must not widen the limits that were found without it.
    testability = Testability(poorer=1.0, remaining=3.0, judged=OF_CARS)
    return Decision(weighing, low_grip=OF_SKIDDING, testability=testability, small_leads=SmallLeads())
