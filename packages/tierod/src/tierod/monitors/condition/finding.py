"""Finding of the condition monitor on a drive, about all sensors and actuators together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tierod.core.findings import Element, Episode, Finding, Status
from tierod.monitors.condition.driven import MAP_FIRST, SLID, TOO_FEW, Driven
from tierod.monitors.condition.recording_checks.absence import Loss
from tierod.monitors.condition.recording_checks.contradictions import Problem
from tierod.monitors.condition.recording_checks.filter_inputs import MOTION, Disagreement
from tierod.monitors.condition.signals import (
    ACCELERATIONS,
    ACTUATORS,
    DRIVES,
    ELEMENTS,
    MOTORS,
    STEERING_TORQUES,
    TARGETS,
)
from tierod.monitors.condition.statements import listed, shown
from tierod.monitors.condition.states import LACKING, LEAST_TOLD


class OtherCauses(NamedTuple):
    """Inconsistent inputs of the filters, which have no substitute and may explain a declared fault.

    Args:
        disagreeing: accelerations that are inconsistent with the motion
        asked: targets that are inconsistent with the response of the actuators, each pair together
    """

    disagreeing: tuple[Disagreement, ...]
    asked: tuple[tuple[str, ...], ...]


COMPARED = ("wheel_speed_rear_left", "wheel_speed_rear_right", "yaw_rate")
"""Sensors of the motion with which the accelerations are compared."""

LONG_BEFORE = 5.0
"""Least time by which a fault of one of them must precede an inconsistent acceleration to explain it [s]; a faulty
acceleration is detected within this time, so that the faults which it causes in the filters are not so early."""

HARDLY = 0.3
"""Largest share of the driving that may be unjudged because tyres slid, for a fault-free verdict [-]."""


def judge(
    name: str,
    states: Sequence[Element],
    drive: Driven,
    problems: Sequence[Problem],
    lost: Mapping[str, Loss],
    interruptions: int,
    calibrated: bool,
    notes: Sequence[str] = (),
    causes: OtherCauses | None = None,
) -> Finding:
    """Finding over all elements.

    Args:
        name: name of monitor and variant
        states: states of all elements
        drive: figures of the drive
        problems: wiring errors
        lost: losses of signals during the drive, by element
        interruptions: number of times that the judgement was interrupted
        calibrated: whether the limits were designed on this individual vehicle
        notes: further warnings
        causes: other explanations of the declared faults
    """
    evidence = _evidence(states, drive, interruptions)
    warnings = (*(() if calibrated else (UNCALIBRATED,)), *notes, *_not_judged(drive))
    if problems:
        first = problems[0]
        headline = f"Sensors and actuators cannot be judged: {first.cause}."
        return Finding(name, Status.NOT_TESTABLE, headline, None, None, evidence, first.cause, first.action, warnings)
    faulty = [each for each in states if each.status is Status.FAULT]
    doubtful = [each for each in states if each.status is Status.SUSPECT]
    if faulty or doubtful:
        quiet = [each.name for each in states if each.status is Status.HEALTHY]
        found = _fault(name, faulty, doubtful, quiet, evidence, warnings)
        return _and_other_causes(found, (*faulty, *doubtful), causes)
    healthy = [each for each in states if each.status is Status.HEALTHY]
    open_ = [each for each in states if each.status is not Status.HEALTHY]
    if lost:
        return _lost(name, states, healthy, lost, evidence, warnings)
    if not healthy:
        return _nothing_judged(name, open_, evidence, warnings)
    if drive.slid > HARDLY * drive.forward * drive.period:
        return _and_other_causes(_hardly_judged(name, healthy, drive, evidence, warnings), (), causes)
    rest = f"; not judged: {_by_cause(open_)}" if open_ else ""
    judged = drive.judged * drive.period
    headline = f"{len(healthy)} of {_judged(states)} sensors and actuators are fault-free over {judged:.0f} s{rest}."
    warnings += tuple(
        f"{listed(targets)}: {_off(targets)}, but too little for a verdict; check the channels and the actuators"
        for targets in (causes.asked if causes else ())
    )
    action = f"none for the {len(healthy)} that were judged; for each of the others see the cause named beside it"
    return Finding(name, Status.HEALTHY, headline, None, None, evidence, "", action if open_ else "none", warnings)


def _hardly_judged(
    name: str, fault_free: Sequence[Element], drive: Driven, evidence: dict[str, float], warnings: tuple[str, ...]
) -> Finding:
    """Finding without a fault in the judged part, which was too small a share of the drive."""
    moving = drive.forward * drive.period
    cause = f"{drive.slid:.0f} of {moving:.0f} s of driving were not judged: {SLID}"
    headline = (
        f"Too little of the drive was judged to call {len(fault_free)} sensors and actuators fault-free: {cause}."
    )
    action = (
        "drive on a dry road, below 6 m/s² lateral acceleration, with bends both ways and changes of speed; if the "
        "drive was like this, check lateral and longitudinal acceleration and the tyre and mass parameters of the "
        "vehicle file"
    )
    return Finding(name, Status.NOT_TESTABLE, headline, None, None, evidence, cause, action, warnings)


def _and_other_causes(finding: Finding, declared: Sequence[Element], causes: OtherCauses | None) -> Finding:
    """Finding with inconsistent inputs of the filters among its causes.

    A faulty shaft torque sensor is itself inconsistent with the targets, which are then not named.
    """
    if causes is None:
        return finding
    alone = [each.name for each in declared] == ["steering_shaft_torque"]
    other = [
        f"{each.element.replace('_', ' ')} may be the cause instead: it differs by {shown(each.magnitude, 'm/s**2')} "
        f"from {MOTION[each.element]} from {each.start:.0f} s on, more than usual"
        for each in causes.disagreeing
        if not each.sure
    ]
    other += [
        f"{listed(targets)} may be the cause instead: {_off(targets)}"
        for targets in causes.asked
        if not (alone and targets == TARGETS[:2])
    ]
    return replace(finding, cause="; ".join((finding.cause, *other)))


def _off(targets: Sequence[str]) -> str:
    """Inconsistency of the targets of a pair of actuators, in words."""
    shown_by = "the torque in the shaft" if targets == TARGETS[:2] else "the acceleration"
    return f"the targets contradict {shown_by}"


def _judged(states: Sequence[Element]) -> int:
    """Number of elements without the accelerations, which are not judged."""
    return sum(each.name not in ACCELERATIONS for each in states)


def _by_cause(open_: Sequence[Element]) -> str:
    """Elements that were not judged, grouped by cause; those absent from the recording come last."""
    lacking = [each.name for each in open_ if each.status is Status.NOT_AVAILABLE and each.cause.startswith(LACKING)]
    causes: dict[str, list[str]] = {}
    for each in open_:
        if each.name not in lacking:
            causes.setdefault(each.cause.partition(";")[0], []).append(each.name)
    causes_named = [f"{listed(names)} ({cause})" for cause, names in causes.items()]
    return "; ".join((*causes_named, *([f"{listed(lacking)} (not in the recording)"] if lacking else [])))


def _lost(
    name: str,
    states: Sequence[Element],
    healthy: Sequence[Element],
    lost: Mapping[str, Loss],
    evidence: dict[str, float],
    warnings: tuple[str, ...],
) -> Finding:
    """Finding with a signal that was lost during the drive: no fault, and not healthy either."""
    first = min(lost.values(), key=_order)
    alike = [name for name, loss in lost.items() if loss.cause == first.cause]
    who = "" if len(alike) >= sum(each.role == "sensor" for each in states) else f"{listed(alike)}: "
    rest = f"{len(healthy)} of {_judged(states)} sensors and actuators are fault-free"
    headline = f"{who}{first.cause}; {rest if healthy else 'nothing is judged from then on'}."
    action = "check the bus, supply or logger that they share, and then the sensors themselves; record again"
    if len(alike) == 1:
        action = f"check {listed(alike)}: the sensor itself, its wiring, its supply and its messages; record again"
    return Finding(
        name, first.status, headline[:1].upper() + headline[1:], first.since, None, evidence, first.cause, action,
        warnings,
    )  # fmt: skip


def _order(loss: Loss) -> tuple[float, bool]:
    """Sort key: by time, and a lost signal before the elements that cannot be judged without it."""
    return math.inf if loss.since is None else loss.since, loss.status is not Status.NOT_AVAILABLE


def _nothing_judged(
    name: str, open_: Sequence[Element], evidence: dict[str, float], warnings: tuple[str, ...]
) -> Finding:
    """Finding without any judged element: the cause of a present one, or else that of the absent ones."""
    there = [each for each in open_ if each.status is not Status.NOT_AVAILABLE]
    status, cause = (there or open_)[0].status, (there or open_)[0].cause
    if not there:
        cause = f"{TOO_FEW}; the recording has no wheel speed, no yaw rate and no steering wheel angle"
    headline = f"No sensor and no actuator was judged: {cause}."
    action = MAP_FIRST if not there else "record a drive with bends and changes of speed, with all signals"
    return Finding(name, status, headline, None, None, evidence, cause, action, warnings)


def _not_judged(drive: Driven) -> tuple[str, ...]:
    """Warnings of longer unjudged times; with too few sensors a slide is not credible and is omitted."""
    seconds = {cause: count * drive.period for cause, count in drive.unjudged.items() if cause != SLID or drive.enough}
    return tuple(f"{time:.0f} s were not judged: {cause}" for cause, time in seconds.items() if time > LEAST_TOLD)


UNCALIBRATED = (
    "this vehicle is not calibrated: its limits are wide enough for several virtual vehicles, so small faults are "
    "missed, and fault sizes and substitutes are less accurate, as their intervals show; calibrate it on healthy "
    "drives with 'tierod identify thresholds'"
)


def _fault(
    name: str,
    faulty: Sequence[Element],
    doubtful: Sequence[Element],
    quiet: Sequence[str],
    evidence: dict[str, float],
    warnings: tuple[str, ...],
) -> Finding:
    all_ = [(episode, each) for each in (*faulty, *doubtful) for episode in each.episodes]
    singles = _likeliest_first([(episode, each) for episode, each in all_ if not episode.candidates])
    if not singles:
        first, end = min((each for each, _ in all_), key=lambda each: each.declared_at), _end(all_)
        named = {name for episode, each in all_ for name in (each.name, *episode.candidates)}
        one_of = listed(sorted(named, key=ELEMENTS.index), "or")
        headline = f"One of several is suspect {_when(replace(first, end=end))}: {one_of}."
        cause = "several of them explain the readings equally well, and the drive does not isolate one"
        if targets := _targets(sorted(named)):
            cause += f"; so does a wrong recording of the targets ({listed(targets)})"
        # A tie-rod force with a gain of one half may, while small, stay below its own limit and exceed that of others.
        if named <= {*STEERING_TORQUES} and (rest := [each for each in STEERING_TORQUES if each in quiet]):
            cause += f"; so may a wrong {listed(rest)}, which belongs to the same torque balance"
        action = "check them one by one, or drive with more steering and braking"
        return Finding(
            name, Status.SUSPECT, headline, first.start, None, evidence, cause, action, warnings,
            declared=first.declared_at, end=end,
        )  # fmt: skip
    sentences = [_sentence(episode, each) for episode, each in singles]
    more = f"; and {len(sentences) - 3} more" if len(sentences) > 3 else ""
    headline = f"{'; '.join(sentences[:3])}{more}."
    episode = min((each for each, _ in singles), key=lambda each: each.start)
    names = tuple(each.name for each in faulty)
    cause = _why(names)
    places = "the part itself, its wiring, its supply"
    if names in (MOTORS, DRIVES):
        places = "the supply and the enabling of both, then each by itself"
    if {*ACTUATORS} & {*names}:
        places += f"; and the channel of {listed(_targets(names), 'or')}"
    elif {*ACCELERATIONS} & {*names}:
        places += ", and the channel map"
    action = f"check {listed(names)}: {places}"
    return Finding(
        name, Status.FAULT, headline[:1].upper() + headline[1:], episode.start, episode.magnitude, evidence, cause,
        action, warnings, declared=episode.declared_at, end=_end(singles),
    )  # fmt: skip


def _likeliest_first(found: Sequence[tuple[Episode, Element]]) -> list[tuple[Episode, Element]]:
    """Faults in the order in which they are named: those that explain others first, then by time.

    A faulty acceleration disturbs the filters and is therefore named first. Its reference comes from wheel speeds and
    yaw rate: if one of these was faulty long before, it explains the inconsistent acceleration instead.
    """
    compared = [episode.declared_at for episode, each in found if each.name in COMPARED]

    def order(pair: tuple[Episode, Element]) -> tuple[bool, float]:
        episode, each = pair
        explained = any(start < episode.start - LONG_BEFORE for start in compared)
        return each.name not in ACCELERATIONS or explained, episode.start

    return sorted(found, key=order)


def _why(names: Sequence[str]) -> str:
    """Cause of the declared faults, in words."""
    off = [f"{name.replace('_', ' ')} contradicts {MOTION[name]}" for name in names if name in ACCELERATIONS]
    if any(name not in ACCELERATIONS for name in names):
        off.append("residuals of readings and torques exceed the fault-free limits")
    cause = "; ".join(off)
    targets = _targets(names)
    if not targets:
        return cause
    return f"{cause}; the recorded targets ({listed(targets)}) may be wrong instead of the actuators"


def _targets(names: Sequence[str]) -> list[str]:
    """Targets of the actuators among these, in pairs, since only the joint effect of a pair is observable."""
    together = [name for pair in (MOTORS, DRIVES) if {*pair} & {*names} for name in pair]
    return [target for actuator, target in zip(ACTUATORS, TARGETS, strict=True) if actuator in together]


def _sentence(episode: Episode, element: Element) -> str:
    plain = element.name.replace("_", " ")
    what = "fault" if not episode.kind else episode.kind
    size = f" of {shown(episode.magnitude.value, episode.magnitude.unit)}" if episode.magnitude is not None else ""
    return f"{plain} {element.role if element.role == 'sensor' else ''}".rstrip() + (f": {what}{size} {_when(episode)}")


def _when(episode: Episode) -> str:
    """Onset, end and, where it came noticeably later than the onset, declaration in words."""
    until = "on" if episode.end is None else f"to {episode.end:.2f} s"
    late = "" if episode.belated is None else f" (declared at {episode.belated:.2f} s)"
    return f"from {episode.start:.2f} s {until}{late}"


def _end(found: Sequence[tuple[Episode, Element]]) -> float | None:
    """Time at which all episodes had ended [s]; None where one lasts."""
    ends = [each.end for each, _ in found if each.end is not None]
    return max(ends) if len(ends) == len(found) else None


def _evidence(states: Sequence[Element], drive: Driven, interruptions: int) -> dict[str, float]:
    found = {"seconds": drive.seconds, "moving_seconds": drive.forward * drive.period}
    if drive.backward:
        found["reversing_seconds"] = drive.backward * drive.period
    if interruptions:
        found["interruptions"] = float(interruptions)
    found["sensors_and_actuators_judged"] = float(
        sum(each.status in (Status.HEALTHY, Status.FAULT, Status.SUSPECT) for each in states if each.name in ELEMENTS)
    )
    return found
