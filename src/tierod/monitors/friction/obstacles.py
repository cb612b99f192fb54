"""Obstacles to a verdict on friction, in words: their cause and the remedy."""

from __future__ import annotations

from collections.abc import Callable

from tierod.core.findings import Status
from tierod.core.statement import STATUSES
from tierod.monitors.friction.judged import FrictionFigures, JudgedFriction, Obstacles
from tierod.monitors.friction.verdict_tuning import AlarmTuning
from tierod.monitors.harness.related_signals import WRONG_SIGN_SHARE
from tierod.monitors.harness.verdict import Obstacle

Words = tuple[str, str]
"""Cause and action."""


def obstacles(judged: JudgedFriction, tuning: AlarmTuning) -> list[Obstacle]:
    """Every obstacle to the verdict that the block found, the decisive one first.

    Args:
        judged: verdict after the last sample
        tuning: tuning of the verdict
    """
    held = [name for name, there in zip(Obstacles._fields, judged.obstacles, strict=True) if there > 0.5]
    decisive = STATUSES[round(judged.statement.status)]
    statuses = dict.fromkeys(held, Status.NOT_IDENTIFIABLE) | dict.fromkeys(held[:1], decisive)
    return [Obstacle(statuses[name], *_WORDS[name](judged, tuning)) for name in held]


def _no_signals(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        "the signals were never all present at once for the settling time",
        "find the missing signal with 'tierod inspect', and check the channel map",
    )


def _raw_counts(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        "the torques are raw counts, not N·m, so friction has no unit and no nominal value",
        "give the torque per count in the channel map (calibrate against a torque wrench or a lock-to-lock recording)",
    )


def _opposed(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    share = judged.figures.opposed_seconds / judged.figures.worked_seconds
    if share > WRONG_SIGN_SHARE:
        return (
            f"driver and motor torque have opposite signs for {share:.0%} of the time in which the driver turned the "
            "wheel: one of them has the wrong sign",
            "check the signs in the channel map: both are positive towards the left",
        )
    return (
        f"driver and motor torque act against each other for {share:.0%} of the time in which the driver turned the "
        "wheel, as under lane keeping",
        "record with lane keeping and other steering functions switched off",
    )


def _too_little_time(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    enabled = judged.figures.enabled_seconds
    closed_by, remedy = _closing_condition(judged.figures)
    if enabled <= 0.0:
        return f"the enabling conditions never held at the same time: {closed_by}", remedy
    return (
        f"the enabling conditions held for {enabled:.1f} s only, {tuning.ready_time:.0f} s are needed: {closed_by}",
        f"record longer; {remedy}",
    )


def _closing_condition(figures: FrictionFigures) -> Words:
    """Conditions that kept the gate closed, largest share first, and the remedy for the first."""
    whole = figures.seconds
    causes = [
        (
            1.0 - figures.settled_seconds / whole,
            "signals were missing or had just come back",
            "look for gaps with 'tierod inspect'",
        ),
        (
            figures.slow_seconds / whole,
            "the vehicle stood or rolled slowly",
            "drive faster than walking pace, or judge a lock-to-lock test with the monitor hysteresis (variant hoist "
            "or ground)",
        ),
        (
            figures.hands_off_seconds / whole,
            "the driver's torque was too small",
            "drive bends by hand, without steering functions",
        ),
        (
            figures.still_seconds / whole,
            "the steering wheel hardly turned",
            "drive bends: city or country roads, not a motorway",
        ),
        (figures.opposed_seconds / whole, "driver and motor opposed each other", "switch lane keeping off"),
    ]
    causes.sort(key=lambda cause: -cause[0])
    named = [f"{text} for {share:.0%} of the recording" for share, text, _ in causes if share >= 0.005]
    return "; ".join(named) or "the recording is short", causes[0][2]


def _negative(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    what = "friction" if judged.statement.magnitude <= 0.0 else "self-aligning torque"
    return (
        f"the estimated {what} is negative, which is physically impossible: a signal has the wrong sign",
        "check the signs in the channel map; in a left turn angle, yaw rate, lateral acceleration and both torques are "
        "positive",
    )


def _damping(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the learnt damping is {judged.fit.damping:.1f} N·m·s/rad, too low for any steering: the signals contradict "
        "each other",
        "check the sign of the steering wheel rate against the angle, the units of yaw rate (rad/s) and lateral "
        "acceleration (m/s²), and the delays between the signals",
    )


def _aligning(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the self-aligning torque is {judged.fit.aligning_gain:.2f} times the value from the vehicle file; a wrong "
        "trail explains only factors from 1/3 to 3",
        "check the units of yaw rate (rad/s) and lateral acceleration (m/s²), and whether the vehicle file (mass, "
        "trail, steering ratio) belongs to this car",
    )


def _unfit(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the torque balance does not fit: its residual is {judged.fit.residual:.1f} N·m (root mean square)",
        "check with 'tierod inspect' for a signal that is stuck, has the wrong sign or unit (rad, rad/s, m/s², N·m), "
        "or is late, and whether the vehicle file belongs to this car",
    )


def _short_strokes(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the strokes of the steering wheel are shorter than friction needs to build up (mean build-up "
        f"{judged.fit.excitation:.0%}), so friction cannot be distinguished from stiffness",
        "drive bends with strokes of several degrees: city or country roads",
    )


def _uncertain(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    share, misfit = judged.fit.friction_deviation / judged.statement.magnitude, judged.fit.misfit
    fit = f", and the torque balance fits {misfit:.1f} times worse than expected" if misfit > 1.5 else ""
    return (
        f"the standard deviation is {share:.0%} of the friction, above {tuning.largest_deviation:.0%}{fit}",
        "record longer on bends; if that does not help, check the vehicle file and the delays between the signals",
    )


_WORDS: dict[str, Callable[[JudgedFriction, AlarmTuning], Words]] = {
    "no_signals": _no_signals,
    "raw_counts": _raw_counts,
    "opposed": _opposed,
    "too_little_time": _too_little_time,
    "negative": _negative,
    "damping": _damping,
    "aligning": _aligning,
    "unfit": _unfit,
    "short_strokes": _short_strokes,
    "uncertain": _uncertain,
}
"""Function that gives cause and action of each field of `Obstacles`."""
