"""State of every sensor and actuator over a drive, and course of every trouble code."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from tierod.core.findings import Element, Episode, Status
from tierod.core.signals import SIGNALS
from tierod.diagnosis.substitution import SubstitutionGraph
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.monitors.condition.courses import TOGETHER, ElementCourse
from tierod.monitors.condition.driven import ALL_HELD, ALL_ZERO, MAP_FIRST, TOO_FEW, Driven
from tierod.monitors.condition.reaction import NOT_ISOLABLE
from tierod.monitors.condition.recording_checks.absence import Loss
from tierod.monitors.condition.recording_checks.contradictions import Problem
from tierod.monitors.condition.recording_checks.filter_inputs import MOTION, Disagreement
from tierod.monitors.condition.signals import ACTUATORS, NEEDED, SENSORS
from tierod.monitors.condition.statements import shown
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
    """State of every sensor and actuator.

    Args:
        courses: courses of all elements
        drive: figures of the drive
        problems: wiring errors
        graph: graph of the substitutes
        lost: losses of signals, and other times in which an element was not judged; None takes `losses` alone
    """
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
    """A fault-free element with the smallest fault that would have been seen while it was testable.

    Args:
        element: state of an element
        courses: courses of all elements
        multiples: smallest lasting change that is seen, in standard deviations, by element; without one none is stated
    """
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
    """States of the accelerations that have failed, without substitutes.

    Args:
        disagreeing: accelerations that are inconsistent with the motion; only the sure ones count
    """
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
    """Losses of signals during the drive, and doubts about one element, by the elements that could not be judged then.

    Args:
        courses: courses of all elements
        drive: figures of the drive
    """
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
    """Faults of every element, and doubts that no declaration of one of the candidates has ended.

    Args:
        courses: courses of all elements
        end: end of the recording [s]
    """
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
    """Changes of the verdict on every trouble code.

    Args:
        courses: courses of all elements
        end: end of the recording [s]
    """
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
