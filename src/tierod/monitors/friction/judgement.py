"""The final judgement on friction: figures of a run become a finding in words."""

from __future__ import annotations

from tierod.core.findings import Estimate, Finding, Status
from tierod.monitors.friction.decisions import ABSOLUTE, OWN_LEVEL
from tierod.monitors.friction.limits import Limits, limits_of
from tierod.monitors.friction.notices import notices
from tierod.monitors.friction.obstacles import Obstacle, obstacles
from tierod.monitors.friction.run import FrictionRun
from tierod.monitors.friction.verdict import UNKNOWN_LIMITS
from tierod.monitors.friction.verdict_state import STATUSES
from tierod.monitors.friction.wording import BY_ABSOLUTE, explained, held_against, implausible

PLACE = "friction torque at the steering wheel axis"


def judge(run: FrictionRun) -> Finding:
    """The finding of a run.

    Args:
        run: what is known after the last sample

    Returns:
        healthy, rising, fault; suspect where an alarm came and went, or friction ended above a limit too late for one;
        or why no verdict is possible: not available, not enabled, not ready, not identifiable
    """
    found = obstacles(run.state.figures, run.last, run.verdict.tuning, run.calibrated)
    if found:
        return _withheld(run, found)
    limits = limits_of(run)
    status = STATUSES[round(run.output.code)]
    if status is Status.HEALTHY and (run.state.figures.worst_alarm > 0.0 or limits.pending):
        status = Status.SUSPECT
    if implausible(run):
        status = Status.SUSPECT
    cause, action = explained(run, limits, status)
    alarm = status in (Status.RISING, Status.FAULT) and run.output.since >= 0.0
    friction, deviation = run.last.friction_torque, run.last.friction_deviation
    return Finding(
        monitor=run.monitor,
        status=status,
        headline=f"Friction of the steering {friction:.2f} ± {deviation:.2f} N·m: {status.value}, "
        f"{held_against(run, limits, status)}.",
        since=run.output.since + run.start_time if alarm else None,
        estimate=Estimate(PLACE, friction, deviation, "N*m", _reference(run, limits)),
        evidence=_evidence(run),
        cause=cause,
        action=action,
        warnings=notices(run),
        decided_by=_decided_by(run, status),
    )


def _decided_by(run: FrictionRun, status: Status) -> tuple[str, ...]:
    """Names of the decisions behind an alarm."""
    if status not in (Status.RISING, Status.FAULT):
        return ()
    rules = ABSOLUTE if run.state.onset.decisive == BY_ABSOLUTE else OWN_LEVEL
    return (rules[status is Status.FAULT].name,)


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


def _reference(run: FrictionRun, limits: Limits) -> dict[str, float]:
    """What the value is drawn against; rising and fault are where they act: the lower of absolute and relative."""
    reference = {}
    if run.verdict.limits != UNKNOWN_LIMITS:
        reference["nominal"] = run.verdict.limits.nominal_friction
    if run.verdict.limits != UNKNOWN_LIMITS or run.output.level > 0.0:
        reference |= {"rising": limits.rising.acts_from, "fault": limits.fault.acts_from}
    if run.output.level > 0.0:
        reference["own level"] = run.output.level
    return reference


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
        evidence["balance_error_Nm"] = run.last.residual
        if run.verdict.limits != UNKNOWN_LIMITS:
            limits = run.verdict.limits
            evidence |= {
                "vehicle_rising_limit_Nm": limits.rising_friction,
                "vehicle_fault_limit_Nm": limits.fault_friction,
            }
        if run.output.level > 0.0:
            evidence |= {
                "ratio_to_own_level": run.output.ratio,
                "own_level_Nm": own.level,
                "own_level_deviation_Nm": own.deviation,
                "own_level_learnt_s": own.seconds,
            }
        evidence |= run.evidence
    return evidence
