"""What the finding on friction says: against what the value was held, why, and what to do."""

from __future__ import annotations

from tierod.core.findings import Status
from tierod.monitors.friction.limits import Limit, Limits
from tierod.monitors.friction.run import FrictionRun
from tierod.monitors.friction.verdict import UNKNOWN_LIMITS

CLOSE = 0.9
"""Share of the limit of a fault from which rising friction is called close to it: a third of the way from 1.2 to 1.6
times the own level is left at the least."""

BY_ABSOLUTE = 2.0
"""`Onset.decisive` where only an absolute limit gives the status."""

SETTLE = (
    "calibrate the torques, compare with this car's own level from an earlier sound drive, or measure with a "
    "lock-to-lock turn what was added"
)


def held_against(run: FrictionRun, limits: Limits, status: Status) -> str:
    """What the value was held against, the reason for the status first."""
    known, parts = run.verdict.limits != UNKNOWN_LIMITS, []
    ratio = _ratio(run)
    if status in (Status.RISING, Status.FAULT):
        limit = limits.fault if status is Status.FAULT else limits.rising
        if run.state.onset.decisive == BY_ABSOLUTE:
            name = "fault limit" if status is Status.FAULT else "limit of rising friction"
            parts = [f"above the {name} of {limit.absolute:.4g} N·m, which acts from {limit.absolute_from:.2f}", ratio]
        else:
            parts = [f"{ratio}, {status.value} from {limit.ratio:.4g} times"]
        if known:
            parts.append(f"nominal {run.verdict.limits.nominal_friction:.4g} N·m")
            parts.append(_fault_to_come(limits) if status is Status.RISING else "")
    else:
        if implausible(run):
            parts.append(f"implausible, below {run.verdict.tuning.smallest_friction:.2g} times nominal")
        if known:
            parts.append(
                f"nominal {run.verdict.limits.nominal_friction:.4g}, rising from {limits.rising.acts_from:.2f}, fault "
                f"from {limits.fault.acts_from:.2f} N·m"
            )
        parts += [ratio, *(_margins(run, limits, status) if status is Status.HEALTHY else [])]
    return "; ".join(part for part in parts if part) or "no reference known"


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
    cause = "; it is ".join((cause, *_margins(run, limits, status)))
    if limits.fault.in_margin:
        return cause, f"have the steering inspected now, and settle whether it is a fault: {SETTLE}"
    if limits.rising.friction > CLOSE * limits.fault.acts_from:
        return cause, (
            f"it is close to a fault, which acts from {limits.fault.acts_from:.2f} N·m: inspect the boots of the "
            "steering gear, joints and bearings now, and record again"
        )
    return cause, "watch it: record again within days, and inspect the boots of the steering gear at the next service"


def _ratio(run: FrictionRun) -> str:
    if run.output.level <= 0.0:
        return ""
    return f"{run.output.ratio:.2f} times its own level of {run.output.level:.2f} N·m"


def _fault_to_come(limits: Limits) -> str:
    fault = limits.fault
    if fault.in_margin:
        return f"above the fault limit of {fault.absolute:.4g} N·m too, which acts from {fault.absolute_from:.2f}"
    if fault.friction > fault.acts_from:
        return f"beyond the {fault.acts_from:.2f} N·m of a fault, but not for long enough to be one"
    return f"fault from {fault.acts_from:.2f} N·m"


def _margins(run: FrictionRun, limits: Limits, status: Status) -> list[str]:
    """The strongest limit that friction is above, but within the margin; empty if none."""
    margin = run.verdict.tuning.confidence * run.verdict.tuning.gain_deviation
    named = [("fault limit", limits.fault), ("limit of rising friction", limits.rising)]
    return [
        f"above the {name} of {limit.absolute:.4g} N·m, but within the {margin:.0%} by which the torque sensors' gain "
        "may be off"
        for name, limit in (named[:1] if status is Status.RISING else named)
        if limit.in_margin
    ][:1]


def _healthy(run: FrictionRun, limits: Limits) -> tuple[str, str]:
    margins = _margins(run, limits, Status.HEALTHY)
    if not margins:
        return "friction stayed below every limit", "none; store the learnt level for the next recording"
    cause = f"friction is {margins[0]}"
    if run.verdict.learnt_level is not None:
        return (
            f"{cause}; against the own level that was handed in it has not risen",
            "none if that level is of a sound car; if not, calibrate the torques or turn from lock to lock",
        )
    return cause, f"settle whether it has risen before its level is stored as that of a sound car: {SETTLE}"


def implausible(run: FrictionRun) -> bool:
    """Whether friction is below what any steering has."""
    limits = run.verdict.limits
    least = run.verdict.tuning.smallest_friction * limits.nominal_friction
    return limits != UNKNOWN_LIMITS and run.last.friction_torque < least


def _suspect(run: FrictionRun, limits: Limits) -> tuple[str, str]:
    if implausible(run):
        nominal = run.verdict.limits.nominal_friction
        least = run.verdict.tuning.smallest_friction
        return (
            f"friction is implausible: {run.last.friction_torque / nominal:.2f} times nominal, where no steering has "
            f"less than {least:.2g}; motor_torque or driver_torque is clipped, or its gain too low, or motor_ratio is "
            "not that of this car",
            "check range and gain of the torques and the vehicle file, and record again: a fault may hide behind it",
        )
    inspect = "if it returns, inspect the column's joints, the steering gear and the boots for water"
    causes = []
    if limits.pending:
        own = run.last.friction_torque > limits.rising.relative_from
        above = (
            f"{run.output.ratio:.2f} times its own level, rising from {limits.rising.ratio:.4g} times"
            if own
            else f"{run.last.friction_torque:.2f} N·m, rising from {limits.rising.absolute_from:.2f}"
        )
        causes.append(
            f"friction was last {above}, but the recording ended or signals were lost before it could be confirmed"
        )
    if run.state.figures.worst_alarm > 0.0:
        seconds = run.state.figures.alarm_seconds
        causes.append(f"friction was above a limit for {seconds:.0f} s of enabled time and fell back")
    return "; ".join(causes), f"record again, with all signals to the end; {inspect}"


def _alarm(run: FrictionRun, limit: Limit, status: Status) -> str:
    if run.state.onset.decisive == BY_ABSOLUTE:
        return (
            f"friction is above the limit of the vehicle file by more than the torque sensors' gain may be off: "
            f"{limit.absolute:.4g} N·m, which acts from {limit.absolute_from:.2f}"
        )
    return (
        f"friction rose above this car's own level of {run.output.level:.2f} N·m: {run.output.ratio:.2f} times it, "
        f"{status.value} from {limit.ratio:.4g} times ({limit.relative_from:.2f} N·m)"
    )
