"""Result on friction after a recording, in words: notices beside the verdict, and obstacles to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from tierod.core.findings import Status
from tierod.core.statement import STATUSES
from tierod.methods.relations import WRONG_SIGN_SHARE
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.decisions import AlarmTuning
from tierod.monitors.friction.judged import FrictionFigures, JudgedFriction, Obstacles
from tierod.monitors.friction.verdict import FrictionLimits, FrictionVerdict
from tierod.monitors.harness.verdict import Obstacle

GAIN_WARNING = (
    "a gain error common to both torques scales the estimate and cannot be detected: 10 % of torque gives 10 % of "
    "friction. The standard deviation includes {share} of it ({source}); it cancels in the ratio to the baseline"
)

RIGID_WARNING = (
    "the vehicle file gives no torsion_bar_stiffness, so the column is assumed rigid: with a bar of 140 N·m/rad the "
    "estimate is then right at 4 N·m and 0.2 to 0.5 N·m too high at 12.5 N·m, and the build-up angle is too long"
)

SMALLEST_LEVEL = 0.8
"""Share of the baseline below which friction is reported to have fallen [-]; fault-free drives stayed above 0.9."""

SMALLEST_PRESENCE = 0.8
"""Share of the recording with all signals present below which a notice is given [-]; whole recordings have 0.99 and
more."""

LARGEST_DAMPING = 1.75
"""Multiple of the vehicle file's damping below the torsion bar from which yaw rate and lateral acceleration are
suspected to be late [-]. A delay of 200 ms adds 1.1 N*m*s/rad to 0.6, simulated; one in ten cars whose own damping
scatters by 40 % exceeds it too."""

LARGEST_INERTIA = 2.5
"""Multiple of the vehicle file's inertia below the torsion bar from which the angle is suspected to be late [-]; a
delay of 100 ms gives 2.9 to 3.6, cars whose own inertia scatters by 30 % at most 1.9, unknown friction laws 2.4,
simulated."""

LARGEST_ALIGNING = 2.5
"""Factor on the self-aligning torque, or its reciprocal, from which the vehicle file is doubted [-]; 3 of 120 cars
whose trail scatters by 30 % exceed it, simulated."""

ONE_SIDED = 0.2
"""Share of the enabled time in turns to one side below which offsets may leak into friction [-]; an offset then acts
with at least three fifths of its magnitude."""

OPPOSED = 0.1
"""Share of the worked time with opposed driver and motor torques from which a notice is given [-]; ten times that of
fault-free driving, a third of what withholds the verdict."""


@dataclass(frozen=True)
class FrictionRun:
    """Result of a friction monitor after a recording.

    Args:
        monitor: name of monitor and variant
        verdict: the verdict block that ran
        judged: its output after the last sample
        start_time: time of the first sample in the recording [s]
        evidence: further named quantities of the estimator, with unit in the name
        parameters: parameters of the vehicle file as the estimator assumes them; None where unknown
    """

    monitor: str
    verdict: FrictionVerdict
    judged: JudgedFriction
    start_time: float = 0.0
    evidence: Mapping[str, float] = field(default_factory=dict)
    parameters: FrictionParameters | None = None

    @property
    def friction(self) -> float:
        """Estimated friction [N*m]."""
        return self.judged.statement.magnitude

    @property
    def limits(self) -> FrictionLimits:
        """Limits of the vehicle file; without them the torques are raw counts, and the verdict is withheld."""
        assert self.verdict.limits is not None
        return self.verdict.limits


def notices(run: FrictionRun) -> tuple[str, ...]:
    """All warnings about a run with a verdict."""
    found = [_gains(run), *_levels(run), *_bar(run), *_delays(run), *_signals(run)]
    return tuple(found)


def _gains(run: FrictionRun) -> str:
    """Notice on the gain that both torques share, and on the spread that is assumed for it."""
    deviation = run.verdict.tuning.gain_deviation
    source = "torque_gain_deviation of the vehicle file" if run.verdict.gain_given else "assumed"
    return GAIN_WARNING.format(share=f"{100.0 * deviation:.2g} %", source=source)


def _levels(run: FrictionRun) -> list[str]:
    if run.judged.known_level > 0.0:
        return []
    return ["the baseline is not learnt (too little time, or friction above its limit): only the absolute limits apply"]


def _bar(run: FrictionRun) -> list[str]:
    """Notice on a missing torsion bar stiffness, for the only estimator that models the bar and learns a Dahl angle."""
    if run.parameters is None or "dahl_angle_rad" not in run.evidence:
        return []
    return [] if math.isfinite(run.parameters.torsion_bar_stiffness) else [RIGID_WARNING]


def _delays(run: FrictionRun) -> list[str]:
    """Notices on late signals, concluded from the learnt constants of the steering."""
    warnings = []
    inertia, damping = run.evidence.get("inertia_kgm2", 0.0), run.judged.fit.damping
    if inertia < 0.0:
        warnings.append(
            f"the learnt inertia is negative ({inertia:.3f} kg·m²): a signal is probably late. Torques that are 50 ms "
            "late lower the friction estimate by 0.2 to 0.4 N·m, 100 ms by 0.5 to 0.8 N·m; a lateral acceleration "
            "that is 0.5 s late raises it by 0.9 to 1.9 N·m"
        )
    if run.parameters is not None:
        below = run.parameters.below_bar
        if inertia > LARGEST_INERTIA * below.inertia:
            warnings.append(
                f"the learnt inertia is {inertia / below.inertia:.1f} times that of the vehicle file: the angle is "
                "probably about 100 ms later than the torques, and the friction estimate slightly too high"
            )
        if damping > LARGEST_DAMPING * below.damping:
            warnings.append(
                f"the learnt damping is {damping / below.damping:.1f} times that of the vehicle file: either this car "
                "has more damping, or yaw rate and lateral acceleration are late; a delay of 200 ms raises the "
                "friction estimate by 0.5 to 0.6 N·m"
            )
    if not 1.0 / LARGEST_ALIGNING < run.judged.fit.aligning_gain < LARGEST_ALIGNING:
        warnings.append(
            f"the self-aligning torque is {run.judged.fit.aligning_gain:.2f} times the value from the vehicle file: "
            "check that mass, trail and steering ratio belong to this car"
        )
    return warnings


def _signals(run: FrictionRun) -> list[str]:
    figures, warnings = run.judged.figures, []
    present = figures.settled_seconds / figures.seconds
    if present < SMALLEST_PRESENCE:
        warnings.append(
            f"signals were missing, or had just come back, for {1.0 - present:.0%} of the recording: the verdict "
            "covers only the rest"
        )
    left = figures.left_seconds / figures.enabled_seconds
    if not ONE_SIDED < left < 1.0 - ONE_SIDED:
        warnings.append(
            f"{left:.0%} of the enabled time was spent in left turns: sensor offsets may bias the friction estimate"
        )
    if figures.worked_seconds > 0.0 and figures.opposed_seconds > OPPOSED * figures.worked_seconds:
        share = figures.opposed_seconds / figures.worked_seconds
        warnings.append(
            f"driver and motor torque opposed each other for {share:.0%} of the time in which the driver turned the "
            "wheel: check whether lane keeping was active"
        )
    return warnings


Words = tuple[str, str, str]
"""Cause, action, and the cause in a few words."""


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
        "signals were never all present",
    )


def _raw_counts(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        "the torques are raw counts, not N·m, so friction has no unit and no nominal value",
        "give the torque per count in the channel map (calibrate against a torque wrench or a lock-to-lock recording)",
        "the torques are raw counts",
    )


def _opposed(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    share = judged.figures.opposed_seconds / judged.figures.worked_seconds
    if share > WRONG_SIGN_SHARE:
        return (
            f"driver and motor torque have opposite signs for {share:.0%} of the time in which the driver turned the "
            "wheel: one of them has the wrong sign",
            "check the signs in the channel map: both are positive towards the left",
            "one torque has the wrong sign",
        )
    return (
        f"driver and motor torque act against each other for {share:.0%} of the time in which the driver turned the "
        "wheel, as under lane keeping",
        "record with lane keeping and other steering functions switched off",
        "driver and motor oppose each other",
    )


def _too_little_time(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    enabled = judged.figures.enabled_seconds
    closed_by, remedy = _closing_condition(judged.figures)
    if enabled <= 0.0:
        never = "the enabling conditions never held"
        return f"{never} at the same time: {closed_by}", remedy, never
    return (
        f"the enabling conditions held for {enabled:.1f} s only, {tuning.ready_time:.0f} s are needed: {closed_by}",
        f"record longer; {remedy}",
        f"{enabled:.0f} of {tuning.ready_time:.0f} s needed",
    )


def _closing_condition(figures: FrictionFigures) -> tuple[str, str]:
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
        f"the {what} is negative",
    )


def _damping(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the learnt damping is {judged.fit.damping:.1f} N·m·s/rad, too low for any steering: the signals contradict "
        "each other",
        "check the sign of the steering wheel rate against the angle, the units of yaw rate (rad/s) and lateral "
        "acceleration (m/s²), and the delays between the signals",
        "the signals contradict each other",
    )


def _aligning(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the self-aligning torque is {judged.fit.aligning_gain:.2f} times the value from the vehicle file; a wrong "
        "trail explains only factors from 1/3 to 3",
        "check the units of yaw rate (rad/s) and lateral acceleration (m/s²), and whether the vehicle file (mass, "
        "trail, steering ratio) belongs to this car",
        "the self-aligning torque does not fit",
    )


def _unfit(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the torque balance does not fit: its residual is {judged.fit.residual:.1f} N·m (root mean square)",
        "check with 'tierod inspect' for a signal that is stuck, has the wrong sign or unit (rad, rad/s, m/s², N·m), "
        "or is late, and whether the vehicle file belongs to this car",
        "the torque balance does not fit",
    )


def _short_strokes(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    return (
        f"the strokes of the steering wheel are shorter than friction needs to build up (mean build-up "
        f"{judged.fit.excitation:.0%}), so friction cannot be distinguished from stiffness",
        "drive bends with strokes of several degrees: city or country roads",
        "the steering strokes are too short",
    )


def _uncertain(judged: JudgedFriction, tuning: AlarmTuning) -> Words:
    share, misfit = judged.fit.friction_deviation / judged.statement.magnitude, judged.fit.misfit
    fit = f", and the torque balance fits {misfit:.1f} times worse than expected" if misfit > 1.5 else ""
    return (
        f"the standard deviation is {share:.0%} of the friction, above {tuning.largest_deviation:.0%}{fit}",
        "record longer on bends; if that does not help, check the vehicle file and the delays between the signals",
        f"the standard deviation is {share:.0%} of it",
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
