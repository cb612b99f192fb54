"""The bank for a car whose torques nobody knows: wheel speeds, yaw rate and steering angle, judged by its motion."""

from __future__ import annotations

from dataclasses import replace

from tierod.core.graph import Bank
from tierod.models.rolling_car import Wander
from tierod.monitors.condition.bank.decision import Decision
from tierod.monitors.condition.bank.judge import ConditionJudge
from tierod.monitors.condition.bank.rolling_filter import JUDGED, RollingFilter
from tierod.monitors.condition.bank.testability import Telling
from tierod.monitors.condition.bank.tuning import prices
from tierod.monitors.condition.bank.weighing import Limits, Weighing
from tierod.monitors.condition.kinds.kind import KindOfFault
from tierod.monitors.condition.signals import SENSORS, Hypothesis, hypotheses
from tierod.monitors.condition.substitutes import ON_CARS
from tierod.vehicles import Vehicle

WHEELS, OTHERS, SLOW = 9.0, 2.3, 0.45
"""Limits of hypotheses with and without wheels, over the short time, and of all over the long one [nat].

As `limits` designs them, 1.5 times what lies 2 (long: 1) nat above the largest healthy ratio and at least 0.5 (0.3):
bumps reach 4.0 in the first half of a highway minute of a RAV4, all else -0.5 in 9 s of another car's tight bends, and
the long time -1.5.
"""
GAP, MARGIN = 2.0, 1.0
"""As those of the bank of the whole vehicle."""
ALIKE = 2.0 * Wander().steering
"""Errors of predictions count once in so long a time [s]: those of the steering's ratio fade so slowly."""


def rolling_hypotheses() -> tuple[Hypothesis, ...]:
    """Healthy, and one or two of the sensors that cars have; not both wheels, without which nobody knows the speed."""
    known = [each for each in hypotheses() if not each.actuators and set(each.sensors) <= set(JUDGED)]
    return tuple(each for each in known if each.sensors != JUDGED[:2])


def rolling_limits() -> Limits:
    """Limits of all hypotheses but healthy."""
    suspected = rolling_hypotheses()[1:]
    fast = (WHEELS if any(name.startswith("wheel_speed") for name in each.sensors) else OTHERS for each in suspected)
    return Limits(tuple(fast), (SLOW,) * len(suspected), GAP, MARGIN)


def rolling_bank(vehicle: Vehicle, limits: Limits | None = None, sample_time: float = 0.01) -> Bank:
    """One filter per hypothesis, and the judge.

    Args:
        vehicle: with the parameters of `RollingCar`
        limits: for all hypotheses but healthy; those of real cars if None
        sample_time: [s]
    """
    base, explanations = RollingFilter.of_vehicle(vehicle, sample_time), rolling_hypotheses()
    kinds = tuple(
        replace(
            KindOfFault.of_sensor(name, base.plausible, sample_time), unknown=ON_CARS[name], alike=ALIKE, lasting=ALIKE
        )
        for name in SENSORS
    )
    lanes = tuple(base.leaving_out(each.sensors) for each in explanations)
    costs = prices(base.sensor_noise, base.plausible)
    weighing = Weighing(explanations, limits or rolling_limits(), sample_time, prices=costs)
    # What is never there must not widen the limits that were found without it.
    return Bank(lanes, ConditionJudge(Decision(weighing, testability=Telling(poorer=1.0)), kinds))
