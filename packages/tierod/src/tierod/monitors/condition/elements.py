"""State of every sensor and actuator over a drive, and the figures of the drive behind it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tierod.core.findings import Element, Episode, Status
from tierod.core.graph import Result
from tierod.core.series import LastRead, runs
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.diagnosis.switchover import SubstitutionGraph
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.monitors.condition.accelerations import MOTION, Difference
from tierod.monitors.condition.courses import TOGETHER, ElementCourse
from tierod.monitors.condition.coverage import ALL, LOST, UNASKED, Absence, Covered, Loss
from tierod.monitors.condition.reaction import NOT_ISOLABLE
from tierod.monitors.condition.rolling_filter import SLIPPERIEST
from tierod.monitors.condition.signals import (
    ACTUATORS,
    ALL_WHEELS,
    ELEMENTS,
    NEEDED,
    SENSOR_TABLE,
    SENSORS,
    TARGETS,
    ConditionSample,
)
from tierod.monitors.condition.wiring import Problem
from tierod.monitors.session import StatusChange

STANDING = 0.5  # speed below which the vehicle counts as standing [m/s]
HARD, AFTER = 2.5, 1.0
"""Longitudinal acceleration from which a wheel with half its load in a bend may spin or skid alone [m/s**2], a quarter
of the most on a dry road, and time in which the filters recover from it [s]."""
NO_READING = "no sensor gives a reading"
ALL_ZERO = "all sensors read exactly zero"
ALL_HELD = "all sensors repeat their previous readings"
SLID = "the tyres slid, or the vehicle cornered harder than in calibration drives"
SLIPPED = "both wheels of an axle spun or skidded, or had done so in the second before"
REVERSED = "the car reversed"
TOO_FEW = f"fewer than {ALL} sensors give a reading"

MAP_FIRST = (
    "name wheel speeds, yaw rate and steering wheel angle in the channel map if the recording has them under other "
    "names ('tierod inspect' shows its columns), else record them"
)

_ALONG = ConditionSample._fields.index("longitudinal_acceleration")
_YAW = ConditionSample._fields.index("yaw_rate")
WHEEL_PLACES = [ConditionSample._fields.index(name) for name in ALL_WHEELS]
"""Column indices of the wheel speeds in a sample."""

ALL_GONE = (ALL_ZERO, ALL_HELD, NO_READING)
_JUDGED, _ENOUGH = "judged", "enough sensors"


@dataclass
class Driven:
    """Figures of a recording, accumulated piece by piece."""

    period: float  # sampling interval [s]
    end: float = math.nan  # end of the last sample [s]
    samples: int = 0  # number of samples
    # judged, forward, backward: number of samples that were judged, and with motion forward and backward
    judged: int = 0
    forward: int = 0
    backward: int = 0
    unjudged: dict[str, int] = field(default_factory=dict)  # number of samples that were not judged, by cause
    sources: dict[str, dict[str, int]] = field(default_factory=dict)
    absences: dict[str, Absence] = field(default_factory=dict)
    now: str = ""  # cause why the last sample was not judged; "" if it was
    asked: bool = True  # whether the judgement needs the targets
    # bounds of the times of hard acceleration and braking, with `AFTER` behind them [s], and their sign
    pushed: list[tuple[float, float, float]] = field(default_factory=list)
    _slides: list[tuple[float, float]] = field(default_factory=list)
    _forward: tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0, bool))
    _read: LastRead = field(default_factory=lambda: LastRead(len(ALL_WHEELS), LOST))

    @property
    def seconds(self) -> float:
        return self.samples * self.period

    @property
    def not_judged(self) -> str:
        """Most frequent cause of unjudged samples; "" if all were judged."""
        return max(self.unjudged, key=lambda cause: self.unjudged[cause]) if self.unjudged else ""

    def add(self, time: np.ndarray, values: np.ndarray, covered: Covered) -> None:
        """Add the next piece: time [s], columns of `ConditionSample`, and their coverage."""
        self.end = float(time[-1]) + self.period
        self.samples += len(time)
        self.judged += int(np.count_nonzero(covered.judged))
        speed = self._read.held(time, values[:, WHEEL_PLACES])
        with np.errstate(invalid="ignore"):
            forward = np.asarray((speed > STANDING).any(axis=1))
            self.forward += int(np.count_nonzero(forward))
            self._forward = time, forward
            self.backward += int(np.count_nonzero((speed < -STANDING).any(axis=1)))
            for sign in (1.0, -1.0):
                pushes, ends = (each.tolist() for each in runs(sign * values[:, _ALONG] > HARD))
                self.pushed += [
                    (float(time[k]), float(time[end - 1]) + AFTER, sign) for k, end in zip(pushes, ends, strict=True)
                ]
        reading = covered.available[:, : len(SENSORS)]
        read = reading.any(axis=1)
        causes = {
            ALL_ZERO: ~read & covered.zero,
            ALL_HELD: ~read & covered.held,
            NO_READING: ~read & ~covered.zero & ~covered.held,
        }
        for place, actuator in enumerate(ACTUATORS if self.asked else (), len(SENSORS)):
            cause = (
                f"the target torque of {actuator.replace('_', ' ')} is not recorded ({TARGETS[place - len(SENSORS)]})"
            )
            causes[cause] = read & ~covered.available[:, place]
        self.now = next((cause for cause, there in causes.items() if there[-1]), "")
        for cause, there in causes.items():
            self._count(cause, there)
        for place, name in enumerate(ELEMENTS):
            self._follow(name, time, covered.available[:, place], covered.parked, covered.judged)
        self._follow(_JUDGED, time, covered.judged, covered.parked)
        # The tolerated gap is that of the missing signals: sensors may be slower than targets.
        self.absences[_JUDGED].borne = LOST if self.now in ALL_GONE else UNASKED
        self._follow(_ENOUGH, time, reading.sum(axis=1) >= ALL, covered.parked)

    def leave_out(self, cause: str, there: np.ndarray) -> None:
        """Add samples of the next piece that are not judged although all sensors give readings."""
        self._count(cause, there)
        self.judged -= int(np.count_nonzero(there))

    @property
    def slid(self) -> float:
        """Time of driving forward in which the tyres slid, so that no fault was declared [s]."""
        return (self.unjudged.get(SLID, 0) + self.unjudged.get(SLIPPED, 0)) * self.period

    def add_low_grip(self, time: np.ndarray, slid: np.ndarray, values: np.ndarray) -> None:
        """Add the slides within the last piece; standstill and reversing are judged in no case, and do not count."""
        times, forward = self._forward
        slid = slid & forward[np.searchsorted(times, time)]
        self._count(SLID, slid)
        # A faulty acceleration looks like a slide, but the car does not turn.
        turning = np.abs(values[:, _YAW]) * np.abs(np.nan_to_num(values[:, WHEEL_PLACES])).max(axis=1)
        begins, ends = runs(slid & (turning > SLIPPERIEST))
        for first, last in zip(begins, ends - 1, strict=True):
            if self._slides and time[first] - self._slides[-1][1] < 2.0 * self.period:
                self._slides[-1] = self._slides[-1][0], float(time[last])
            else:
                self._slides.append((float(time[first]), float(time[last])))

    def slid_within(self, start: float, end: float) -> bool:
        """Whether the tyres slid in a turn at any time between two times [s]."""
        return any(first <= end and last >= start for first, last in self._slides)

    def _count(self, cause: str, there: np.ndarray) -> None:
        found = int(np.count_nonzero(there))
        if found:
            self.unjudged[cause] = self.unjudged.get(cause, 0) + found

    def _follow(
        self, name: str, time: np.ndarray, there: np.ndarray, parked: np.ndarray, others: np.ndarray | None = None
    ) -> None:
        borne = UNASKED if name in ACTUATORS else LOST
        self.absences.setdefault(name, Absence(self.period, borne)).add(time, there, parked, others)

    def loss(self, element: str, observed: float) -> Loss | None:
        """Loss of a signal without which an element cannot be judged: its own, or else others."""
        sensor = element in SENSORS
        gone = self.now if sensor and self.now in ALL_GONE else "no reading" if sensor else "no target"
        own = self.absences[element].loss(Status.NOT_AVAILABLE, gone, "read" if sensor else "its target was known")
        if own is not None:
            return own
        judged = self.absences[_JUDGED].loss(Status.NOT_TESTABLE, self.now, "it could be judged")
        enough = self.absences[_ENOUGH]
        if judged is None and enough.since is not None and observed <= enough.since + LOST:
            return enough.loss(Status.NOT_TESTABLE, TOO_FEW, "")
        return judged

    @property
    def enough(self) -> bool:
        return self.absences[_ENOUGH].came

    def add_sources(self, result: Result, graph: SubstitutionGraph) -> None:
        for sensor, ways in graph.substitutes.items():
            source = result[f"supplied.{sensor}.source"]
            counts = self.sources.setdefault(sensor, {})
            for number, way in enumerate(ways, 1):
                counts[way.name] = counts.get(way.name, 0) + int(np.count_nonzero(source == number))


def mean_speed(values: np.ndarray) -> np.ndarray:
    """Mean of the wheel speeds that are read [m/s], (n,), NaN without any, from columns of `ConditionSample`."""
    wheels = values[:, WHEEL_PLACES]
    there = np.isfinite(wheels)
    count = np.where(there.any(axis=1), there.sum(axis=1), np.nan)
    return np.asarray(np.where(there, wheels, 0.0).sum(axis=1) / count)


def is_moving(values: np.ndarray) -> np.ndarray:
    """Whether any wheel reads more than `STANDING`, (n,), from columns of `ConditionSample`."""
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(values[:, WHEEL_PLACES]) >= STANDING).any(axis=1))


LEAST_TESTABLE = 5.0  # least time with testability of an element for the verdict healthy [s]
LACKING = "the recording has no"  # beginning of the cause of an element that is not in the recording
LEAST_TOLD = 1.0  # shortest unjudged time of a drive that is reported [s]
_NEVER = 0.05  # time with testability below which the element counts as never testable [s]
ROUGH = {each.name: 0.25 * each.plausible for each in SENSOR_TABLE}
"""Smallest visible offset from which none is stated [unit of the sensor]: the standard deviation of offsets of failed
sensors, see `KindOfFault.of_sensor`, most of which would then not show."""

HINDERED = {
    "few": f"{TOO_FEW}; {MAP_FIRST}",
    "reversed": "the vehicle reversed",
    "stood": "the vehicle stood",
    "idle": "the target torque was too small",
    "still": "its true value was near zero, or the other signals did not determine it well enough",
    "rough": "the drive determined its torque so roughly that a total loss might not have been seen",
    "rough sensor": "a total loss would have been seen, but not most offsets within its range",
}
"""Causes why a fault of an element was not visible."""


def elements(
    courses: Mapping[str, ElementCourse],
    drive: Driven,
    problems: Sequence[Problem],
    graph: SubstitutionGraph,
    lost: Mapping[str, Loss],
    multiples: Mapping[str, float],
) -> tuple[Element, ...]:
    """State of every sensor and actuator; `multiples` are the smallest visible changes in standard deviations."""
    codes = load_trouble_codes().codes
    found, open_ = [], unresolved(courses, drive.end)
    for name, course in courses.items():
        status, cause = _status(course, open_[name], drive, problems, lost.get(name), courses)
        code = {Status.FAULT: name.replace("_", "-"), Status.SUSPECT: NOT_ISOLABLE}.get(status, "")
        element = Element(
            name,
            "actuator" if name in ACTUATORS else "sensor",
            status,
            cause,
            open_[name] if code else (),
            _substitute(name, status, drive, graph),
            codes[code].code if code else "",
        )
        if status is Status.HEALTHY and name in multiples:
            element = _with_smallest(element, multiples[name] * course.spread)
        found.append(element)
    return tuple(found)


def _with_smallest(element: Element, smallest: float) -> Element:
    """A fault-free element with the smallest fault that would have been seen while it was testable."""
    if element.role == "sensor":
        if smallest > ROUGH[element.name]:
            return replace(element, cause=element.cause or HINDERED["rough sensor"])
        return replace(element, smallest=smallest, unit=SIGNALS[element.name].unit)
    if smallest > 1.0:
        return replace(element, status=Status.NOT_TESTABLE, cause=HINDERED["rough"])
    return replace(element, smallest=100.0 * smallest, unit="percent")


def acceleration_elements(disagreeing: Mapping[str, Difference]) -> tuple[Element, ...]:
    """States of the accelerations that have failed, without substitutes."""
    found = []
    for name, each in disagreeing.items():
        if each.sure:
            same = "stays the same and " if each.still else ""
            cause = f"it {same}contradicts {MOTION[name]}; the filters do not use it since {each.found:.2f} s"
            kind = "stuck" if each.still else f"deviation of {in_words(each.magnitude, 'm/s**2')} from {MOTION[name]}"
            episode = Episode(kind, each.start, declared=each.found)
            found.append(Element(name, "sensor", Status.FAULT, cause, (episode,)))
    return tuple(found)


def losses(courses: Mapping[str, ElementCourse], drive: Driven) -> dict[str, Loss]:
    """Losses of signals and doubts about one element, by the elements that could not be judged then."""
    found = {name: drive.loss(name, course.observed) for name, course in courses.items() if course.available > 0.0}
    return _doubted(courses, drive.end) | {name: loss for name, loss in found.items() if loss is not None}


def _doubted(courses: Mapping[str, ElementCourse], end: float) -> dict[str, Loss]:
    """Elements about which a doubt remained, by no other candidate and without any declaration at that time."""
    faults = [each for course in courses.values() for each in course.episodes(end) if not each.candidates]
    found: dict[str, Loss] = {}
    for name, course in courses.items():
        for doubt in course.episodes(end, alone=True):
            if not any(_overlap(fault, doubt, end) for fault in faults):
                until = end if doubt.end is None else doubt.end
                span = f"from {doubt.start:.2f} s to {until:.2f} s"
                cause = f"its residual exceeded the fault-free limit {span}, too little to declare a fault"
                found.setdefault(name, Loss(Status.NOT_TESTABLE, cause, doubt.start, until))
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
    loss: Loss | None,
    courses: Mapping[str, ElementCourse],
) -> tuple[Status, str]:
    name = course.element
    # A shared failure of all sensors almost throughout the drive.
    little = drive.judged * drive.period < LEAST_TESTABLE
    dead = drive.not_judged if little and drive.not_judged in (ALL_ZERO, ALL_HELD) else ""
    if course.available == 0.0:
        missing = name if name in SENSORS else f"target torque of {name}"
        lacking = f"{LACKING} {missing.replace('_', ' ')}"
        return Status.NOT_AVAILABLE, dead if name in SENSORS and dead else lacking
    # Wrong wiring explains apparent faults and losses, and must come before them.
    if problems:
        concerned = [problem for problem in problems if name in problem.elements]
        return Status.NOT_TESTABLE, (concerned or list(problems))[0].cause
    if episodes:
        sure = any(not episode.candidates for episode in episodes)
        return Status.FAULT if sure else Status.SUSPECT, ""
    if loss is not None:
        when = "at other times" if loss.until is not None else "until then" if loss.since is not None else "in these"
        enough = course.testable >= LEAST_TESTABLE
        seen = f"fault-free {when}" if enough else f"{when} it was testable for too short a time"
        return loss.status, f"{loss.cause}; {seen}"
    if course.testable < LEAST_TESTABLE:
        needed = courses.get(NEEDED.get(name, ""))
        if not dead and needed is not None and needed.available < min(LEAST_TESTABLE, 0.5 * drive.seconds):
            return Status.NOT_TESTABLE, f"its output cannot be checked without {needed.element.replace('_', ' ')}"
        why = dead or _hindrance(name, drive)
        if course.testable >= _NEVER:
            seconds = f"{course.testable:.1f} s only, {LEAST_TESTABLE:g} s are needed"
            why = f"{why}; a fault would have been visible for {seconds}"
        return Status.NOT_TESTABLE, why
    if drive.seconds - course.available > LEAST_TOLD:
        return Status.HEALTHY, f"while its readings were present, {course.available:.0f} of {drive.seconds:.0f} s"
    return Status.HEALTHY, ""


def _hindrance(name: str, drive: Driven) -> str:
    if not drive.enough:
        return HINDERED["few"]
    period, moving = drive.period, drive.forward * drive.period
    if drive.judged * period < LEAST_TESTABLE and drive.not_judged:
        return drive.not_judged
    if drive.seconds < LEAST_TESTABLE:
        return f"the recording is too short, {drive.seconds:.3g} s"
    if moving < LEAST_TESTABLE:
        if drive.backward * period > LEAST_TESTABLE:
            return HINDERED["reversed"]
        return f"the vehicle moved for only {moving:.1f} s" if moving > LEAST_TOLD else HINDERED["stood"]
    return HINDERED["idle" if name in ACTUATORS else "still"]


def _substitute(name: str, status: Status, drive: Driven, graph: SubstitutionGraph) -> str:
    """Substitute that was used for a faulty sensor for the longest time, with its measured error."""
    samples = drive.sources.get(name, {})
    if status is not Status.FAULT or not any(samples.values()):
        return ""
    used = max(samples, key=lambda way: samples[way])
    way = next(way for way in graph.substitutes[name] if way.name == used)
    return f"{used.replace('-', ' ')} (± {in_words(way.deviation, SIGNALS[name].unit)})"


def code_courses(courses: Mapping[str, ElementCourse], end: float) -> dict[str, tuple[StatusChange, ...]]:
    found = {name.replace("_", "-"): tuple(course.course) for name, course in courses.items()}
    begun = min(course[0].time for course in found.values())
    episodes = [episode for each in unresolved(courses, end).values() for episode in each]
    return found | {NOT_ISOLABLE: _doubts(episodes, begun, end)}


def _doubts(episodes: Iterable[Episode], start: float, end: float) -> tuple[StatusChange, ...]:
    """Changes between healthy and suspect by lasting doubts between several elements; overlapping ones are joined."""
    times = sorted((each.declared_at, end if each.end is None else each.end) for each in episodes if each.candidates)
    changes = [StatusChange(start, Status.HEALTHY)]
    until = start
    for begin, finish in times:
        if begin > until or len(changes) == 1:
            changes += [StatusChange(begin, Status.SUSPECT), StatusChange(finish, Status.HEALTHY)]
        elif finish > until:
            changes[-1] = StatusChange(finish, Status.HEALTHY)
        until = max(until, finish)
    return tuple(changes if until < end else changes[: max(len(changes) - 1, 1)])
