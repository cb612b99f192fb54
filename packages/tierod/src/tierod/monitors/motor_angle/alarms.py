"""Alarms of the motor angle monitor: what each says, its remedy, its trouble code, and the decision that raises it."""

from __future__ import annotations

import math
from string import Formatter
from typing import Annotated, NamedTuple

from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine
from tierod.methods.detectors.stopping_rules import CusumRule
from tierod.monitors.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.motor_angle.comparison import (
    ANGLE_DRIFT,
    ANGLE_THRESHOLD,
    BACKWARDS,
    SPEED_DRIFT,
    SPEED_THRESHOLD,
    ElectricalChecks,
    NotFollowing,
    SensorComparison,
)
from tierod.monitors.motor_angle.plausibility import AnglePlausibility

# CUSUM of the NIS, one value per sample; three measurements have a mean of three, and the sum stays below 20 without a
# fault.
MODEL_DRIFT, MODEL_THRESHOLD = 8.0, 400.0
# Standard deviation of the residuals that the CUSUM of the angle is designed for; two and a half times the bench's.
BORNE: Annotated[float, "rad"] = 2.5 * 0.0066

ANGLE_DESIGN = RuleDesign(
    CusumRule(ANGLE_DRIFT / BORNE),
    values=300.0 * 3.6e6,
    shift=math.radians(5.0) / BORNE,
    spacing=1e-3,
    line=RunLengthLine(start=7.794, slope=14.55 * BORNE, observed=0.69 * 3.6e6),
)
"""Design of the CUSUM of the angle: counted on residuals scaled by two and a half, 239 and 13 alarms at 0.1 and 0.3 rad
in 0.69 h of turning (docs/explanation/motor-angle.md), and extrapolated to 0.9 rad."""

# Hours of 900 fault-free drives with wrong parameters: turning, and in total; docs/explanation/motor-angle.md.
TURNING, DRIVEN = Demonstrated(10.4), Demonstrated(15.0)

_SOURCE = (
    "fault-free drives on the bench, voltages measured, with wrong resistance, flux and inductance "
    "(docs/explanation/motor-angle.md); hours"
)
_UNSEEN = "set beyond what fault-free parts show; not demonstrated, because the bench's drives lack its signals"


class Alarm(NamedTuple):
    """An alarm with its meaning."""

    name: str  # name of its output
    code: str  # its trouble code
    reason: str  # its meaning in a few words
    cause: str  # its meaning
    action: str  # the remedy
    decision: Decision  # decision that raises it


def _decided(
    name: str,
    place: str,
    distance: str,
    rule: Cusum | tuple[type, str],
    statistic: str,
    levels: tuple[float, ...],
    demonstrated: Demonstrated | None = None,
    below: bool = False,
) -> Decision:
    """Decision of a part; its rule is a CUSUM, or a class whose fields fill the words."""
    stated: Cusum | OwnRule
    if isinstance(rule, tuple):
        part, words = rule
        values = {each: float(getattr(part, each)) for _, each, _, _ in Formatter().parse(words) if each}
        stated = OwnRule(words.format(**values), values)
    else:
        stated = rule
    source = _UNSEEN if demonstrated is None else f"{_SOURCE} {'of turning' if demonstrated is TURNING else 'driven'}"
    return Decision(
        name, distance, stated, f"block.{place}", None, demonstrated, source, "h", None, statistic, levels, below=below
    )


def _either(level: float) -> tuple[float, float]:
    return level, -level


ALARMS = (
    Alarm(
        "electrical.supply_low",
        "motor-supply-low",
        "supply voltage too low",
        "the supply of the controller is too low",
        "check battery, wiring and generator",
        _decided(
            "supply low",
            "electrical",
            "supply",
            (ElectricalChecks, "below {least_supply:g} V for {hold:g} s"),
            "supply_voltage",
            (ElectricalChecks.least_supply,),
            below=True,
        ),
    ),
    Alarm(
        "electrical.angle_timeout",
        "motor-angle-lost",
        "no readings of the angle arrive",
        "no readings of the motor's angle arrive",
        "check the sensor and its line",
        _decided(
            "angle lost",
            "electrical",
            "age of the last reading",
            (ElectricalChecks, "above {longest_gap:g} s"),
            "age_of_angle",
            (ElectricalChecks.longest_gap,),
            DRIVEN,
        ),
    ),
    Alarm(
        "electrical.resolver_amplitude",
        "motor-angle-amplitude",
        "sine or cosine has changed its amplitude",
        "the amplitude of the angle sensor's sine and cosine has changed",
        "check sensor, magnet and wiring: one of the two has lost amplitude or gained an offset",
        _decided(
            "resolver amplitude",
            "electrical",
            "amplitude of sine and cosine over that of the start, less one",
            (ElectricalChecks, "beyond {amplitude_margin:g} for {hold:g} s"),
            "change_of_resolver_amplitude",
            _either(ElectricalChecks.amplitude_margin),
        ),
    ),
    Alarm(
        "electrical.current_sum",
        "motor-currents",
        "phase currents do not sum to zero",
        "the phase currents do not add up to zero",
        "check the current sensors for an offset or a wrong gain, and the phases for a leak to ground",
        _decided(
            "current sum",
            "electrical",
            "sum of the phases",
            (ElectricalChecks, "beyond {greatest_sum:g} A for {hold:g} s"),
            "sum_of_phase_currents",
            _either(ElectricalChecks.greatest_sum),
        ),
    ),
    *(
        Alarm(
            f"electrical.{quantity}_saturated",
            "motor-currents",
            f"a {quantity} is saturated",
            f"a {quantity} stays constant at its peak while the motor turns: its measurement is saturated",
            f"widen the range of the {quantity} measurement",
            _decided(
                f"{quantity} saturated",
                "electrical",
                f"samples for which a {quantity} stays constant at its peak while the motor turns",
                (ElectricalChecks, f"{{same_samples:g}} samples beyond {{least_peak_{quantity}:g}} {unit}"),
                f"samples_of_a_still_{quantity}",
                (ElectricalChecks.same_samples,),
                DRIVEN,
            ),
        )
        for quantity, unit in (("current", "A"), ("voltage", "V"))
    ),
    Alarm(
        "model",
        "motor-currents",
        "currents and voltages contradict the motor's model",
        "currents and voltages contradict the model of the motor",
        "check sign and order of the phases of currents and voltages, the sampling time, and the motor's parameters",
        _decided(
            "model",
            "model",
            "normalised innovation squared of three measurements",
            Cusum(MODEL_DRIFT, MODEL_THRESHOLD, 2.0 * MODEL_THRESHOLD, "upper"),
            "innovation_sum",
            (MODEL_THRESHOLD,),
            DRIVEN,
        ),
    ),
    Alarm(
        "stuck",
        "motor-angle-stuck",
        "the angle sensor stands still",
        "the motor turns, but its angle sensor stands still",
        "replace the sensor",
        _decided(
            "stuck",
            "comparison",
            "travel of the observer while the sensor stands still",
            (SensorComparison, "more than {travel:g} rad within {still:g} rad of the sensor"),
            "turned_while_sensor_stood",
            _either(SensorComparison.travel),
            TURNING,
        ),
    ),
    Alarm(
        "backwards",
        "motor-angle-backwards",
        "the angle sensor turns backwards",
        "the angle sensor turns in the direction opposite to the motor: sine and cosine, or two phases, are swapped",
        "check wiring and channel map",
        _decided(
            "backwards",
            "comparison.backwards",
            "opposite signs of the changes of sensor and observer over 10 ms",
            Cusum(0.0, BACKWARDS, BACKWARDS, "upper"),
            "turned_backwards",
            (BACKWARDS,),
            TURNING,
        ),
    ),
    Alarm(
        "electrical.resolver_mismatch",
        "motor-angle-mismatch",
        "the angle contradicts its sine and cosine",
        "the motor's angle differs from the angle of its sensor's sine and cosine",
        "check the zero of the angle, its calibration, and the software between sensor and control",
        _decided(
            "resolver mismatch",
            "electrical",
            "angle less that of its own sine and cosine",
            (ElectricalChecks, "beyond {greatest_mismatch:g} rad for {hold:g} s"),
            "resolver_mismatch_electrical",
            _either(ElectricalChecks.greatest_mismatch),
        ),
    ),
    Alarm(
        "angle",
        "motor-angle-offset",
        "the angle sensor is off",
        "the angle sensor differs from the angle that currents and voltages give",
        "check the sensor's magnet and its zero",
        Decision(
            "angle",
            "sensor less observer, electrical, one value per millisecond [rad]; designed for a standard deviation of "
            f"{BORNE:.4f} rad",
            Cusum(ANGLE_DRIFT, ANGLE_THRESHOLD, 2.0 * ANGLE_THRESHOLD),
            "block.comparison.angle",
            300.0,
            TURNING,
            f"residuals scaled by 2.5, extrapolated; demonstrated: {_SOURCE} of turning",
            design=ANGLE_DESIGN,
            statistic="angle_residual_sum",
            levels=(ANGLE_THRESHOLD,),
        ),
    ),
    Alarm(
        "speed",
        "motor-angle-offset",
        "the angle sensor turns at another speed",
        "the angle sensor turns at another speed than currents and voltages give",
        "check the sensor: its gain, and whether it has lost readings",
        _decided(
            "speed",
            "comparison.speed",
            "change of the sensor over 10 ms less that of the observer [rad/s]",
            Cusum(SPEED_DRIFT, SPEED_THRESHOLD, 2.0 * SPEED_THRESHOLD),
            "speed_residual_sum",
            (SPEED_THRESHOLD,),
            TURNING,
        ),
    ),
    Alarm(
        "electrical.angle_gradient",
        "motor-angle-offset",
        "the angle jumps",
        "the motor's angle jumps further than the motor can turn between two readings",
        "check sensor and line",
        _decided(
            "angle leaps",
            "electrical",
            "change from one reading to the next",
            (ElectricalChecks, "beyond {greatest_speed:g} rad/s and {step_margin:g} rad"),
            "leap_of_angle",
            (1.0,),
            DRIVEN,
        ),
    ),
    Alarm(
        "not_following",
        "motor-angle-stuck",
        "the angle stays away from its target",
        "the motor's angle stays away from its target: the sensor is stuck, its zero far off or a phase wrong, the "
        "motor itself stands still, or target_motor_angle_mechanical is not the one that it follows",
        "check whether the motor turns; if it does, check the sensor, its zero, sine and cosine, and the target in the "
        "channel map with its time stamps",
        _decided(
            "not following",
            "not_following",
            "sensor less its target",
            (NotFollowing, "more than {widest:g} rad for {hold:g} s"),
            "following_error",
            _either(NotFollowing.widest),
            DRIVEN,
        ),
    ),
    Alarm(
        "plausibility",
        "steering-angles-implausible",
        "motor, steering wheel and pinion disagree",
        "the angles of motor, steering wheel and pinion do not fit each other",
        "check the sensors of these angles, and the gear's ratios in the vehicle file",
        _decided(
            "plausibility",
            "plausibility",
            "pinion less the angle from motor, steering wheel and torsion bar",
            (AnglePlausibility, "more than {greatest:g} rad for {hold:g} s"),
            "pinion_angle_mismatch",
            _either(AnglePlausibility.greatest),
        ),
    ),
)
"""Alarms from root cause to consequence; the kind of a statement is the position here, counted from 1. Variants on
commanded voltages decide alike, but only measured ones were tested so long."""

BY_NAME = {each.name: each for each in ALARMS}

# Alarms behind each trouble code.
CODES = {code: [each.name for each in ALARMS if each.code == code] for code in {each.code: None for each in ALARMS}}
