"""The verdict on friction after a recording: the facts behind it, and the words of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated

from tierod.core.facts import Fact, Verdict
from tierod.core.findings import Estimate, Status
from tierod.core.statement import STATUSES
from tierod.methods.relations import WRONG_SIGN_SHARE
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.thresholds import ABSOLUTE, BASELINE, AlarmTuning
from tierod.monitors.friction.verdict import (
    BY_LIMIT,
    FrictionFigures,
    FrictionLimits,
    FrictionVerdict,
    JudgedFriction,
    Obstacles,
)
from tierod.monitors.harness.verdict import Obstacle, withheld
from tierod.vehicles.uncertain import GainDeviation

PLACE = "friction torque at the steering wheel axis"

CLOSE = 0.9
"""Share of the fault limit from which rising friction is reported as close to it [-]; 0.9 leaves 0.4 of the way from
1.2 to 1.6 times the baseline."""

SMALLEST_NOMINAL = 0.7
"""Share of nominal friction below which the torques or the vehicle file are doubted [-]: four standard deviations of
the common torque gain below 1; halved motor torques give 0.64 to 0.68, simulated."""

TOO_LOW = (
    "the gains of driver_torque and motor_torque or motor_ratio may be too low, or the vehicle file is that of another "
    "car; a fault may then be judged healthy"
)
"""What a friction far below that of a fault-free car means."""

SETTLE = (
    "calibrate driver_torque and motor_torque, judge against this car's baseline from an earlier fault-free drive, or "
    "measure the friction in a lock-to-lock test"
)


def verdict_of_run(run: FrictionRun) -> Verdict:
    """The last statement of the block as a verdict.

    Args:
        run: result after the last sample

    Returns:
        healthy, rising, fault; suspect where an alarm has ended, or friction exceeded a limit too late to be confirmed;
        or why no verdict is possible: not available, not enabled, not ready, not identifiable
    """
    statement = run.judged.statement
    if found := obstacles(run.judged, run.verdict.tuning):
        return withheld(run.monitor, found, _evidence(run), ("value and verdict are withheld",))
    limits, status = limits_of(run), STATUSES[round(statement.status)]
    cause, action = explained(run, limits, status)
    return Verdict(
        monitor=run.monitor,
        status=status,
        because=(Fact(status.value, cause, _reason(run, status), action),),
        details=(*held_against(run, limits, status), gain_in_words(run)),
        since=statement.since + run.start_time if statement.since >= 0.0 else None,
        estimate=Estimate(
            PLACE,
            run.friction,
            statement.deviation,
            "N*m",
            _reference(run, limits),
            _limits_behind(run, status),
            *GainDeviation(run.verdict.tuning.gain_deviation, run.verdict.gain_given).parts(run.friction),
            fault_from=run.limits.fault_friction,
        ),
        evidence=_evidence(run),
        facts=tuple(Fact("note", each) for each in notices(run)),
        decided_by=_decided_by(run, status),
    )


def gain_in_words(run: FrictionRun) -> str:
    """Assumption on the gains of both torques that the standard deviation includes, in words."""
    cancelled = "" if run.verdict.learnt_level is None else ", cancelled in the ratio"
    return f"torque gains ± {100.0 * run.verdict.tuning.gain_deviation:.2g} % included{cancelled}"


def _decided_by(run: FrictionRun, status: Status) -> tuple[str, ...]:
    """Names of the decisions behind an alarm."""
    if status not in (Status.RISING, Status.FAULT):
        return ()
    rules = ABSOLUTE if run.judged.statement.kind == BY_LIMIT else BASELINE
    return (rules[status is Status.FAULT].name,)


def _limits_behind(run: FrictionRun, status: Status) -> tuple[str, ...]:
    """Parameter of the vehicle file behind an absolute alarm, which always begins at the limit of rising friction."""
    by_limit = status in (Status.RISING, Status.FAULT) and run.judged.statement.kind == BY_LIMIT
    return ("rising_friction",) if by_limit else ()


def _reference(run: FrictionRun, limits: Limits) -> dict[str, float]:
    """Reference lines beside the value; rising and fault lie where the lower of absolute and relative limit acts."""
    reference = {
        "nominal": run.limits.nominal_friction,
        "rising": limits.rising.acts_from,
        "fault": limits.fault.acts_from,
    }
    if run.judged.known_level > 0.0:
        reference["baseline"] = run.judged.known_level
    return reference


def _evidence(run: FrictionRun) -> dict[str, float]:
    figures, own = run.judged.figures, run.judged.baseline
    worked, enabled = figures.worked_seconds, figures.enabled_seconds
    evidence = {
        "recording_s": figures.seconds,
        "enabled_s": enabled,
        "enabled_share": enabled / figures.seconds if figures.seconds > 0.0 else 0.0,
        "enabled_left_share": figures.left_seconds / enabled if enabled > 0.0 else 0.0,
        "signals_present_share": figures.settled_seconds / figures.seconds if figures.seconds > 0.0 else 0.0,
        "opposed_torques_share": figures.opposed_seconds / worked if worked > 0.0 else 0.0,
        "excitation": run.judged.fit.excitation,
        "balance_misfit": run.judged.fit.misfit,
        "alarm_s": figures.alarm_seconds,
    }
    if run.verdict.limits is not None:
        evidence |= {
            "balance_error_Nm": run.judged.fit.residual,
            "vehicle_rising_limit_Nm": run.limits.rising_friction,
            "vehicle_fault_limit_Nm": run.limits.fault_friction,
            "deviation_without_torque_gains_Nm": run.judged.fit.friction_deviation,
            "deviation_by_torque_gains_Nm": run.verdict.tuning.gain_deviation * run.friction,
        }
        if run.judged.known_level > 0.0:
            evidence |= {
                "ratio_to_baseline": run.judged.ratio,
                "baseline_Nm": own.level,
                "baseline_deviation_Nm": own.deviation,
                "baseline_learnt_s": own.seconds,
            }
        evidence |= run.evidence
    return evidence


@dataclass(frozen=True)
class Limit:
    """Limit at which an alarm begins.

    Args:
        friction: estimated friction [N*m]
        absolute: limit of the vehicle file [N*m]
        absolute_from: friction from which it acts: errors of torque gain and estimate cannot explain the excess [N*m]
        ratio: limit of friction over the baseline [-]
        relative_from: friction from which the ratio acts [N*m]; infinite without a baseline
        spread: standard deviation of the limit of the vehicle file that its margin includes [N*m]
    """

    friction: Annotated[float, "N*m"]
    absolute: Annotated[float, "N*m"]
    absolute_from: Annotated[float, "N*m"]
    ratio: Annotated[float, ""]
    relative_from: Annotated[float, "N*m"]
    spread: Annotated[float, "N*m"] = 0.0

    @property
    def uncertain(self) -> str:
        """Quantities whose errors the margin covers, in words."""
        return "torque gain, estimate and limit" if self.spread > 0.0 else "torque gain and estimate"

    @property
    def acts_from(self) -> float:
        """Friction from which the first of both limits acts [N*m]."""
        return min(self.absolute_from, self.relative_from)

    @property
    def by_ratio(self) -> bool:
        """Whether the ratio to the baseline acts first; it may lie below the nominal friction of other cars."""
        return self.relative_from < self.absolute_from

    def acting(self, word: str) -> str:
        """Friction from which the limit acts, in words.

        Args:
            word: status that begins there
        """
        at = f"{self.acts_from:.2f} N·m"
        return f"{word} from {self.ratio:.4g} times ({at})" if self.by_ratio else f"{word} from {at}"

    @property
    def in_margin(self) -> bool:
        """Whether friction exceeds the limit of the vehicle file by no more than its margin."""
        return self.absolute < self.friction <= self.absolute_from


@dataclass(frozen=True)
class Limits:
    """Limits of rising friction and of a fault."""

    rising: Limit
    fault: Limit


def limits_of(run: FrictionRun) -> Limits:
    """The limits as they act on the last estimate of a run."""
    verdict, friction = run.verdict, run.friction
    level = verdict.relative_level(run.judged.known_level) if run.judged.known_level > 0.0 else math.inf
    # Without the misfit, as in the margins of the verdict.
    deviation = run.judged.fit.friction_deviation / run.judged.fit.misfit

    def limit(status: Status, absolute: float, ratio: float) -> Limit:
        spread = verdict.spread_in_margin(status)
        acts_from = verdict.acts_from(absolute, deviation, spread)
        return Limit(friction, absolute, acts_from, ratio, ratio * level, spread)

    return Limits(
        limit(Status.RISING, run.limits.rising_friction, verdict.tuning.rising_ratio),
        limit(Status.FAULT, run.limits.fault_friction, verdict.tuning.fault_ratio),
    )


def held_against(run: FrictionRun, limits: Limits, status: Status) -> tuple[str, ...]:
    """Limits that the value was compared with, in words; the reason for the status comes first."""
    ratio = _ratio(run)
    if status in (Status.RISING, Status.FAULT):
        limit = limits.fault if status is Status.FAULT else limits.rising
        if run.judged.statement.kind == BY_LIMIT:
            name = "fault limit" if status is Status.FAULT else "limit of rising friction"
            parts = [
                f"above the {name} of {limit.absolute:.4g} N·m plus its margin ({limit.absolute_from:.2f} N·m)",
                ratio,
            ]
        else:
            parts = [f"{ratio}, {status.value} from {limit.ratio:.4g} times"]
        parts.append(f"nominal {run.limits.nominal_friction:.4g} N·m")
        parts.append(_fault_to_come(limits) if status is Status.RISING else "")
    else:
        parts = []
        if run.judged.implausible > 0.5:
            parts.append(f"implausible, below {run.verdict.tuning.smallest_friction:.2g} times nominal")
        acting = f"{limits.rising.acting('rising')}, {limits.fault.acting('fault')}"
        nominal = f"nominal {run.limits.nominal_friction:.4g} N·m"
        by_ratio = limits.rising.by_ratio or limits.fault.by_ratio
        parts += [f"{ratio}, {acting}", nominal] if by_ratio else [f"{nominal}, {acting}", ratio]
        parts += [*_margins(limits, status), *_low(run)] if status is Status.HEALTHY else []
    return tuple(part for part in parts if part)


def _reason(run: FrictionRun, status: Status) -> str:
    """Why it is suspect, in a few words; "" where the value itself says it."""
    if status is not Status.SUSPECT:
        return ""
    if run.judged.implausible > 0.5:
        return "implausibly low, {estimate}"
    return "above a limit at the end" if run.judged.pending > 0.5 else "was above a limit, and fell"


def explained(run: FrictionRun, limits: Limits, status: Status) -> tuple[str, str]:
    """Cause and action of a status that rests on the estimate."""
    if status is Status.HEALTHY:
        return _healthy(run, limits)
    if status is Status.SUSPECT:
        return _suspect(run, limits)
    cause = _alarm(run, limits.fault if status is Status.FAULT else limits.rising, status)
    if status is Status.FAULT:
        return (
            cause,
            "inspect column joints, bearings, steering gear and motor for corrosion, water or damage before driving on",
        )
    cause = "; it is ".join((cause, *_margins(limits, status)))
    if limits.fault.in_margin:
        return cause, f"have the steering inspected now, and to find out whether it is a fault, {SETTLE}"
    if limits.rising.friction > CLOSE * limits.fault.acts_from:
        return cause, (
            f"friction is close to a fault, which begins at {limits.fault.acts_from:.2f} N·m: inspect the boots of the "
            "steering gear, joints and bearings now, and record again"
        )
    return cause, "watch it: record again within days, and inspect the boots of the steering gear at the next service"


def _ratio(run: FrictionRun) -> str:
    if run.judged.known_level <= 0.0:
        return ""
    return f"{run.judged.ratio:.2f} times {_level(run)}"


def _level(run: FrictionRun) -> str:
    """The level that friction is compared with, in words: a given baseline, or the one learnt in this recording."""
    level = f"{run.judged.known_level:.2f} N·m"
    return f"the {level} learnt in this recording" if run.verdict.learnt_level is None else f"its baseline of {level}"


def _fault_to_come(limits: Limits) -> str:
    fault = limits.fault
    if fault.in_margin:
        return (
            f"also above the fault limit of {fault.absolute:.4g} N·m, but within its margin (up to "
            f"{fault.absolute_from:.2f} N·m)"
        )
    if fault.friction > fault.acts_from:
        return f"above the {fault.acts_from:.2f} N·m of a fault, but not yet long enough"
    return f"fault from {fault.acts_from:.2f} N·m"


def _margins(limits: Limits, status: Status) -> list[str]:
    """The highest limit that friction exceeds by less than the margin, in words; empty if there is none."""
    named = [("fault limit", limits.fault), ("limit of rising friction", limits.rising)]
    return [
        f"above the {name} of {limit.absolute:.4g} N·m, but within the margin of {limit.uncertain} (up to "
        f"{limit.absolute_from:.2f} N·m)"
        for name, limit in (named[:1] if status is Status.RISING else named)
        if limit.in_margin
    ][:1]


def _low(run: FrictionRun) -> list[str]:
    """Friction far below nominal, in words; empty beside a given baseline, in whose ratio gains cancel."""
    share = run.friction / run.limits.nominal_friction
    return [f"only {share:.2f} times nominal"] if run.verdict.learnt_level is None and share < SMALLEST_NOMINAL else []


def _healthy(run: FrictionRun, limits: Limits) -> tuple[str, str]:
    margins = _margins(limits, Status.HEALTHY)
    if run.judged.known_level > 0.0 and run.judged.ratio < SMALLEST_LEVEL:
        return (
            f"friction stayed below every limit, but it is only {_ratio(run)}: the gains of driver_torque or "
            "motor_torque may have changed since, or that level was learnt in the cold or on another car; a fault may "
            "then be judged healthy",
            "check the gains of driver_torque and motor_torque, judge a lock-to-lock test, and learn the baseline anew "
            "if the lower level is right",
        )
    if low := _low(run):
        return (
            f"friction stayed below every limit, but it is {low[0]}: {TOO_LOW}",
            f"before this level is stored as that of a fault-free car, {SETTLE}",
        )
    if not margins:
        kept = "" if run.verdict.learnt_level is not None else "; store the learnt level for the next recording"
        return "friction stayed below every limit", f"none{kept}"
    cause = f"friction is {margins[0]}"
    if run.verdict.learnt_level is not None:
        return (
            f"{cause}; compared with the given baseline it has not risen",
            "none if the baseline comes from a fault-free car; otherwise calibrate driver_torque and motor_torque, or "
            "make a lock-to-lock test",
        )
    return cause, f"before this level is stored as that of a fault-free car, find out whether it has risen: {SETTLE}"


def _suspect(run: FrictionRun, limits: Limits) -> tuple[str, str]:
    if run.judged.implausible > 0.5:
        nominal = run.limits.nominal_friction
        least = run.verdict.tuning.smallest_friction
        return (
            f"friction is implausible: {run.friction / nominal:.2f} times nominal, below the plausible minimum of "
            f"{least:.2g}; motor_torque or driver_torque may be clipped or its gain too low, or motor_ratio may be "
            "wrong",
            "check range and gain of both torques, and motor_ratio in the vehicle file, and record again; until then "
            "a fault may stay undetected",
        )
    inspect = "if the excess returns, inspect column joints, steering gear and boots for water"
    causes = []
    if run.judged.pending > 0.5:
        own = run.friction > limits.rising.relative_from
        above = (
            f"{_ratio(run)}, rising from {limits.rising.ratio:.4g} times"
            if own
            else f"{run.friction:.2f} N·m, rising from {limits.rising.absolute_from:.2f}"
        )
        causes.append(
            f"at the end friction was {above}; the recording ended, or signals were lost, before this was confirmed"
        )
    if run.judged.figures.worst_alarm > 0.0:
        seconds = run.judged.figures.alarm_seconds
        causes.append(f"friction was above a limit for {seconds:.0f} s of enabled time and fell back")
    return "; ".join(causes), f"record again, with all signals to the end; {inspect}"


def _alarm(run: FrictionRun, limit: Limit, status: Status) -> str:
    if run.judged.statement.kind == BY_LIMIT:
        return (
            f"friction is above the limit of the vehicle file by more than {run.verdict.margin:g} standard "
            f"{'deviation' if run.verdict.margin == 1.0 else 'deviations'} of {limit.uncertain}: "
            f"{limit.absolute:.4g} N·m, with this margin {limit.absolute_from:.2f} N·m"
        )
    return (
        f"friction rose to {run.judged.ratio:.2f} times {_level(run)}; {status.value} from {limit.ratio:.4g} times "
        f"({limit.relative_from:.2f} N·m)"
    )


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
