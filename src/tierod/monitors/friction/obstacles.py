"""What can stand in the way of a verdict on friction: each with its cause and the remedy, in words."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.findings import Status
from tierod.monitors.friction.verdict_state import FrictionFigures, VerdictSample
from tierod.monitors.friction.verdict_tuning import AlarmTuning

OPPOSED_SHARE = 0.3
"""Share of worked time with driver and motor against each other above which lane keeping is taken to be active. Sound
driving has below 0.01 (simulated); a recorded minute under lane keeping has 0.47."""

WRONG_SIGN_SHARE = 0.9
"""Share above which a wrong sign of one torque is likelier than lane keeping."""


class Obstacle(NamedTuple):
    """A reason to withhold the verdict."""

    status: Status
    cause: str
    action: str


def obstacles(figures: FrictionFigures, last: VerdictSample, tuning: AlarmTuning, calibrated: bool) -> list[Obstacle]:
    """Every reason to withhold the verdict, the decisive one first.

    Args:
        figures: of the run
        last: the estimate after its last sample
        tuning: of the verdict
        calibrated: whether the torques are in N*m
    """
    if figures.settled_seconds <= 0.0:
        return [
            Obstacle(
                Status.NOT_AVAILABLE,
                "never were all signals present together for the settling time",
                "check with 'tierod inspect' which signal is missing, and the channel map",
            )
        ]
    found = [_uncalibrated(calibrated), _opposed(figures), _too_little_time(figures, tuning)]
    if figures.enabled_seconds >= tuning.ready_time:
        found += [_bad_sign(last), _contradiction(last, tuning), _strange_aligning(last, tuning)]
        found += [_unfit(figures, last, tuning), _short_strokes(last, tuning), _uncertain(last, tuning)]
    return [obstacle for obstacle in found if obstacle is not None]


def _uncalibrated(calibrated: bool) -> Obstacle | None:
    if calibrated:
        return None
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        "the torques are raw counts, not N·m, so friction has no unit and no nominal value",
        "give the torque per count in the channel map (calibrate against a torque wrench or a lock-to-lock recording)",
    )


def _opposed(figures: FrictionFigures) -> Obstacle | None:
    share = figures.opposed_seconds / figures.worked_seconds if figures.worked_seconds > 0.0 else 0.0
    if share <= OPPOSED_SHARE:
        return None
    if share > WRONG_SIGN_SHARE:
        return Obstacle(
            Status.NOT_IDENTIFIABLE,
            f"driver and motor torque have opposite signs {share:.0%} of the time that the wheel was worked: one of "
            "them has the wrong sign",
            "check the signs in the channel map: both are positive towards the left",
        )
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        f"driver and motor torque act against each other {share:.0%} of the time that the wheel was worked, as under "
        "lane keeping",
        "record with lane keeping and other steering functions switched off",
    )


def _too_little_time(figures: FrictionFigures, tuning: AlarmTuning) -> Obstacle | None:
    if figures.enabled_seconds >= tuning.ready_time:
        return None
    blame, remedy = _closing_condition(figures)
    if figures.enabled_seconds <= 0.0:
        return Obstacle(Status.NOT_ENABLED, f"the enabling conditions never held together: {blame}", remedy)
    return Obstacle(
        Status.NOT_READY,
        f"only {figures.enabled_seconds:.1f} s enabled of {tuning.ready_time:.0f} s needed: {blame}",
        f"record longer; {remedy}",
    )


def _closing_condition(figures: FrictionFigures) -> tuple[str, str]:
    """What kept the gate closed, largest share first, and what to do about the first."""
    whole = figures.seconds
    causes = [
        (
            1.0 - figures.settled_seconds / whole,
            "signals were missing or had just come back",
            "look for gaps with 'tierod inspect'",
        ),
        (
            figures.slow_seconds / whole,
            "the vehicle stood or crept",
            "drive faster than walking pace, or judge a lock-to-lock test with --monitor hysteresis",
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
    named = [f"{text} {share:.0%} of the recording" for share, text, _ in causes if share >= 0.005]
    return "; ".join(named) or "the recording is short", causes[0][2]


def _bad_sign(last: VerdictSample) -> Obstacle | None:
    if last.friction_torque > 0.0 and last.aligning_gain > 0.0:
        return None
    what = "friction" if last.friction_torque <= 0.0 else "self-aligning torque"
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        f"the estimated {what} is negative, which no steering has: a signal has the wrong sign",
        "check the signs in the channel map; in a left turn angle, yaw rate, lateral acceleration and both torques are "
        "positive",
    )


def _contradiction(last: VerdictSample, tuning: AlarmTuning) -> Obstacle | None:
    if last.damping > tuning.smallest_damping:
        return None
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        f"the learnt damping is {last.damping:.1f} N·m·s/rad, which no steering has: the signals contradict each other",
        "check the sign of the steering wheel rate against the angle, the units of yaw rate (rad/s) and lateral "
        "acceleration (m/s²), and the delays between the signals",
    )


def _strange_aligning(last: VerdictSample, tuning: AlarmTuning) -> Obstacle | None:
    gain, factor = last.aligning_gain, tuning.largest_aligning_factor
    if gain <= 0.0 or 1.0 / factor < gain < factor:
        return None
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        f"the self-aligning torque is {gain:.2f} times what the vehicle file expects; a wrong trail explains 1/3 to 3",
        "check the units of yaw rate (rad/s) and lateral acceleration (m/s²), and whether the vehicle file (mass, "
        "trail, steering ratio) belongs to this car",
    )


def _unfit(figures: FrictionFigures, last: VerdictSample, tuning: AlarmTuning) -> Obstacle | None:
    if figures.unfit_seconds < tuning.unfit_time:
        return None
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        f"the torque balance does not fit: it leaves {last.residual:.1f} N·m open (root mean square)",
        "check with 'tierod inspect' for a signal that is stuck, has the wrong sign or unit (rad, rad/s, m/s², N·m), "
        "or comes late, and whether the vehicle file belongs to this car",
    )


def _short_strokes(last: VerdictSample, tuning: AlarmTuning) -> Obstacle | None:
    if last.excitation > tuning.smallest_excitation:
        return None
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        f"the strokes of the steering wheel are shorter than friction needs to build up (mean build-up "
        f"{last.excitation:.0%}), so friction cannot be told from stiffness",
        "drive bends with strokes of several degrees: city or country roads",
    )


def _uncertain(last: VerdictSample, tuning: AlarmTuning) -> Obstacle | None:
    if last.friction_torque <= 0.0 or last.friction_deviation <= tuning.largest_deviation * last.friction_torque:
        return None
    share = last.friction_deviation / last.friction_torque
    fit = f", and the torque balance fits {last.misfit:.1f} times worse than expected" if last.misfit > 1.5 else ""
    return Obstacle(
        Status.NOT_IDENTIFIABLE,
        f"the standard deviation is {share:.0%} of the friction, above {tuning.largest_deviation:.0%}{fit}",
        "record longer on bends; if that does not help, check the vehicle file and the delays between the signals",
    )
