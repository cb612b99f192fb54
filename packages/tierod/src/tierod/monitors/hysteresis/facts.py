"""Judgement of a lock-to-lock test: increase of friction over the fault-free car, and the assist beside its map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.facts import Fact, defect
from tierod.core.findings import Status
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.detectors.rule_design import RuleDesign, alarms_at
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.methods.identification.hysteresis import HysteresisFriction
from tierod.methods.identification.lock_to_lock import noise_left, noise_of, smoothed
from tierod.monitors.baseline import Baseline
from tierod.monitors.decision import Decision, Demonstrated
from tierod.monitors.friction.evidence import BOTH, AssistCharacteristic, GainLimits
from tierod.physics.steering import assist_torque, column_torque_of_motor
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import GAIN_DEVIATION

LEAST_SAMPLES = 300  # least number of samples, three seconds of the test
# Noise of the driver's torque over its own variation above which the torques are not compared; it moves the ratio by 6
# % of the quadratic part.
NOISY = 0.25


def torque_defects(
    time: np.ndarray,
    driver_torque: np.ndarray,
    motor_torque: np.ndarray,
    vehicle: Vehicle,
    limits: GainLimits | None = None,
) -> tuple[Fact, ...]:
    """Defects where the motor does not assist as in this car type at standstill; none where the file has no map.

    Args:
        driver_torque, motor_torque: torques of a standing car [N*m], (n,); NaN where missing
    """
    limits = limits or GainLimits()
    p = AssistCharacteristic.of(vehicle)
    used = np.isfinite(driver_torque) & np.isfinite(motor_torque)
    if p is None or np.count_nonzero(used) < LEAST_SAMPLES:
        return ()
    time = time[used]
    driver, motor = (smoothed(each[used], time) for each in (driver_torque, motor_torque))
    # The assist is quadratic: with noise of the driver's torque the motor would seem to give too little.
    if noise_left(noise_of(driver_torque[used], time), time) > NOISY * float(np.std(driver)):
        return ()
    motor = column_torque_of_motor(motor, p.motor_ratio)
    usual = assist_torque(driver, 0.0, p.assist_linear_gain, p.assist_quadratic_gain, 0.0, p.assist_half_speed, np.inf)
    power = float(usual @ usual)
    if not max(power, float(motor @ motor)) > limits.smallest**2 * len(usual):
        return ()
    ratio = float(usual @ motor) / power if power > 0.0 else np.inf
    if 1.0 / limits.ratio < ratio < limits.ratio:
        return ()
    sentence = (
        "driver_torque or motor_torque has a wrong gain, or the assist map of the vehicle file is that of another car: "
        f"the motor gives {ratio:.2f} times what the map gives at rest"
    )
    return (defect(BOTH, sentence),)


# One decision per test.
INCREASE_DESIGN = RuleDesign(HoldRule(1, sides="upper"), values=1000.0, shift=8.0, spacing=math.inf)

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
    """Limits of an increase over the fault-free loop, named as in a vehicle file."""

    # Limits, whose distances from nominal judge an increase.
    nominal_friction: Annotated[float, "N*m"]
    rising_friction: Annotated[float, "N*m"]
    fault_friction: Annotated[float, "N*m"]

    @property
    def to_fault(self) -> float:
        """Increase from which it is a fault [N m]."""
        return self.fault_friction - self.nominal_friction

    def status(self, above_nominal: float, deviation: float, rule: HeldThreshold) -> Status:
        """Status of a friction above the base level; suspect where it exceeds a limit but may do so by chance."""
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
    """Friction above that of the fault-free car."""

    value: float  # friction above the reference [N m]
    reference: str  # name of the reference
    base: float  # friction of the reference [N m]
    # Standard deviations [N m] by cause that the monitor itself judges, and names; damping and gains are left to the
    # interval of the friction where there is no baseline.
    parts: dict[str, float]
    fault_free_deviation: float  # standard deviation of the increase if the car is fault-free [N m]

    @property
    def deviation(self) -> float:
        """Standard deviation by the parts together [N m]."""
        return math.hypot(*self.parts.values())


SCATTER, FAULT_FREE_TEST = "scatter of the loops", "fault-free test"
RATE, GAIN = "rate of turning", GAIN_DEVIATION  # parts of the deviation of an increase


def over_baseline(found: HysteresisFriction, known: Baseline, gain: float) -> Increase:
    """Increase over a fault-free test of the same car, with the same damping and the same gains of the torques.

    Args:
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
        gain: relative standard deviation of the torques' gain, which scales the whole friction [-]
    """
    value = found.friction_torque - nominal
    own = math.hypot(found.standard_deviation, nominal_deviation)
    # A fault-free car reads its own friction times the gain: that scatter decides whether an increase is chance.
    fault_free = math.hypot(own, gain * nominal)
    return Increase(value, "nominal", nominal, {SCATTER: found.independent_deviation}, fault_free)
