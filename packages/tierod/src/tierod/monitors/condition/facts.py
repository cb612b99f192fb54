"""Verdict on all sensors and actuators of a drive together, with the facts that explain it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tierod.core.facts import Fact, Verdict, shortened
from tierod.core.findings import Element, Episode, Estimate, Status
from tierod.core.shown import in_words
from tierod.monitors.condition.accelerations import MOTION, Difference
from tierod.monitors.condition.coverage import Loss
from tierod.monitors.condition.elements import LACKING, LEAST_TOLD, MAP_FIRST, SLID, TOO_FEW, Driven
from tierod.monitors.condition.rolling_checks import SHIFTING
from tierod.monitors.condition.signals import (
    ACCELERATIONS,
    ACTUATORS,
    DRIVES,
    ELEMENTS,
    MOTORS,
    STEERING_TORQUES,
    TARGETS,
    WHEELS,
    listed,
)
from tierod.monitors.condition.wiring import Problem

COMPARED = (*WHEELS, "yaw_rate")  # sensors of the motion with which the accelerations are compared
LONG_BEFORE = 5.0
"""Least time by which a fault of one of them must precede an inconsistent acceleration to explain it [s]; a faulty
acceleration is detected within this time, so that the faults which it causes in the filters are not so early."""
LONGEST = 7  # most words of a reason in the headline, after "Sensors and actuators: not testable"
HARDLY = 0.3  # largest share of the driving that may be unjudged because tyres slid, for a fault-free verdict [-]

UNCALIBRATED = (
    "this vehicle is not calibrated: its limits are wide enough for several virtual vehicles, so small faults are "
    "missed, and fault sizes and substitutes are less accurate, as their intervals show; calibrate it on healthy "
    "drives with 'tierod identify thresholds'"
)
_SHIFTED = "has shifted since the beginning of the drive, while"

SENTENCES = {
    "healthy": Fact("healthy", "", "all {healthy} judged fault-free over {seconds:.0f} s", "none"),
    "healthy in part": Fact(
        "healthy",
        "",
        "all {healthy} judged fault-free over {seconds:.0f} s",
        "none for the {healthy} that were judged; for each of the others see the cause named beside it",
    ),
    "hardly judged": Fact(
        "hardly judged",
        "{slid:.0f} of {moving:.0f} s of driving were not judged: " + SLID,
        "too little of the drive was judged",
        "drive on a dry road, below 6 m/s² lateral acceleration, with bends both ways and changes of speed; if the "
        "drive was like this, check lateral and longitudinal acceleration and the tyre and mass parameters of the "
        "vehicle file",
    ),
    "lost": Fact(
        "lost",
        "{cause}",
        "{cause}",
        "check the bus, supply or logger that they share, and then the sensors themselves; record again",
    ),
    "one lost": Fact(
        "lost",
        "{cause}",
        "{cause}",
        "check {names}: the sensor itself, its wiring, its supply and its messages; record again",
    ),
    "nothing judged": Fact(
        "nothing judged",
        "{cause}",
        "none was judged",
        "record a drive with bends and changes of speed, with all signals",
    ),
    "nothing recorded": Fact(
        "nothing judged",
        f"{TOO_FEW}; the recording has no wheel speed, no yaw rate and no steering wheel angle",
        "none was judged",
        MAP_FIRST,
    ),
    "one of several": Fact(
        "one of several",
        "several of them explain the readings equally well, and the drive does not isolate one",
        "{names}",
        "check them one by one, or drive with more steering and braking",
    ),
    "targets as well": Fact("targets", "so does a wrong recording of the targets ({targets})"),
    "torques as well": Fact("torques", "so may a wrong {rest}, which belongs to the same torque balance"),
    "residuals": Fact("residuals", "residuals of {what} exceed the fault-free limits"),
    "acceleration": Fact("acceleration", "{name} contradicts {motion}"),
    "still": Fact("acceleration", "{name} stays the same and contradicts {motion}"),
    "targets instead": Fact("targets", "the recorded targets ({targets}) may be wrong instead of the actuators"),
    "acceleration instead": Fact(
        "acceleration",
        "{name} may be the cause instead: it differs by {size} from {motion} from {start:.0f} s on, more than usual",
    ),
    "pair instead": Fact("targets", "{targets} may be the cause instead: the targets contradict {shown}"),
    "targets doubtful": Fact(
        "targets",
        "{targets}: the targets contradict {shown}, but too little for a verdict; check the channels and the actuators",
    ),
    SHIFTING[:1]: Fact(
        "shift", f"the mean steering angle in gentle driving {_SHIFTED} yaw rate and wheel speeds fit each other"
    ),
    SHIFTING[1:]: Fact(
        "shift", f"the mean yaw rate in gentle driving {_SHIFTED} steering angle and wheel speeds fit each other"
    ),
    SHIFTING: Fact(
        "shift",
        f"the difference of steering angle and yaw rate in gentle driving {_SHIFTED} the wheel speeds do not show "
        "which of them is wrong",
    ),
}
"""Facts by case; a shift of the zero by the sensors that may have caused it."""


@dataclass(frozen=True)
class Found:
    """What the filters and the checks have found on a drive."""

    name: str  # name of monitor and variant
    states: Sequence[Element]  # states of all elements
    drive: Driven  # figures of the drive
    decision: str  # name of the decision by the filters
    problems: Sequence[Problem] = ()  # wiring errors
    lost: Mapping[str, Loss] = field(default_factory=dict)  # losses of signals during the drive, by element
    disagreeing: Mapping[str, Difference] = field(default_factory=dict)
    asked: Sequence[tuple[str, ...]] = ()  # pairs of targets that are inconsistent with the response of the actuators
    shifted: tuple[str, ...] = ()  # sensors that have shifted the zero of the steering angle
    interruptions: int = 0  # number of times that the judgement was interrupted
    notes: Sequence[str] = ()  # further warnings

    def of(self, *statuses: Status) -> list[Element]:
        return [each for each in self.states if each.status in statuses]

    def verdict(self) -> Verdict:
        drive, healthy = self.drive, self.of(Status.HEALTHY)
        open_ = [each for each in self.states if each.status is not Status.HEALTHY]
        if self.problems:
            return self._stated(Status.NOT_TESTABLE, _wired(self.problems[0]))
        if self.of(Status.FAULT, Status.SUSPECT):
            return self._faulty()
        if self.lost:
            return self._lost(len(healthy))
        if not healthy:
            # The cause of an element that is present, or else that of the absent ones.
            there = [each for each in open_ if each.status is not Status.NOT_AVAILABLE]
            first, case = (there or open_)[0], "nothing judged" if there else "nothing recorded"
            return self._stated(first.status, SENTENCES[case].filled(cause=first.cause))
        if drive.slid > HARDLY * drive.forward * drive.period:
            values = {"slid": drive.slid, "moving": drive.forward * drive.period}
            return self._stated(Status.NOT_TESTABLE, SENTENCES["hardly judged"].filled(**values), *self._instead(()))
        doubts = [self._of_targets("targets doubtful", each) for each in self.asked]
        stated = SENTENCES["healthy in part" if open_ else "healthy"]
        verdict = self._stated(Status.HEALTHY, stated.filled(healthy=len(healthy), seconds=drive.judged * drive.period))
        details = (f"not judged: {_by_cause(open_)}",) if open_ else ()
        return replace(verdict, details=details, facts=(*verdict.facts, *doubts))

    def _stated(self, status: Status, *because: Fact, **more: Any) -> Verdict:
        drive = self.drive
        evidence = {"seconds": drive.seconds, "moving_seconds": drive.forward * drive.period}
        if drive.backward:
            evidence["reversing_seconds"] = drive.backward * drive.period
        if self.interruptions:
            evidence["interruptions"] = float(self.interruptions)
        judged = self.of(Status.HEALTHY, Status.FAULT, Status.SUSPECT)
        evidence["sensors_and_actuators_judged"] = float(sum(each.name in ELEMENTS for each in judged))
        # With too few sensors a slide is not credible.
        unjudged = {cause: n * drive.period for cause, n in drive.unjudged.items() if cause != SLID or drive.enough}
        late = (f"{time:.0f} s were not judged: {cause}" for cause, time in unjudged.items() if time > LEAST_TOLD)
        notes = tuple(Fact("note", each) for each in (*self.notes, *late))
        return Verdict(self.name, status, because, evidence=evidence, facts=notes, **more)

    def _faulty(self) -> Verdict:
        faulty, doubtful = self.of(Status.FAULT), self.of(Status.SUSPECT)
        all_ = [(episode, each) for each in (*faulty, *doubtful) for episode in each.episodes]
        singles = _likeliest_first([(episode, each) for episode, each in all_ if not episode.candidates])
        declared = [each.name for each in (*faulty, *doubtful)]
        shifted = [SENTENCES[self.shifted]] if self.shifted and {*declared} == {*self.shifted} else []
        # Accelerations are judged beside the filters.
        decided = () if shifted or {*declared} <= {*ACCELERATIONS} else (self.decision,)
        if not singles:
            first = min((each for each, _ in all_), key=lambda each: each.declared_at)
            names = sorted(
                {each for episode, one in all_ for each in (one.name, *episode.candidates)}, key=ELEMENTS.index
            )
            several = self._between(names)
            because = [replace(several, cause=each.cause) for each in shifted] or [several, *self._instead(declared)]
            times = {"since": first.start, "declared": first.declared_at, "end": _end(all_)}
            details = (f"suspect {_when(replace(first, end=times['end']))}: {listed(names, 'or')}",)
            return self._stated(Status.SUSPECT, *because, details=details, decided_by=decided, **times)
        episode = min((each for each, _ in singles), key=lambda each: each.start)
        names = [each.name for each in faulty]
        lead = Fact("fault", "", _headline(singles), _action(names))
        because = [lead, *(shifted or (*self._why(names), *self._instead(declared)))]
        times = {"since": episode.start, "declared": episode.declared_at, "end": _end(singles)}
        sentences = [_sentence(*each) for each in singles]
        details = (*sentences[:3], *((f"and {len(sentences) - 3} more",) if len(sentences) > 3 else ()))
        return self._stated(
            Status.FAULT, *because, estimate=episode.magnitude, details=details, decided_by=decided, **times
        )

    def _between(self, names: Sequence[str]) -> Fact:
        """Several elements of which one is faulty."""
        reason = listed(names, "or")
        reason = reason if len(reason.split()) <= LONGEST else f"one of {len(names)} is wrong"
        causes = [several := SENTENCES["one of several"].filled(names=reason)]
        if targets := _targets(names):
            causes.append(SENTENCES["targets as well"].filled(targets=listed(targets)))
        # A tie-rod force with a gain of one half may, while small, stay below its own limit and exceed that of others.
        quiet = {each.name for each in self.of(Status.HEALTHY)}
        if {*names} <= {*STEERING_TORQUES} and (rest := [each for each in STEERING_TORQUES if each in quiet]):
            causes.append(SENTENCES["torques as well"].filled(rest=listed(rest)))
        return replace(several, cause="; ".join(each.cause for each in causes))

    def _why(self, names: Sequence[str]) -> list[Fact]:
        """Causes of the declared faults."""
        facts = []
        for name in ACCELERATIONS:
            if name in names:
                case = "still" if self.disagreeing[name].still else "acceleration"
                facts.append(SENTENCES[case].filled(name=name.replace("_", " "), motion=MOTION[name]))
        if any(name not in ACCELERATIONS for name in names):
            what = "readings and torques" if self.drive.asked else "the readings"
            facts.append(SENTENCES["residuals"].filled(what=what))
        if targets := _targets(names):
            facts.append(SENTENCES["targets instead"].filled(targets=listed(targets)))
        return facts

    def _instead(self, declared: Sequence[str]) -> tuple[Fact, ...]:
        """Inconsistent inputs of the filters, which have no substitute and may explain a declared fault."""
        doubtful = (
            SENTENCES["acceleration instead"].filled(
                name=name.replace("_", " "),
                size=in_words(each.magnitude, "m/s**2"),
                motion=MOTION[name],
                start=each.start,
            )
            for name, each in self.disagreeing.items()
            if not each.sure
        )
        # A faulty shaft torque sensor is itself inconsistent with the targets, which are then not named.
        alone = [*declared] == ["steering_shaft_torque"]
        pairs = (each for each in self.asked if not (alone and each == TARGETS[:2]))
        return (*doubtful, *(self._of_targets("pair instead", each) for each in pairs))

    @staticmethod
    def _of_targets(case: str, targets: Sequence[str]) -> Fact:
        shown = "the torque in the shaft" if targets == TARGETS[:2] else "the acceleration"
        return SENTENCES[case].filled(targets=listed(targets), shown=shown)

    def _lost(self, healthy: int) -> Verdict:
        """A signal that was lost during the drive: no fault, and not healthy either."""

        def order(loss: Loss) -> tuple[float, bool]:
            # By time, and a lost signal before the elements that cannot be judged without it.
            return math.inf if loss.since is None else loss.since, loss.status is not Status.NOT_AVAILABLE

        first = min(self.lost.values(), key=order)
        alike = [name for name, loss in self.lost.items() if loss.cause == first.cause]
        every = len(alike) >= sum(each.role == "sensor" for each in self.states)
        cause = first.cause if every else f"{listed(alike)}: {first.cause}"
        stated = SENTENCES["one lost" if len(alike) == 1 else "lost"].filled(cause=cause, names=listed(alike))
        if len(stated.reason.split()) > LONGEST:
            several = f"{listed(alike)} not judged throughout" if len(alike) < 3 else "signals were lost"
            stated = replace(stated, reason="" if every else several)
        count = sum(each.name not in ACCELERATIONS for each in self.states)
        rest = f"{healthy} of {count} are fault-free" if healthy else "nothing is judged from then on"
        return self._stated(first.status, stated, since=first.since, details=(rest,))


def _wired(first: Problem) -> Fact:
    wrong = {"time": "wrong time stamps", "rate": "low rate"}.get(first.kind, f"wrong {first.kind}")
    brief = shortened(first.cause)
    # The name of a signal alone says nothing.
    named = f"{wrong} of {listed(first.elements) if len(first.elements) == 1 else 'a signal'}"
    return Fact("wiring", first.cause, brief if 0 < len(brief.split()) <= LONGEST else named, first.action)


def _headline(singles: Sequence[tuple[Episode, Element]]) -> str:
    """The first fault, with as much as there is room for."""
    episode, element = singles[0]
    plain, kind = element.name.replace("_", " "), episode.kind.partition(" from ")[0] or "fault"
    others = len({each.name for _, each in singles}) - 1
    rest = f" and {others} more" if others else ""
    size = _size(episode.magnitude)
    offered = (f"{plain}{rest}: {kind}{size} since {episode.start:.0f} s", f"{plain}{rest}: {kind}{size}")
    return next((each for each in (*offered, f"{plain}{rest}: {kind}") if len(each.split()) <= LONGEST), plain + rest)


def _action(names: Sequence[str]) -> str:
    places = "the part itself, its wiring, its supply"
    if tuple(names) in (MOTORS, DRIVES):
        places = "the supply and the enabling of both, then each by itself"
    if {*ACTUATORS} & {*names}:
        places += f"; and the channel of {listed(_targets(names), 'or')}"
    elif {*ACCELERATIONS} & {*names}:
        places += ", and the channel map"
    return f"check {listed(names)}: {places}"


def _by_cause(open_: Sequence[Element]) -> str:
    """Elements that were not judged, grouped by cause; those absent from the recording come last."""
    lacking = [each.name for each in open_ if each.status is Status.NOT_AVAILABLE and each.cause.startswith(LACKING)]
    causes: dict[str, list[str]] = {}
    for each in open_:
        if each.name not in lacking:
            causes.setdefault(each.cause.partition(";")[0], []).append(each.name)
    named = [f"{listed(names)} ({cause})" for cause, names in causes.items()]
    return "; ".join((*named, *([f"{listed(lacking)} (not in the recording)"] if lacking else [])))


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


def _targets(names: Sequence[str]) -> list[str]:
    """Targets of the actuators among these, in pairs, since only the joint effect of a pair is observable."""
    together = [name for pair in (MOTORS, DRIVES) if {*pair} & {*names} for name in pair]
    return [target for actuator, target in zip(ACTUATORS, TARGETS, strict=True) if actuator in together]


def _size(magnitude: Estimate | None) -> str:
    return "" if magnitude is None else f" of {in_words(magnitude.value, magnitude.unit)}"


def _sentence(episode: Episode, element: Element) -> str:
    role = " sensor" if element.role == "sensor" else ""
    what = f"{episode.kind or 'fault'}{_size(episode.magnitude)}"
    return f"{element.name.replace('_', ' ')}{role}: {what} {_when(episode)}"


def _when(episode: Episode) -> str:
    """Onset, end and, where it came noticeably later than the onset, declaration in words."""
    until = "on" if episode.end is None else f"to {episode.end:.2f} s"
    late = "" if episode.belated is None else f" (declared at {episode.belated:.2f} s)"
    return f"from {episode.start:.2f} s {until}{late}"


def _end(found: Sequence[tuple[Episode, Element]]) -> float | None:
    """Time at which all episodes had ended [s]; None where one lasts."""
    ends = [each.end for each, _ in found if each.end is not None]
    return max(ends) if len(ends) == len(found) else None
