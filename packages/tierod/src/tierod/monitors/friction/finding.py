"""The finding on friction: the last statement of the block in words, with limits, reasons and remedy."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from tierod.core.facts import Fact, Verdict
from tierod.core.findings import Estimate, Status
from tierod.core.statement import STATUSES
from tierod.monitors.friction.decisions import ABSOLUTE, BASELINE
from tierod.monitors.friction.notices import SMALLEST_LEVEL, FrictionRun, notices, obstacles
from tierod.monitors.friction.verdict import BY_LIMIT
from tierod.monitors.harness.verdict import withheld
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
