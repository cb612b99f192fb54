"""The final judgement on friction: figures of a run become a finding in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tierod.findings import Estimate, Finding, Status
from tierod.monitors.friction.obstacles import Obstacle, obstacles
from tierod.monitors.friction.verdict import UNKNOWN_LIMITS, FrictionVerdict, VerdictOutput
from tierod.monitors.friction.verdict_state import STATUSES, VerdictSample

PLACE = "friction torque at the steering wheel axis"

GAIN_WARNING = (
    "a common gain error of both torques scales the estimate and shows in no signal: 10 % of torque is 10 % of "
    "friction; the ratio to the own level is free of it"
)


@dataclass(frozen=True)
class FrictionRun:
    """What a monitor knows after a recording.

    Args:
        monitor: its name and variant
        verdict: the judge that ran
        state: its state after the last sample
        last: the estimate after the last sample
        output: the judge's output after the last sample
        calibrated: whether the torques are in N*m
        start_time: time of the first sample in the recording [s]
        aligning_gain: learnt factor on the self-aligning torque, 1 where there is none
        evidence: further named figures of the estimator, with unit in the name
    """

    monitor: str
    verdict: FrictionVerdict
    state: FrictionVerdict.State
    last: VerdictSample
    output: VerdictOutput
    calibrated: bool
    start_time: float = 0.0
    aligning_gain: float = 1.0
    evidence: Mapping[str, float] = field(default_factory=dict)


def judge(run: FrictionRun) -> Finding:
    """The finding of a run.

    Args:
        run: what is known after the last sample

    Returns:
        healthy, rising, fault; suspect where an alarm came and went; or why no verdict is possible: not available, not
        enabled, not ready, not identifiable
    """
    found = obstacles(run.state.figures, run.last, run.verdict.tuning, run.calibrated, run.aligning_gain)
    if found:
        return _withheld(run, found)
    status = STATUSES[round(run.output.code)]
    if status is Status.HEALTHY and run.state.figures.worst_alarm > 0.0:
        status = Status.SUSPECT
    cause, action = _reason(run, status)
    since = run.output.since + run.start_time if status in (Status.RISING, Status.FAULT) else None
    return Finding(
        monitor=run.monitor,
        status=status,
        headline=f"{_value(run)}: {status.value}, {_against(run)}.",
        since=None if since is None or run.output.since < 0.0 else since,
        estimate=_estimate(run),
        evidence=_evidence(run),
        cause=cause,
        action=action,
        warnings=_warnings(run),
    )


def _withheld(run: FrictionRun, found: list[Obstacle]) -> Finding:
    """No verdict and no value, with every reason."""
    decisive = found[0]
    return Finding(
        monitor=run.monitor,
        status=decisive.status,
        headline=f"Friction of the steering: {decisive.status.value}; {decisive.cause}.",
        evidence=_evidence(run),
        cause="; ".join(obstacle.cause for obstacle in found),
        action="; ".join(dict.fromkeys(obstacle.action for obstacle in found)),
        warnings=("value and verdict are withheld",),
    )


def _value(run: FrictionRun) -> str:
    return f"Friction of the steering {run.last.friction_torque:.2f} ± {run.last.friction_deviation:.2f} N·m"


def _against(run: FrictionRun) -> str:
    """What the value was held against, in words."""
    limits, parts = run.verdict.limits, []
    if limits != UNKNOWN_LIMITS:
        parts.append(f"nominal {limits.nominal_friction:.1f}, fault from {limits.fault_friction:.1f} N·m")
    if run.output.level > 0.0:
        parts.append(f"{run.output.ratio:.2f} times its own level of {run.output.level:.2f} N·m")
    return "; ".join(parts) or "no reference known"


def _reason(run: FrictionRun, status: Status) -> tuple[str, str]:
    """Cause and action of a status that rests on the estimate."""
    if status is Status.HEALTHY:
        return "friction stayed below every limit", "none; store the learnt level for the next recording"
    if status is Status.SUSPECT:
        return (
            f"friction was above a limit for {run.state.figures.alarm_seconds:.0f} s of enabled time and fell back",
            "record again; if it returns, inspect the column's joints, the steering gear and the boots for water",
        )
    own = run.state.onset.kind < 1.5
    cause = "friction rose above this car's own level" if own else "friction is above the limit of the vehicle file"
    if status is Status.RISING:
        return (
            cause,
            "watch it: record again within days, and inspect the boots of the steering gear at the next service",
        )
    return (
        cause,
        "inspect column joints, bearings, steering gear and motor for corrosion, water or damage before driving on",
    )


def _estimate(run: FrictionRun) -> Estimate:
    limits = run.verdict.limits
    reference = {}
    if limits != UNKNOWN_LIMITS:
        reference = {
            "nominal": limits.nominal_friction,
            "rising": limits.rising_friction,
            "fault": limits.fault_friction,
        }
    if run.output.level > 0.0:
        reference["own level"] = run.output.level
    return Estimate(PLACE, run.last.friction_torque, run.last.friction_deviation, "N*m", reference)


def _evidence(run: FrictionRun) -> dict[str, float]:
    figures, own = run.state.figures, run.state.own
    worked, enabled = figures.worked_seconds, figures.enabled_seconds
    evidence = {
        "recording_s": figures.seconds,
        "enabled_s": enabled,
        "enabled_share": enabled / figures.seconds if figures.seconds > 0.0 else 0.0,
        "enabled_left_share": figures.left_seconds / enabled if enabled > 0.0 else 0.0,
        "signals_present_share": figures.settled_seconds / figures.seconds if figures.seconds > 0.0 else 0.0,
        "opposed_torques_share": figures.opposed_seconds / worked if worked > 0.0 else 0.0,
        "excitation": run.last.excitation,
        "balance_misfit": run.last.misfit,
        "alarm_s": figures.alarm_seconds,
    }
    if run.calibrated:
        if run.output.level > 0.0:
            evidence |= {
                "ratio_to_own_level": run.output.ratio,
                "own_level_Nm": own.level,
                "own_level_deviation_Nm": own.deviation,
                "own_level_learnt_s": own.seconds,
            }
        evidence |= run.evidence
    return evidence


def _warnings(run: FrictionRun) -> tuple[str, ...]:
    figures, warnings = run.state.figures, [GAIN_WARNING]
    if run.output.level <= 0.0:
        warnings.append(
            "the own level is not learnt (too little time, or friction above its limit): only absolute limits judge"
        )
    elif run.output.ratio < 0.8:
        warnings.append(
            f"friction is {run.output.ratio:.2f} times the own level: was that learnt on this car, with these sensors?"
        )
    left = figures.left_seconds / figures.enabled_seconds
    if not 0.2 < left < 0.8:
        warnings.append(f"{left:.0%} of the enabled time turned left: one-sided, offsets may leak into friction")
    if run.evidence.get("inertia_kgm2", 0.0) < 0.0:
        warnings.append("the learnt inertia is negative: the torques are probably late against the angle")
    if figures.worked_seconds > 0.0 and figures.opposed_seconds > 0.1 * figures.worked_seconds:
        warnings.append("driver and motor opposed each other at times: was lane keeping active?")
    return tuple(warnings)
