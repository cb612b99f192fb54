"""The verdict on friction after a recording: the facts behind it, whose words are in `sentences`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.facts import Fact, Verdict
from tierod.core.findings import Estimate, Status
from tierod.core.statuses import STATUSES
from tierod.methods.relations import WRONG_SIGN_SHARE
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.friction.sentences import GROUNDS, NOTES, OBSTACLES, Words
from tierod.monitors.friction.thresholds import ABSOLUTE, BASELINE
from tierod.monitors.friction.verdict import BY_LIMIT, FrictionFigures, FrictionLimits, FrictionVerdict, JudgedFriction
from tierod.vehicles.classes import GainDeviation

PLACE = "friction torque at the steering wheel axis"

CLOSE = 0.9
"""Share of the fault limit from which rising friction is reported as close to it [-]; 0.9 leaves 0.4 of the way from
1.2 to 1.6 times the baseline."""

SMALLEST_NOMINAL = 0.7
"""Share of nominal friction below which the torques or the vehicle file are doubted [-]: four standard deviations of
the common torque gain below 1; halved motor torques give 0.64 to 0.68, simulated."""

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
    """Result of a friction monitor after a recording: its verdict block, and its output after the last sample."""

    monitor: str
    verdict: FrictionVerdict
    judged: JudgedFriction
    start_time: float = 0.0  # time of the first sample in the recording [s]
    # further named quantities of the estimator, with unit in the name
    evidence: Mapping[str, float] = field(default_factory=dict)
    # parameters of the vehicle file as the estimator assumes them; None where unknown
    parameters: FrictionParameters | None = None

    @property
    def friction(self) -> float:
        return self.judged.statement.magnitude

    @property
    def limits(self) -> FrictionLimits:
        """Limits of the vehicle file; without them the torques are raw counts, and the verdict is withheld."""
        assert self.verdict.limits is not None
        return self.verdict.limits

    @property
    def own(self) -> bool:
        """Whether a baseline from earlier recordings is given."""
        return self.verdict.learnt_level is not None

    @property
    def level(self) -> str:
        """The level that friction is compared with, in words."""
        level = f"{self.judged.known_level:.2f} N·m"
        return f"its baseline of {level}" if self.own else f"the {level} learnt in this recording"


def verdict_of_run(run: FrictionRun) -> Verdict:
    """The last statement of the block as a verdict."""
    statement, words = run.judged.statement, _figures(run)
    status = STATUSES[round(statement.status)]
    if names := obstacles(run.judged):
        held = tuple(_fact(name, OBSTACLES[name], words) for name in names)
        note = Fact("withheld", "value and verdict are withheld")
        return Verdict(run.monitor, status, held, evidence=_evidence(run), facts=(note,))
    limits = limits_of(run)
    words |= _against(run, limits, status)
    by_limit = status in (Status.RISING, Status.FAULT) and statement.kind == BY_LIMIT
    rules = (ABSOLUTE if by_limit else BASELINE) if status in (Status.RISING, Status.FAULT) else ()
    return Verdict(
        monitor=run.monitor,
        status=status,
        because=tuple(_fact(name, GROUNDS[name], words) for name in _grounds(run, limits, status)),
        details=(*_details(run, limits, status, words), _gain_in_words(run)),
        since=statement.since + run.start_time if statement.since >= 0.0 else None,
        estimate=Estimate(
            PLACE,
            run.friction,
            statement.deviation,
            "N*m",
            _reference(run, limits),
            # An absolute alarm always begins at the limit of rising friction.
            ("rising_friction",) if by_limit else (),
            *GainDeviation(run.verdict.tuning.gain_deviation, run.verdict.gain_given).parts(run.friction),
            fault_from=run.limits.fault_friction,
        ),
        evidence=_evidence(run),
        decided_by=tuple(each.name for each in rules[status is Status.FAULT :][:1]),
        facts=tuple(Fact(name, NOTES[name].format(**words)) for name in _notes(run, words)),
    )


def _fact(name: str, words: Words, figures: Mapping[str, Any]) -> Fact:
    cause, action, reason = (each.format(**figures) for each in words)
    return Fact(name, cause, reason, action)


def obstacles(judged: JudgedFriction) -> list[str]:
    """Names of every obstacle to the verdict that the block found, the decisive one first."""
    held = [name for name, there in zip(judged.obstacles._fields, judged.obstacles, strict=True) if there > 0.5]
    figures = judged.figures
    special = {
        "opposed": "wrong_sign" if _share(figures.opposed_seconds, figures.worked_seconds) > WRONG_SIGN_SHARE else "",
        "too_little_time": "" if figures.enabled_seconds > 0.0 else "never_enabled",
    }
    return [special.get(name) or name for name in held]


def _grounds(run: FrictionRun, limits: Limits, status: Status) -> Iterator[str]:
    """Names of the facts that explain a status that rests on the estimate."""
    judged = run.judged
    if status is Status.HEALTHY:
        yield _healthy(run, limits)
    elif status is Status.SUSPECT and judged.implausible > 0.5:
        yield "implausible"
    elif status is Status.SUSPECT:
        if judged.pending > 0.5:
            yield "pending"
        if judged.figures.worst_alarm > 0.0:
            yield "episode"
        yield "again"
    else:
        yield "by_limit" if judged.statement.kind == BY_LIMIT else "by_baseline"
        if status is Status.FAULT:
            yield "fault"
        elif limits.fault.in_margin:
            yield "within_fault_margin"
        else:
            yield "close" if limits.rising.friction > CLOSE * limits.fault.acts_from else "watch"


def _healthy(run: FrictionRun, limits: Limits) -> str:
    own = "_of_baseline" if run.own else ""
    if run.judged.known_level > 0.0 and run.judged.ratio < SMALLEST_LEVEL:
        return "fallen"
    if _is_low(run):
        return "low"
    return f"within_margin{own}" if limits.fault.in_margin or limits.rising.in_margin else f"below_limits{own}"


def _is_low(run: FrictionRun) -> bool:
    """Whether friction is far below nominal; not beside a given baseline, in whose ratio gains cancel."""
    return not run.own and run.friction < SMALLEST_NOMINAL * run.limits.nominal_friction


def _notes(run: FrictionRun, words: Mapping[str, Any]) -> Iterator[str]:
    """Names of the notes beside a verdict; late signals show in the learnt constants of the steering."""
    yield "gain"
    if run.judged.known_level <= 0.0:
        yield "no_level"
    if run.parameters is not None:
        # Only the estimator that models the bar learns a Dahl angle.
        if "dahl_angle_rad" in run.evidence and not math.isfinite(run.parameters.torsion_bar_stiffness):
            yield "rigid_bar"
        if words["inertias"] > LARGEST_INERTIA:
            yield "large_inertia"
        if words["dampings"] > LARGEST_DAMPING:
            yield "large_damping"
    if words["inertia"] < 0.0:
        yield "negative_inertia"
    if not 1.0 / LARGEST_ALIGNING < words["aligning"] < LARGEST_ALIGNING:
        yield "aligning"
    if words["absent"] > 1.0 - SMALLEST_PRESENCE:
        yield "absent"
    if not ONE_SIDED < words["left"] < 1.0 - ONE_SIDED:
        yield "one_sided"
    if words["opposed"] > OPPOSED:
        yield "opposed"


def _share(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else 0.0


def _figures(run: FrictionRun) -> dict[str, Any]:
    """Figures that the words of obstacles and notes contain, by name."""
    judged, tuning, figures, fit = run.judged, run.verdict.tuning, run.judged.figures, run.judged.fit
    inertia, below = run.evidence.get("inertia_kgm2", 0.0), run.parameters and run.parameters.below_bar
    closed_by, remedy = _closing_condition(figures)
    worse = f", and the torque balance fits {fit.misfit:.1f} times worse than expected"
    return {
        "opposed": _share(figures.opposed_seconds, figures.worked_seconds),
        "absent": 1.0 - _share(figures.settled_seconds, figures.seconds),
        "left": _share(figures.left_seconds, figures.enabled_seconds),
        "enabled": figures.enabled_seconds,
        "ready": tuning.ready_time,
        "closed_by": closed_by,
        "remedy": remedy,
        "negative": "friction" if judged.statement.magnitude <= 0.0 else "self-aligning torque",
        "damping": fit.damping,
        "aligning": fit.aligning_gain,
        "residual": fit.residual,
        "excitation": fit.excitation,
        "uncertainty": _share(fit.friction_deviation, judged.statement.magnitude),
        "allowed": tuning.largest_deviation,
        "misfit": worse if fit.misfit > 1.5 else "",
        "gain": f"{100.0 * tuning.gain_deviation:.2g} %",
        "gain_source": "torque_gain_deviation of the vehicle file" if run.verdict.gain_given else "assumed",
        "inertia": inertia,
        "inertias": inertia / below.inertia if below else 0.0,
        "dampings": fit.damping / below.damping if below else 0.0,
        "alarm": figures.alarm_seconds,
        "ratio": judged.ratio,
        "level": run.level,
    }


def _closing_condition(figures: FrictionFigures) -> tuple[str, str]:
    """Conditions that kept the gate closed, largest share first, and the remedy for the first."""
    causes = [
        (figures.seconds - figures.settled_seconds, "signals were missing or had just begun",
         "look for gaps with 'tierod inspect'"),
        (figures.slow_seconds, "the vehicle stood or rolled slowly",
         "drive faster than walking pace, or judge a lock-to-lock test with the monitor hysteresis (variant hoist or "
         "ground)"),
        (figures.hands_off_seconds, "the driver's torque was too small",
         "drive bends by hand, without steering functions"),
        (figures.still_seconds, "the steering wheel hardly turned",
         "drive bends: city or country roads, not a motorway"),
        (figures.opposed_seconds, "driver and motor opposed each other", "switch lane keeping off"),
    ]  # fmt: skip
    causes.sort(key=lambda cause: -cause[0])
    shares = [(_share(seconds, figures.seconds), text) for seconds, text, _ in causes]
    named = [f"{text} for {share:.0%} of the recording" for share, text in shares if share >= 0.005]
    return "; ".join(named) or "the recording is short", causes[0][2]


@dataclass(frozen=True)
class Limit:
    """Limit at which an alarm begins."""

    friction: Annotated[float, "N*m"]  # estimated friction
    # absolute, absolute_from: limit of the vehicle file, and friction from which it acts with its margin
    absolute: Annotated[float, "N*m"]
    absolute_from: Annotated[float, "N*m"]
    # ratio, relative_from: limit over the baseline, and friction from which it acts; infinite without a baseline
    ratio: Annotated[float, ""]
    relative_from: Annotated[float, "N*m"]
    # standard deviation of the limit of the vehicle file that its margin includes
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

    @property
    def in_margin(self) -> bool:
        """Whether friction exceeds the limit of the vehicle file by no more than its margin."""
        return self.absolute < self.friction <= self.absolute_from

    def acting(self, word: str) -> str:
        """Friction from which the limit acts, in words; `word` is the status that begins there."""
        at = f"{self.acts_from:.2f} N·m"
        return f"{word} from {self.ratio:.4g} times ({at})" if self.by_ratio else f"{word} from {at}"


class Limits(NamedTuple):
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


def _against(run: FrictionRun, limits: Limits, status: Status) -> dict[str, Any]:
    """Figures that the words of a verdict contain, beside those of `_figures`."""
    margin, rising = run.verdict.margin, limits.rising
    above = f"{run.friction:.2f} N·m, rising from {rising.absolute_from:.2f}"
    if run.friction > rising.relative_from:
        above = f"{run.judged.ratio:.2f} times {run.level}, rising from {rising.ratio:.4g} times"
    named = [("fault limit", limits.fault), ("limit of rising friction", rising)]
    within = [
        f"above the {name} of {limit.absolute:.4g} N·m, but within the margin of {limit.uncertain} (up to "
        f"{limit.absolute_from:.2f} N·m)"
        for name, limit in named
        if limit.in_margin
    ]
    return {
        "status": status,
        "limit": limits.fault if status is Status.FAULT else rising,
        "fault": limits.fault,
        "margin": f"{margin:g} standard deviation{'' if margin == 1.0 else 's'}",
        "share": run.friction / run.limits.nominal_friction,
        "least": run.verdict.tuning.smallest_friction,
        "above": above,
        "within": within[0] if within else "",
    }


def _details(run: FrictionRun, limits: Limits, status: Status, words: Mapping[str, Any]) -> Iterator[str]:
    """Limits that the value was compared with; the reason for the status comes first."""
    ratio = f"{run.judged.ratio:.2f} times {run.level}" if run.judged.known_level > 0.0 else ""
    nominal = f"nominal {run.limits.nominal_friction:.4g} N·m"
    parts: list[str] = []
    if status in (Status.RISING, Status.FAULT):
        limit: Limit = words["limit"]
        if run.judged.statement.kind == BY_LIMIT:
            name = "fault limit" if status is Status.FAULT else "limit of rising friction"
            parts += [f"above the {name} of {limit.absolute:.4g} N·m plus its margin ({limit.absolute_from:.2f} N·m)"]
            parts += [ratio]
        else:
            parts += [f"{ratio}, {status.value} from {limit.ratio:.4g} times"]
        parts += [nominal, _fault_to_come(limits.fault) if status is Status.RISING else ""]
    else:
        if run.judged.implausible > 0.5:
            parts += [f"implausible, below {run.verdict.tuning.smallest_friction:.2g} times nominal"]
        acting = f"{limits.rising.acting('rising')}, {limits.fault.acting('fault')}"
        by_ratio = limits.rising.by_ratio or limits.fault.by_ratio
        parts += [f"{ratio}, {acting}", nominal] if by_ratio else [f"{nominal}, {acting}", ratio]
        if status is Status.HEALTHY:
            parts += [words["within"], f"only {words['share']:.2f} times nominal" if _is_low(run) else ""]
    yield from filter(None, parts)


def _fault_to_come(fault: Limit) -> str:
    if fault.in_margin:
        up_to = f"within its margin (up to {fault.absolute_from:.2f} N·m)"
        return f"also above the fault limit of {fault.absolute:.4g} N·m, but {up_to}"
    if fault.friction > fault.acts_from:
        return f"above the {fault.acts_from:.2f} N·m of a fault, but not yet long enough"
    return f"fault from {fault.acts_from:.2f} N·m"


def _gain_in_words(run: FrictionRun) -> str:
    """Assumption on the gains of both torques that the standard deviation includes, in words."""
    cancelled = ", cancelled in the ratio" if run.own else ""
    return f"torque gains ± {100.0 * run.verdict.tuning.gain_deviation:.2g} % included{cancelled}"


def _reference(run: FrictionRun, limits: Limits) -> dict[str, float]:
    """Reference lines beside the value; rising and fault lie where the lower of absolute and relative limit acts."""
    reference = {
        "nominal": run.limits.nominal_friction,
        "rising": limits.rising.acts_from,
        "fault": limits.fault.acts_from,
    }
    return reference | ({"baseline": run.judged.known_level} if run.judged.known_level > 0.0 else {})


def _evidence(run: FrictionRun) -> dict[str, float]:
    figures, fit, own = run.judged.figures, run.judged.fit, run.judged.baseline
    evidence = {
        "recording_s": figures.seconds,
        "enabled_s": figures.enabled_seconds,
        "enabled_share": _share(figures.enabled_seconds, figures.seconds),
        "enabled_left_share": _share(figures.left_seconds, figures.enabled_seconds),
        "signals_present_share": _share(figures.settled_seconds, figures.seconds),
        "opposed_torques_share": _share(figures.opposed_seconds, figures.worked_seconds),
        "excitation": fit.excitation,
        "balance_misfit": fit.misfit,
        "alarm_s": figures.alarm_seconds,
    }
    if run.verdict.limits is not None:
        evidence |= {
            "balance_error_Nm": fit.residual,
            "vehicle_rising_limit_Nm": run.limits.rising_friction,
            "vehicle_fault_limit_Nm": run.limits.fault_friction,
            "deviation_without_torque_gains_Nm": fit.friction_deviation,
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
