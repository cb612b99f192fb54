"""What the monitor of the motor's angle decides, and how its thresholds were designed."""

from __future__ import annotations

from typing import Annotated, Any

from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine
from tierod.methods.detectors.stopping_rules import CusumRule
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.motor_angle.comparison import ANGLE_DRIFT, ANGLE_THRESHOLD, SPEED_DRIFT, SPEED_THRESHOLD
from tierod.monitors.motor_angle.detector import MODEL_DRIFT, MODEL_THRESHOLD
from tierod.monitors.motor_angle.electrical import ElectricalChecks
from tierod.monitors.motor_angle.finding import FIVE_DEGREES
from tierod.monitors.motor_angle.plausibility import AnglePlausibility
from tierod.monitors.motor_angle.second_tests import Backwards, NotFollowing, Stuck

BORNE: Annotated[float, "rad"] = 2.5 * 0.0066
"""Standard deviation of the residuals that the sum of the angle is laid out for: two and a half times the bench's."""

ANGLE_DESIGN = RuleDesign(
    CusumRule(ANGLE_DRIFT / BORNE),
    values=300.0 * 3.6e6,
    shift=FIVE_DEGREES / BORNE,
    spacing=1e-3,
    line=RunLengthLine(start=7.794, slope=14.55 * BORNE, observed=0.69 * 3.6e6),
)
"""Counted on residuals that were made two and a half times as large, 239 and 13 alarms at 0.1 and 0.3 rad in 0.69 h of
turning (docs/explanation/motor-angle.md), and carried on to 0.9 rad."""

TURNING, DRIVEN = Demonstrated(10.4), Demonstrated(15.0)
"""Hours of 900 sound drives with parameters astray, turning and in all; docs/explanation/motor-angle.md, Monitoring."""

_SOURCE = (
    "sound drives on the bench, voltages measured, with resistance, flux and inductance astray "
    "(docs/explanation/motor-angle.md); hours of turning"
)


def _of(part: type[Any], told: str, *names: str) -> OwnRule:
    """The rule of a part, with the numbers that its class has."""
    values = {name: float(getattr(part, name)) for name in names}
    return OwnRule(told.format(**values), values)


def _decision(
    name: str,
    distance: str,
    rule: Any,
    place: str,
    statistic: str,
    levels: tuple[float, ...],
    demonstrated: Demonstrated | None = TURNING,
    below: bool = False,
) -> Decision:
    source = _SOURCE if demonstrated is TURNING else _SOURCE.replace("hours of turning", "hours driven")
    source = source if demonstrated else "what no sound part does; the bench's drives do not hold what it reads"
    return Decision(
        name, distance, rule, f"block.{place}", None, demonstrated, source, "h", None, statistic, levels, below=below
    )


def _electrical(
    name: str,
    distance: str,
    words: str,
    *names: str,
    statistic: str,
    levels: tuple[float, ...],
    demonstrated: Demonstrated | None = None,
    below: bool = False,
) -> Decision:
    rule = _of(ElectricalChecks, words, *names)
    return _decision(name, distance, rule, "electrical", statistic, levels, demonstrated, below)


def _either(level: float) -> tuple[float, float]:
    return level, -level


ANGLE = Decision(
    name="angle",
    distance=f"sensor less observer, electrical, one value in a millisecond [rad]; {BORNE:.4f} rad are one deviation "
    "of what is borne",
    rule=Cusum(ANGLE_DRIFT, ANGLE_THRESHOLD, 2.0 * ANGLE_THRESHOLD),
    place="block.comparison.angle",
    mean_time_between_false_alarms=300.0,
    demonstrated=TURNING,
    source=f"residuals made 2.5 times as large, carried on; shown: {_SOURCE}",
    design=ANGLE_DESIGN,
    statistic="angle_residual_sum",
    levels=(ANGLE_THRESHOLD,),
)

DECISIONS = (
    ANGLE,
    _decision(
        "speed",
        "what the sensor gains in 10 ms less what the observer gains [rad/s]",
        Cusum(SPEED_DRIFT, SPEED_THRESHOLD, 2.0 * SPEED_THRESHOLD),
        "comparison.speed",
        "speed_residual_sum",
        (SPEED_THRESHOLD,),
    ),
    _decision(
        "model",
        "normalised innovation squared of three measurements",
        Cusum(MODEL_DRIFT, MODEL_THRESHOLD, 2.0 * MODEL_THRESHOLD, "upper"),
        "model",
        "innovation_sum",
        (MODEL_THRESHOLD,),
        DRIVEN,
    ),
    _decision(
        "backwards",
        "sign of both gains over 10 ms, against each other",
        Backwards().sum,
        "comparison.backwards.sum",
        "turned_backwards",
        (Backwards.windows,),
    ),
    _decision(
        "stuck",
        "travel of the observer while the sensor stays where it is",
        _of(Stuck, "more than {travel:g} rad within {still:g} rad of the sensor", "travel", "still"),
        "comparison.stuck",
        "turned_while_sensor_stood",
        _either(Stuck.travel),
    ),
    _decision(
        "not following",
        "sensor less its target",
        _of(NotFollowing, "more than {widest:g} rad for {hold:g} s", "widest", "hold"),
        "not_following",
        "following_error",
        _either(NotFollowing.widest),
        DRIVEN,
    ),
    _decision(
        "plausibility",
        "pinion less what motor, steering wheel and torsion bar make of it",
        _of(AnglePlausibility, "more than {greatest:g} rad for {hold:g} s", "greatest", "hold"),
        "plausibility",
        "pinion_angle_mismatch",
        _either(AnglePlausibility.greatest),
        None,
    ),
    _electrical(
        "supply low",
        "supply",
        "below {least_supply:g} V for {hold:g} s",
        "least_supply",
        "hold",
        statistic="supply_voltage",
        levels=(ElectricalChecks.least_supply,),
        below=True,
    ),
    _electrical(
        "angle lost",
        "age of the last reading",
        "above {longest_gap:g} s",
        "longest_gap",
        statistic="age_of_angle",
        levels=(ElectricalChecks.longest_gap,),
        demonstrated=DRIVEN,
    ),
    _electrical(
        "angle leaps",
        "change from one reading to the next",
        "beyond {greatest_speed:g} rad/s and {step_margin:g} rad",
        "greatest_speed",
        "step_margin",
        statistic="leap_of_angle",
        levels=(1.0,),
        demonstrated=DRIVEN,
    ),
    _electrical(
        "resolver amplitude",
        "amplitude of sine and cosine over that of the start, less one",
        "beyond {amplitude_margin:g} for {hold:g} s",
        "amplitude_margin",
        "hold",
        statistic="change_of_resolver_amplitude",
        levels=_either(ElectricalChecks.amplitude_margin),
    ),
    _electrical(
        "resolver mismatch",
        "angle less that of its own sine and cosine",
        "beyond {greatest_mismatch:g} rad for {hold:g} s",
        "greatest_mismatch",
        "hold",
        statistic="resolver_mismatch_electrical",
        levels=_either(ElectricalChecks.greatest_mismatch),
    ),
    _electrical(
        "current sum",
        "sum of the phases",
        "beyond {greatest_sum:g} A for {hold:g} s",
        "greatest_sum",
        "hold",
        statistic="sum_of_phase_currents",
        levels=_either(ElectricalChecks.greatest_sum),
    ),
    *(
        _electrical(
            f"{quantity} saturated",
            f"samples for which a {quantity} stands still at its peak, while the motor turns",
            f"{{same_samples:g}} samples beyond {{least_peak_{quantity}:g}} {unit}",
            "same_samples",
            f"least_peak_{quantity}",
            statistic=f"samples_of_a_still_{quantity}",
            levels=(ElectricalChecks.same_samples,),
            demonstrated=DRIVEN,
        )
        for quantity, unit in (("current", "A"), ("voltage", "V"))
    ),
)
"""Of every variant: those fed with commands decide alike, but only measured voltages were driven for so long."""
