"""What a drive says of all sensors and actuators together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tierod.diagnosis.substitution import SubstitutionGraph
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.findings import Element, Episode, Estimate, Finding, Status
from tierod.graph import Result
from tierod.monitors.condition.courses import STATUSES, SUSPECT, ElementCourse
from tierod.monitors.condition.said import ELEMENTS
from tierod.monitors.condition.signals import ACTUATORS, SENSORS
from tierod.monitors.condition.wiring import Problem
from tierod.monitors.session import StatusChange
from tierod.signals import SIGNALS

STANDING = 0.5
"""Speed below which the vehicle stands [m/s]."""
LEAST_TESTABLE = 5.0
"""Time for which a fault of an element must have been able to show before the element is called sound [s]."""
NOT_ISOLABLE = "condition-not-isolable"
"""Trouble code of what is seen and not told apart."""


@dataclass
class Drive:
    """Figures over the pieces of a recording.

    Args:
        start, end: [s]
        moving, reverse: time for which it drove forward, and backward [s]
        seconds: of all samples
        restarts: times that all sensors fell silent and came back
        present: readings of each signal
        sources: time for which each sensor was supplied by each source [s]
    """

    start: float = math.nan
    end: float = math.nan
    moving: float = 0.0
    reverse: float = 0.0
    seconds: float = 0.0
    restarts: int = 0
    present: dict[str, int] = field(default_factory=dict)
    sources: dict[str, dict[str, float]] = field(default_factory=dict)
    period: float = 0.01

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], period: float) -> None:
        """The next piece."""
        self.start = float(time[0]) if math.isnan(self.start) else self.start
        self.end, self.period = float(time[-1]) + period, period
        self.seconds += len(time) * period
        wheels = np.column_stack([signals[name] for name in SENSORS[:2]])
        with np.errstate(invalid="ignore"):
            self.moving += float(np.count_nonzero((wheels > STANDING).any(axis=1))) * period
            self.reverse += float(np.count_nonzero((wheels < -STANDING).any(axis=1))) * period
        for name, values in signals.items():
            self.present[name] = self.present.get(name, 0) + int(np.count_nonzero(np.isfinite(values)))

    def add_sources(self, supplied: Result, graph: SubstitutionGraph) -> None:
        """Where each sensor's signal came from over the next piece."""
        for sensor, ways in zip(graph.sensors, graph.ways, strict=True):
            source = supplied[f"{sensor}.source"]
            for number, way in enumerate(ways, 1):
                found = float(np.count_nonzero(source == number)) * self.period
                told = self.sources.setdefault(sensor, {})
                told[way.name] = told.get(way.name, 0.0) + found


def elements(
    courses: Mapping[str, ElementCourse], drive: Drive, problems: Sequence[Problem], graph: SubstitutionGraph
) -> tuple[Element, ...]:
    """The state of every sensor and actuator.

    Args:
        courses: of all elements
        drive: figures over it
        problems: what was wired wrongly
        graph: of the substitutes
    """
    codes = load_trouble_codes().codes
    found = []
    for name, course in courses.items():
        status, cause = _status(name, course, drive, problems)
        judged = status in (Status.FAULT, Status.SUSPECT)
        episodes = course.episodes(drive.end) if judged else ()
        code = codes[name.replace("_", "-")].code if status is Status.FAULT else ""
        if status is Status.SUSPECT:
            code = codes[NOT_ISOLABLE].code
        role = "actuator" if name in ACTUATORS else "sensor"
        found.append(Element(name, role, status, cause, episodes, _substitute(name, status, drive, graph), code))
    return tuple(found)


def _status(name: str, course: ElementCourse, drive: Drive, problems: Sequence[Problem]) -> tuple[Status, str]:
    if course.available == 0.0:
        missing = name if name in SENSORS else f"target torque of {name.replace('_', ' ')}"
        return Status.NOT_AVAILABLE, f"the recording has no {missing.replace('_', ' ')}"
    if problems:
        concerned = [problem for problem in problems if name in problem.elements]
        return Status.NOT_TESTABLE, (concerned or list(problems))[0].cause
    episodes = course.episodes(drive.end)
    if any(not episode.candidates for episode in episodes):
        return Status.FAULT, ""
    if episodes:
        return Status.SUSPECT, ""
    if course.testable < LEAST_TESTABLE:
        return Status.NOT_TESTABLE, _not_testable(name, course, drive)
    return Status.HEALTHY, ""


def _not_testable(name: str, course: ElementCourse, drive: Drive) -> str:
    """Why a fault of an element would not have shown for long enough."""
    shown = f"a fault would have shown for {course.testable:.1f} s, {LEAST_TESTABLE:g} s are needed"
    if drive.moving < LEAST_TESTABLE:
        return f"the vehicle {'reversed' if drive.reverse > LEAST_TESTABLE else 'stood'}; {shown}"
    if name in ACTUATORS:
        return f"it was asked for too little torque; {shown}"
    return f"its true value was near zero, or the others did not tell it well enough; {shown}"


def _substitute(name: str, status: Status, drive: Drive, graph: SubstitutionGraph) -> str:
    """What stood in for a sensor for the longest time, with its measured error."""
    times = drive.sources.get(name, {})
    if status is not Status.FAULT or not any(times.values()):
        return ""
    used = max(times, key=lambda way: times[way])
    way = next(way for way in graph.substitutes[name] if way.name == used)
    return f"{used.replace('-', ' ')} (± {way.deviation:g} {SIGNALS[name].unit.replace('*', '·')})"


def judge(name: str, states: Sequence[Element], drive: Drive, problems: Sequence[Problem], calibrated: bool) -> Finding:
    """The finding over all elements.

    Args:
        name: of monitor and variant
        states: of all elements
        drive: figures over it
        problems: what was wired wrongly
        calibrated: whether the limits were designed on this very vehicle
    """
    evidence = _evidence(states, drive)
    warnings = () if calibrated else (UNCALIBRATED,)
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
    rest = f"; not judged: {_listed(open_)} ({open_[0].cause})" if open_ else ""
    if not sound:
        cause = open_[0].cause
        status = Status.NOT_AVAILABLE if all(e.status is Status.NOT_AVAILABLE for e in open_) else Status.NOT_TESTABLE
        headline = f"No sensor and no actuator was judged: {cause}."
        action = (
            "record a drive with bends and changes of speed, with all signals; 'tierod inspect' shows what there is"
        )
        return Finding(name, status, headline, None, None, evidence, cause, action, warnings)
    headline = f"{len(sound)} of {len(ELEMENTS)} sensors and actuators are sound over {drive.seconds:.0f} s{rest}."
    return Finding(name, Status.HEALTHY, headline, None, None, evidence, "", "none", warnings)


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
        headline = f"Something is wrong since {first.start:.2f} s; it is one of {_listed(doubtful)}."
        cause = "several explain what was seen as well, and nothing in the drive tells them apart"
        action = "check them one by one, or drive with more steering and braking"
        return Finding(name, Status.SUSPECT, headline, first.start, None, evidence, cause, action, warnings)
    sentences = [_sentence(episode, each) for episode, each in told]
    more = f"; and {len(sentences) - 3} more" if len(sentences) > 3 else ""
    headline = f"{'; '.join(sentences[:3])}{more}."
    episode, _ = told[0]
    cause = "readings and torques differ from what all others tell, by more than healthy drives ever showed"
    action = f"check {_listed(faulty)}: sensor, wiring, supply"
    return Finding(
        name, Status.FAULT, headline[:1].upper() + headline[1:], episode.start, episode.size, evidence, cause, action,
        warnings,
    )  # fmt: skip


def _sentence(episode: Episode, element: Element) -> str:
    plain = element.name.replace("_", " ")
    what = "fault" if not episode.kind else episode.kind
    until = "" if episode.end is None else f" to {episode.end:.2f} s"
    size = f" of {_size(episode.size)}" if episode.size is not None else ""
    return f"{plain} {element.role if element.role == 'sensor' else ''}".rstrip() + (
        f": {what}{size} from {episode.start:.2f} s{until or ' on'}"
    )


def _size(size: Estimate) -> str:
    factor, unit = {"rad": (180.0 / math.pi, "°"), "rad/s": (180.0 / math.pi, "°/s")}.get(size.unit, (1.0, size.unit))
    if size.quantity.startswith("lost share"):
        factor, unit = 100.0, "%"
    return f"{factor * size.value:.3g} {unit.replace('*', '·')}".rstrip()


def _listed(elements_: Sequence[Element]) -> str:
    plain = [each.name.replace("_", " ") for each in elements_]
    return " and ".join([", ".join(plain[:-1]), plain[-1]] if len(plain) > 1 else plain)


def _evidence(states: Sequence[Element], drive: Drive) -> dict[str, float]:
    found = {"seconds": drive.seconds, "moving_seconds": drive.moving}
    if drive.reverse:
        found["reversing_seconds"] = drive.reverse
    if drive.restarts:
        found["restarts"] = float(drive.restarts)
    found["sensors_and_actuators_judged"] = float(
        sum(each.status in (Status.HEALTHY, Status.FAULT, Status.SUSPECT) for each in states)
    )
    return found


def code_courses(courses: Mapping[str, ElementCourse]) -> dict[str, tuple[StatusChange, ...]]:
    """The running verdict of every trouble code.

    Args:
        courses: of all elements
    """
    found = {name.replace("_", "-"): tuple(course.course) for name, course in courses.items()}
    doubts = sorted(
        (change.time, STATUSES[SUSPECT] if change.status is STATUSES[SUSPECT] else Status.HEALTHY, name)
        for name, course in courses.items()
        for change in course.course
    )
    holding: dict[str, Status] = {}
    merged: list[StatusChange] = []
    for time, status, name in doubts:
        holding[name] = status
        now = Status.SUSPECT if Status.SUSPECT in holding.values() else Status.HEALTHY
        if not merged or merged[-1].status is not now:
            merged.append(StatusChange(time, now))
    return found | {NOT_ISOLABLE: tuple(merged)}
