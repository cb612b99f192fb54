"""What a drive says of all sensors and actuators together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from tierod.diagnosis.substitution import SubstitutionGraph
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.findings import Element, Episode, Finding, Status
from tierod.monitors.condition.courses import TOGETHER, ElementCourse
from tierod.monitors.condition.decision import TOLD_BY
from tierod.monitors.condition.driven import Driven
from tierod.monitors.condition.said import ELEMENTS
from tierod.monitors.condition.signals import ACTUATORS, SENSORS
from tierod.monitors.condition.wiring import Problem
from tierod.monitors.session import StatusChange
from tierod.signals import SIGNALS

LEAST_TESTABLE = 5.0
"""Time for which a fault of an element must have been able to show before the element is called sound [s]."""
LEAST_TOLD = 1.0
"""Of a drive that was not judged, from which on it is told [s]."""
NOT_ISOLABLE = "condition-not-isolable"
"""Trouble code of what is seen and not told apart."""


def elements(
    courses: Mapping[str, ElementCourse], drive: Driven, problems: Sequence[Problem], graph: SubstitutionGraph
) -> tuple[Element, ...]:
    """The state of every sensor and actuator.

    Args:
        courses: of all elements
        drive: figures over it
        problems: what was wired wrongly
        graph: of the substitutes
    """
    codes = load_trouble_codes().codes
    found, open_ = [], unresolved(courses, drive.end)
    for name, course in courses.items():
        told_by = courses.get(TOLD_BY.get(name, ""))
        status, cause = _status(course, open_[name], drive, problems, told_by)
        judged = status in (Status.FAULT, Status.SUSPECT)
        episodes = open_[name] if judged else ()
        code = codes[name.replace("_", "-")].code if status is Status.FAULT else ""
        if status is Status.SUSPECT:
            code = codes[NOT_ISOLABLE].code
        role = "actuator" if name in ACTUATORS else "sensor"
        found.append(Element(name, role, status, cause, episodes, _substitute(name, status, drive, graph), code))
    return tuple(found)


def unresolved(courses: Mapping[str, ElementCourse], end: float) -> dict[str, tuple[Episode, ...]]:
    """Faults of every element, and doubts that no verdict on one of those in doubt has ended.

    Args:
        courses: of all elements
        end: of the recording [s]
    """
    all_ = {name: course.episodes(end) for name, course in courses.items()}
    verdicts = {name: [each.start for each in found if not each.candidates] for name, found in all_.items()}

    def stays(name: str, episode: Episode) -> bool:
        last = end if episode.end is None else episode.end + TOGETHER
        return not episode.candidates or not any(
            episode.start <= start <= last for each in (name, *episode.candidates) for start in verdicts[each]
        )

    return {name: tuple(each for each in found if stays(name, each)) for name, found in all_.items()}


def _status(
    course: ElementCourse,
    episodes: Sequence[Episode],
    drive: Driven,
    problems: Sequence[Problem],
    told_by: ElementCourse | None,
) -> tuple[Status, str]:
    name = course.element
    if course.available == 0.0:
        missing = name if name in SENSORS else f"target torque of {name}"
        return Status.NOT_AVAILABLE, f"the recording has no {missing.replace('_', ' ')}"
    if problems:
        concerned = [problem for problem in problems if name in problem.elements]
        return Status.NOT_TESTABLE, (concerned or list(problems))[0].cause
    if any(not episode.candidates for episode in episodes):
        return Status.FAULT, ""
    if episodes:
        return Status.SUSPECT, ""
    if course.testable < LEAST_TESTABLE:
        if told_by is not None and told_by.available < LEAST_TESTABLE:
            return Status.NOT_TESTABLE, f"nothing tells what it gives without {told_by.element.replace('_', ' ')}"
        return Status.NOT_TESTABLE, _not_testable(name, course, drive)
    if drive.seconds - course.available > LEAST_TOLD:
        return Status.HEALTHY, f"while it was there, {course.available:.0f} of {drive.seconds:.0f} s"
    return Status.HEALTHY, ""


def _not_testable(name: str, course: ElementCourse, drive: Driven) -> str:
    """Why a fault of an element would not have shown for long enough."""
    shown = f"a fault would have shown for {course.testable:.1f} s, {LEAST_TESTABLE:g} s are needed"
    period, moving = drive.period, drive.forward * drive.period
    if drive.judged * period < LEAST_TESTABLE and drive.not_judged:
        return f"{drive.not_judged}; {shown}"
    if moving < LEAST_TESTABLE:
        return f"the vehicle {'reversed' if drive.backward * period > LEAST_TESTABLE else 'stood'}; {shown}"
    if name in ACTUATORS:
        return f"it was asked for too little torque; {shown}"
    return f"its true value was near zero, or the others did not tell it well enough; {shown}"


def _substitute(name: str, status: Status, drive: Driven, graph: SubstitutionGraph) -> str:
    """What stood in for a sensor for the longest time, with its measured error."""
    samples = drive.sources.get(name, {})
    if status is not Status.FAULT or not any(samples.values()):
        return ""
    used = max(samples, key=lambda way: samples[way])
    way = next(way for way in graph.substitutes[name] if way.name == used)
    return f"{used.replace('-', ' ')} (± {_shown(way.deviation, SIGNALS[name].unit)})"


def judge(
    name: str,
    states: Sequence[Element],
    drive: Driven,
    problems: Sequence[Problem],
    interruptions: int,
    calibrated: bool,
) -> Finding:
    """The finding over all elements.

    Args:
        name: of monitor and variant
        states: of all elements
        drive: figures over it
        problems: what was wired wrongly
        interruptions: times that nothing could be judged any more
        calibrated: whether the limits were designed on this very vehicle
    """
    evidence = _evidence(states, drive, interruptions)
    warnings = (*(() if calibrated else (UNCALIBRATED,)), *_not_judged(drive))
    if problems:
        first = problems[0]
        headline = f"Sensors and actuators cannot be judged: {first.cause}."
        return Finding(name, Status.NOT_TESTABLE, headline, None, None, evidence, first.cause, first.action, warnings)
    faulty = [each for each in states if each.status is Status.FAULT]
    doubtful = [each for each in states if each.status is Status.SUSPECT]
    if faulty or doubtful:
        return _fault(name, faulty, doubtful, evidence, warnings)
    sound = [each for each in states if each.status is Status.HEALTHY]
    open_ = [each for each in states if each.status is not Status.HEALTHY]
    if not sound:
        return _nothing_judged(name, open_, evidence, warnings)
    rest = f"; not judged: {_listed([each.name for each in open_])} ({open_[0].cause})" if open_ else ""
    judged = drive.judged * drive.period
    headline = f"{len(sound)} of {len(ELEMENTS)} sensors and actuators are sound over {judged:.0f} s{rest}."
    return Finding(name, Status.HEALTHY, headline, None, None, evidence, "", "none", warnings)


def _nothing_judged(
    name: str, open_: Sequence[Element], evidence: dict[str, float], warnings: tuple[str, ...]
) -> Finding:
    """The finding where no element was judged: what kept those back that there are, else what there is not."""
    there = [each for each in open_ if each.status is not Status.NOT_AVAILABLE]
    status, cause = (there or open_)[0].status, (there or open_)[0].cause
    if not there:
        cause = "the recording has no reading of any of them, and nothing of what is asked of them"
    headline = f"No sensor and no actuator was judged: {cause}."
    action = "record a drive with bends and changes of speed, with all signals; 'tierod inspect' shows what there is"
    return Finding(name, status, headline, None, None, evidence, cause, action, warnings)


def _not_judged(drive: Driven) -> tuple[str, ...]:
    """Warnings of longer times that could not be judged."""
    seconds = {cause: count * drive.period for cause, count in drive.unjudged.items()}
    return tuple(f"{time:.0f} s were not judged: {cause}" for cause, time in seconds.items() if time > LEAST_TOLD)


UNCALIBRATED = (
    "nobody has calibrated this vehicle: its limits are as wide as several virtual vehicles need together, so that "
    "small faults are missed; 'tierod identify thresholds' calibrates it on healthy drives"
)


def _fault(
    name: str,
    faulty: Sequence[Element],
    doubtful: Sequence[Element],
    evidence: dict[str, float],
    warnings: tuple[str, ...],
) -> Finding:
    all_ = [(episode, each) for each in (*faulty, *doubtful) for episode in each.episodes]
    told = sorted(((episode, each) for episode, each in all_ if not episode.candidates), key=lambda pair: pair[0].start)
    if not told:
        first, _ = min(all_, key=lambda pair: pair[0].start)
        named = {name for episode, each in all_ for name in (each.name, *episode.candidates)}
        one_of = _listed(sorted(named, key=ELEMENTS.index), "or")
        headline = f"Something is wrong since {first.start:.2f} s; it is {one_of}."
        cause = "several explain what was seen as well, and nothing in the drive tells them apart"
        action = "check them one by one, or drive with more steering and braking"
        return Finding(name, Status.SUSPECT, headline, first.start, None, evidence, cause, action, warnings)
    sentences = [_sentence(episode, each) for episode, each in told]
    more = f"; and {len(sentences) - 3} more" if len(sentences) > 3 else ""
    headline = f"{'; '.join(sentences[:3])}{more}."
    episode, _ = told[0]
    cause = "readings and torques differ from what all others tell, by more than healthy drives ever showed"
    action = f"check {_listed([each.name for each in faulty])}: the part itself, its wiring, its supply"
    return Finding(
        name, Status.FAULT, headline[:1].upper() + headline[1:], episode.start, episode.size, evidence, cause, action,
        warnings,
    )  # fmt: skip


def _sentence(episode: Episode, element: Element) -> str:
    plain = element.name.replace("_", " ")
    what = "fault" if not episode.kind else episode.kind
    until = "" if episode.end is None else f" to {episode.end:.2f} s"
    size = f" of {_shown(episode.size.value, episode.size.unit)}" if episode.size is not None else ""
    return f"{plain} {element.role if element.role == 'sensor' else ''}".rstrip() + (
        f": {what}{size} from {episode.start:.2f} s{until or ' on'}"
    )


def _shown(value: float, unit: str) -> str:
    """A value in the units that people use."""
    degrees = 180.0 / math.pi
    usual = {
        "rad": (degrees, "°"),
        "rad/s": (degrees, "°/s"),
        "rad/s**2": (degrees, "°/s²"),
        "m/s": (3.6, "km/h"),
        "percent": (1.0, "%"),
    }
    factor, label = usual.get(unit, (1.0, unit.replace("**2", "²").replace("*", "·")))
    return f"{factor * value:.3g} {label}".rstrip()


def _listed(names: Sequence[str], word: str = "and") -> str:
    plain = [name.replace("_", " ") for name in names]
    return f" {word} ".join([", ".join(plain[:-1]), plain[-1]] if len(plain) > 1 else plain)


def _evidence(states: Sequence[Element], drive: Driven, interruptions: int) -> dict[str, float]:
    found = {"seconds": drive.seconds, "moving_seconds": drive.forward * drive.period}
    if drive.backward:
        found["reversing_seconds"] = drive.backward * drive.period
    if interruptions:
        found["interruptions"] = float(interruptions)
    found["sensors_and_actuators_judged"] = float(
        sum(each.status in (Status.HEALTHY, Status.FAULT, Status.SUSPECT) for each in states)
    )
    return found


def code_courses(courses: Mapping[str, ElementCourse], end: float) -> dict[str, tuple[StatusChange, ...]]:
    """The running verdict of every trouble code.

    Args:
        courses: of all elements
        end: of the recording [s]
    """
    found = {name.replace("_", "-"): tuple(course.course) for name, course in courses.items()}
    begun = min(course[0].time for course in found.values())
    episodes = [episode for each in unresolved(courses, end).values() for episode in each]
    return found | {NOT_ISOLABLE: _doubts(episodes, begun, end)}


def _doubts(episodes: Iterable[Episode], start: float, end: float) -> tuple[StatusChange, ...]:
    """When several might be at fault for longer than a verdict takes."""
    times = sorted(
        (episode.start, end if episode.end is None else episode.end) for episode in episodes if episode.candidates
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
