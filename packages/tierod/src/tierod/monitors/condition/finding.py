"""Finding of the condition monitor on a drive, about all sensors and actuators together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tierod.core.findings import Element, Episode, Finding, Status
from tierod.core.signals import SIGNALS
from tierod.diagnosis.switchover import SubstitutionGraph
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.monitors.condition.accelerations import MOTION, Disagreement
from tierod.monitors.condition.courses import TOGETHER, ElementCourse, listed, shown
from tierod.monitors.condition.coverage import Loss
from tierod.monitors.condition.driven import ALL_HELD, ALL_ZERO, MAP_FIRST, SLID, TOO_FEW, Driven
from tierod.monitors.condition.reaction import NOT_ISOLABLE
from tierod.monitors.condition.signals import (
    ACCELERATIONS,
    ACTUATORS,
    DRIVES,
    ELEMENTS,
    MOTORS,
    NEEDED,
    SENSORS,
    STEERING_TORQUES,
    TARGETS,
)
from tierod.monitors.condition.wiring import Problem
from tierod.monitors.harness.session import StatusChange

LEAST_TESTABLE = 5.0
"""Least time with testability of an element for the verdict healthy [s]."""
LACKING = "the recording has no"
"""Beginning of the cause of an element that is not in the recording."""
LEAST_TOLD = 1.0
"""Shortest unjudged time of a drive that is reported [s]."""
_NEVER = 0.05
"""Time with testability below which the element counts as never testable [s]."""


def elements(
    courses: Mapping[str, ElementCourse],
    drive: Driven,
    problems: Sequence[Problem],
    graph: SubstitutionGraph,
    lost: Mapping[str, Loss] | None = None,
) -> tuple[Element, ...]:
    """State of every sensor and actuator."""
    codes = load_trouble_codes().codes
    found, open_, lost = [], unresolved(courses, drive.end), losses(courses, drive) if lost is None else lost
    for name, course in courses.items():
        needed = courses.get(NEEDED.get(name, ""))
        status, cause = _status(course, open_[name], drive, problems, needed, lost.get(name))
        judged = status in (Status.FAULT, Status.SUSPECT)
        episodes = open_[name] if judged else ()
        code = codes[name.replace("_", "-")].code if status is Status.FAULT else ""
        if status is Status.SUSPECT:
            code = codes[NOT_ISOLABLE].code
        role = "actuator" if name in ACTUATORS else "sensor"
        found.append(Element(name, role, status, cause, episodes, _substitute(name, status, drive, graph), code))
    return tuple(found)


def with_smallest(element: Element, courses: Mapping[str, ElementCourse], multiples: Mapping[str, float]) -> Element:
    """A fault-free element with the smallest fault that would have been seen while it was testable."""
    if element.status is not Status.HEALTHY or element.name not in multiples:
        return element
    smallest = multiples[element.name] * courses[element.name].spread
    if element.role == "sensor":
        return replace(element, smallest=smallest, unit=SIGNALS[element.name].unit)
    if smallest > 1.0:
        cause = "the drive determined its torque so roughly that a total loss might not have been seen"
        return replace(element, status=Status.NOT_TESTABLE, cause=cause)
    return replace(element, smallest=100.0 * smallest, unit="percent")


def acceleration_elements(disagreeing: Sequence[Disagreement]) -> tuple[Element, ...]:
    """States of the accelerations that have failed, without substitutes."""
    return tuple(
        Element(
            each.element,
            "sensor",
            Status.FAULT,
            f"it contradicts {MOTION[each.element]}; the filters do not use it since {each.found:.2f} s",
            (
                Episode(
                    f"deviation of {shown(each.magnitude, 'm/s**2')} from {MOTION[each.element]}",
                    each.start,
                    declared=each.found,
                ),
            ),
        )
        for each in disagreeing
        if each.sure
    )


def losses(courses: Mapping[str, ElementCourse], drive: Driven) -> dict[str, Loss]:
    """Losses of signals and doubts about one element, by the elements that could not be judged then."""
    found = {name: drive.loss(name, course.observed) for name, course in courses.items() if course.available > 0.0}
    return _doubted(courses, drive.end) | {name: loss for name, loss in found.items() if loss is not None}


def _doubted(courses: Mapping[str, ElementCourse], end: float) -> dict[str, Loss]:
    """Elements about which a doubt remained, by no other candidate and without any declaration at that time."""
    faults = [each for course in courses.values() for each in course.episodes(end) if not each.candidates]
    found: dict[str, Loss] = {}
    for name, course in courses.items():
        for doubt in course.doubts_alone(end):
            if not any(_overlap(fault, doubt, end) for fault in faults):
                until = end if doubt.end is None else doubt.end
                cause = (
                    f"its residual exceeded the fault-free limit from {doubt.start:.2f} s to {until:.2f} s, too little"
                )
                found.setdefault(name, Loss(Status.NOT_TESTABLE, f"{cause} to declare a fault", doubt.start, until))
    return found


def _overlap(fault: Episode, doubt: Episode, end: float) -> bool:
    """Whether a declared fault, from its onset on, explains a doubt."""
    begun, over = doubt.declared_at, end if doubt.end is None else doubt.end
    return fault.start <= over + TOGETHER and (fault.end is None or begun <= fault.end + TOGETHER)


def unresolved(courses: Mapping[str, ElementCourse], end: float) -> dict[str, tuple[Episode, ...]]:
    """Faults of every element, and doubts that no declaration of one of the candidates has ended."""
    all_ = {name: course.episodes(end) for name, course in courses.items()}
    faults = {name: [each for each in found if not each.candidates] for name, found in all_.items()}

    def stays(name: str, episode: Episode) -> bool:
        return not episode.candidates or not any(
            _overlap(fault, episode, end) for each in (name, *episode.candidates) for fault in faults[each]
        )

    return {name: tuple(each for each in found if stays(name, each)) for name, found in all_.items()}


def _status(
    course: ElementCourse,
    episodes: Sequence[Episode],
    drive: Driven,
    problems: Sequence[Problem],
    needed: ElementCourse | None,
    loss: Loss | None,
) -> tuple[Status, str]:
    name = course.element
    if course.available == 0.0:
        if name in SENSORS and (dead := _dead(drive)):
            return Status.NOT_AVAILABLE, dead
        missing = name if name in SENSORS else f"target torque of {name}"
        return Status.NOT_AVAILABLE, f"{LACKING} {missing.replace('_', ' ')}"
    # Wrong wiring explains apparent faults and losses, and must come before them.
    if problems:
        concerned = [problem for problem in problems if name in problem.elements]
        return Status.NOT_TESTABLE, (concerned or list(problems))[0].cause
    if any(not episode.candidates for episode in episodes):
        return Status.FAULT, ""
    if episodes:
        return Status.SUSPECT, ""
    if loss is not None:
        when = "at other times" if loss.until is not None else "until then" if loss.since is not None else "in these"
        seen = (
            f"fault-free {when}"
            if course.testable >= LEAST_TESTABLE
            else f"{when} it was testable for too short a time"
        )
        return loss.status, f"{loss.cause}; {seen}"
    if course.testable < LEAST_TESTABLE:
        if not _dead(drive) and needed is not None and needed.available < min(LEAST_TESTABLE, 0.5 * drive.seconds):
            return Status.NOT_TESTABLE, f"its output cannot be checked without {needed.element.replace('_', ' ')}"
        return Status.NOT_TESTABLE, _not_testable(name, course, drive)
    if drive.seconds - course.available > LEAST_TOLD:
        return Status.HEALTHY, f"while its readings were present, {course.available:.0f} of {drive.seconds:.0f} s"
    return Status.HEALTHY, ""


def _dead(drive: Driven) -> str:
    """Cause of a shared failure of all sensors almost throughout the drive; "" without one."""
    little = drive.judged * drive.period < LEAST_TESTABLE
    return drive.not_judged if little and drive.not_judged in (ALL_ZERO, ALL_HELD) else ""


def _not_testable(name: str, course: ElementCourse, drive: Driven) -> str:
    """Cause why an element was not testable for long enough, with the time for which it was."""
    why = _hindrance(name, drive)
    if course.testable < _NEVER:
        return why
    return f"{why}; a fault would have been visible for {course.testable:.1f} s only, {LEAST_TESTABLE:g} s are needed"


def _hindrance(name: str, drive: Driven) -> str:
    """Cause why a fault of an element was not observable."""
    if dead := _dead(drive):
        return dead
    if not drive.enough:
        return f"{TOO_FEW}; {MAP_FIRST}"
    period, moving = drive.period, drive.forward * drive.period
    if drive.judged * period < LEAST_TESTABLE and drive.not_judged:
        return drive.not_judged
    if drive.seconds < LEAST_TESTABLE:
        return f"the recording is too short, {drive.seconds:.3g} s"
    if moving < LEAST_TESTABLE:
        if drive.backward * period > LEAST_TESTABLE:
            return "the vehicle reversed"
        return f"the vehicle moved for only {moving:.1f} s" if moving > LEAST_TOLD else "the vehicle stood"
    if name in ACTUATORS:
        return "the target torque was too small"
    return "its true value was near zero, or the other signals did not determine it well enough"


def _substitute(name: str, status: Status, drive: Driven, graph: SubstitutionGraph) -> str:
    """Substitute that was used for a faulty sensor for the longest time, with its measured error."""
    samples = drive.sources.get(name, {})
    if status is not Status.FAULT or not any(samples.values()):
        return ""
    used = max(samples, key=lambda way: samples[way])
    way = next(way for way in graph.substitutes[name] if way.name == used)
    return f"{used.replace('-', ' ')} (± {shown(way.deviation, SIGNALS[name].unit)})"


def code_courses(courses: Mapping[str, ElementCourse], end: float) -> dict[str, tuple[StatusChange, ...]]:
    """Changes of the verdict on every trouble code."""
    found = {name.replace("_", "-"): tuple(course.course) for name, course in courses.items()}
    begun = min(course[0].time for course in found.values())
    episodes = [episode for each in unresolved(courses, end).values() for episode in each]
    return found | {NOT_ISOLABLE: _doubts(episodes, begun, end)}


def _doubts(episodes: Iterable[Episode], start: float, end: float) -> tuple[StatusChange, ...]:
    """Changes between healthy and suspect by lasting doubts between several elements; overlapping ones are joined."""
    times = sorted(
        (episode.declared_at, end if episode.end is None else episode.end) for episode in episodes if episode.candidates
    )
    changes = [StatusChange(start, Status.HEALTHY)]
    until = start
    for begin, finish in times:
        if begin > until or len(changes) == 1:
            changes += [StatusChange(begin, Status.SUSPECT), StatusChange(finish, Status.HEALTHY)]
        elif finish > until:
            changes[-1] = StatusChange(finish, Status.HEALTHY)
        until = max(until, finish)
    return tuple(changes if until < end else changes[: max(len(changes) - 1, 1)])


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
    """Finding over all elements."""
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
