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
from tierod.monitors.condition.courses import listed
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
)
from tierod.monitors.condition.wiring import Problem

COMPARED = ("wheel_speed_rear_left", "wheel_speed_rear_right", "yaw_rate")
"""Sensors of the motion with which the accelerations are compared."""
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

SENTENCES: dict[str, str | tuple[str, str, str]] = {
    "healthy": ("", "all {healthy} judged fault-free over {seconds:.0f} s", "none"),
    "healthy in part": (
        "not judged: {open}",
        "all {healthy} judged fault-free over {seconds:.0f} s",
        "none for the {healthy} that were judged; for each of the others see the cause named beside it",
    ),
    "hardly judged": (
        "{slid:.0f} of {moving:.0f} s of driving were not judged: " + SLID,
        "too little of the drive was judged",
        "drive on a dry road, below 6 m/s² lateral acceleration, with bends both ways and changes of speed; if the "
        "drive was like this, check lateral and longitudinal acceleration and the tyre and mass parameters of the "
        "vehicle file",
    ),
    "lost": (
        "{cause}",
        "{cause}",
        "check the bus, supply or logger that they share, and then the sensors themselves; record again",
    ),
    "one lost": (
        "{cause}",
        "{cause}",
        "check {names}: the sensor itself, its wiring, its supply and its messages; record again",
    ),
    "nothing judged": (
        "{cause}",
        "none was judged",
        "record a drive with bends and changes of speed, with all signals",
    ),
    "nothing recorded": (
        f"{TOO_FEW}; the recording has no wheel speed, no yaw rate and no steering wheel angle",
        "none was judged",
        MAP_FIRST,
    ),
    "one of several": (
        "several of them explain the readings equally well, and the drive does not isolate one",
        "{names}",
        "check them one by one, or drive with more steering and braking",
    ),
    "targets as well": "so does a wrong recording of the targets ({targets})",
    "torques as well": "so may a wrong {rest}, which belongs to the same torque balance",
    "residuals": "residuals of readings and torques exceed the fault-free limits",
    "acceleration": "{name} contradicts {motion}",
    "targets instead": "the recorded targets ({targets}) may be wrong instead of the actuators",
    "acceleration instead": "{name} may be the cause instead: it differs by {size} from {motion} from {start:.0f} s "
    "on, more than usual",
    "pair instead": "{targets} may be the cause instead: the targets contradict {shown}",
    "targets doubtful": "{targets}: the targets contradict {shown}, but too little for a verdict; check the channels "
    "and the actuators",
    "angle shifted": f"the mean steering angle in gentle driving {_SHIFTED} yaw rate and wheel speeds fit each other",
    "yaw rate shifted": f"the mean yaw rate in gentle driving {_SHIFTED} steering angle and wheel speeds fit each "
    "other",
    "zero shifted": f"the difference of steering angle and yaw rate in gentle driving {_SHIFTED} the wheel speeds do "
    "not show which of them is wrong",
}
"""Case -> cause; or cause, reason for the headline, and action."""
SHIFTED = {SHIFTING[:1]: "angle shifted", SHIFTING[1:]: "yaw rate shifted", SHIFTING: "zero shifted"}


def fact(case: str, **values: Any) -> Fact:
    said = SENTENCES[case]
    cause, reason, action = (each.format(**values) for each in ((said, "", "") if isinstance(said, str) else said))
    return Fact(case, cause, reason if len(reason.split()) <= LONGEST else "", action)


@dataclass(frozen=True)
class Found:
    """What the filters and the checks have found on a drive."""

    name: str  # name of monitor and variant
    states: Sequence[Element]  # states of all elements
    drive: Driven  # figures of the drive
    decision: str  # name of the decision by the filters
    problems: Sequence[Problem] = ()  # wiring errors
    lost: Mapping[str, Loss] = field(default_factory=dict)  # losses of signals during the drive, by element
    # accelerations that are inconsistent with the motion, by name
    disagreeing: Mapping[str, Difference] = field(default_factory=dict)
    asked: Sequence[tuple[str, ...]] = ()  # pairs of targets that are inconsistent with the response of the actuators
    shifted: tuple[str, ...] = ()  # sensors that have shifted the zero of the steering angle
    interruptions: int = 0  # number of times that the judgement was interrupted
    notes: Sequence[str] = ()  # further warnings

    def of(self, *statuses: Status) -> list[Element]:
        return [each for each in self.states if each.status in statuses]


def verdict_of_drive(found: Found) -> Verdict:
    drive, healthy = found.drive, found.of(Status.HEALTHY)
    open_ = [each for each in found.states if each.status is not Status.HEALTHY]
    if found.problems:
        first = found.problems[0]
        wrong = {"time": "wrong time stamps", "rate": "low rate"}.get(first.kind, f"wrong {first.kind}")
        brief = shortened(first.cause)
        # The name of a signal alone says nothing.
        named = f"{wrong} of {listed(first.elements) if len(first.elements) == 1 else 'a signal'}"
        reason = brief if 0 < len(brief.split()) <= LONGEST else named
        return _stated(found, Status.NOT_TESTABLE, Fact("wiring", first.cause, reason, first.action))
    if found.of(Status.FAULT, Status.SUSPECT):
        return _faulty(found)
    if found.lost:
        return _lost(found, healthy)
    if not healthy:
        return _nothing_judged(found, open_)
    if drive.slid > HARDLY * drive.forward * drive.period:
        hardly = fact("hardly judged", slid=drive.slid, moving=drive.forward * drive.period)
        return _stated(found, Status.NOT_TESTABLE, hardly, *_instead(found, ()))
    doubts = [fact("targets doubtful", targets=listed(each), shown=_shown_by(each)) for each in found.asked]
    count = sum(each.name not in ACCELERATIONS for each in found.states)
    case = "healthy in part" if open_ else "healthy"
    values = {"healthy": len(healthy), "all": count, "seconds": drive.judged * drive.period, "open": _by_cause(open_)}
    stated = fact(case, **values)
    verdict = _stated(found, Status.HEALTHY, replace(stated, cause=""))
    details = tuple(each for each in (stated.cause,) if each)
    return replace(verdict, details=details, facts=(*verdict.facts, *doubts))


def _stated(found: Found, status: Status, *because: Fact, **more: Any) -> Verdict:
    drive = found.drive
    evidence = {"seconds": drive.seconds, "moving_seconds": drive.forward * drive.period}
    if drive.backward:
        evidence["reversing_seconds"] = drive.backward * drive.period
    if found.interruptions:
        evidence["interruptions"] = float(found.interruptions)
    judged = found.of(Status.HEALTHY, Status.FAULT, Status.SUSPECT)
    evidence["sensors_and_actuators_judged"] = float(sum(each.name in ELEMENTS for each in judged))
    # With too few sensors a slide is not credible.
    unjudged = {cause: n * drive.period for cause, n in drive.unjudged.items() if cause != SLID or drive.enough}
    late = (f"{time:.0f} s were not judged: {cause}" for cause, time in unjudged.items() if time > LEAST_TOLD)
    notes = tuple(Fact("note", each) for each in (*found.notes, *late))
    return Verdict(found.name, status, because, evidence=evidence, facts=notes, **more)


def _faulty(found: Found) -> Verdict:
    faulty, doubtful = found.of(Status.FAULT), found.of(Status.SUSPECT)
    all_ = [(episode, each) for each in (*faulty, *doubtful) for episode in each.episodes]
    singles = _likeliest_first([(episode, each) for episode, each in all_ if not episode.candidates])
    declared = [each.name for each in (*faulty, *doubtful)]
    shifted = [fact(SHIFTED[found.shifted])] if found.shifted and {*declared} == {*found.shifted} else []
    # Accelerations are judged beside the filters.
    decided = () if shifted or {*declared} <= {*ACCELERATIONS} else (found.decision,)
    if not singles:
        first = min((each for each, _ in all_), key=lambda each: each.declared_at)
        names = sorted({each for episode, one in all_ for each in (one.name, *episode.candidates)}, key=ELEMENTS.index)
        several = _between(names, found)
        because = [replace(several, cause=each.cause) for each in shifted] or [several, *_instead(found, declared)]
        times = {"since": first.start, "declared": first.declared_at, "end": _end(all_)}
        details = (f"suspect {_when(replace(first, end=times['end']))}: {listed(names, 'or')}",)
        return _stated(found, Status.SUSPECT, *because, details=details, decided_by=decided, **times)
    episode = min((each for each, _ in singles), key=lambda each: each.start)
    names = [each.name for each in faulty]
    sentences = [_sentence(*each) for each in singles]
    more = (f"and {len(sentences) - 3} more",) if len(sentences) > 3 else ()
    lead = Fact("fault", "", _headline(singles), _action(names))
    because = [lead, *(shifted or (*_why(names), *_instead(found, declared)))]
    times = {"since": episode.start, "declared": episode.declared_at, "end": _end(singles)}
    details = (*sentences[:3], *more)
    return _stated(
        found, Status.FAULT, *because, estimate=episode.magnitude, details=details, decided_by=decided, **times
    )


def _headline(singles: Sequence[tuple[Episode, Element]]) -> str:
    """The first fault, with as much as there is room for."""
    episode, element = singles[0]
    plain, kind = element.name.replace("_", " "), episode.kind.partition(" from ")[0] or "fault"
    others = len({each.name for _, each in singles}) - 1
    rest = f" and {others} more" if others else ""
    size = _size(episode.magnitude)
    offered = (f"{plain}{rest}: {kind}{size} since {episode.start:.0f} s", f"{plain}{rest}: {kind}{size}")
    return next((each for each in (*offered, f"{plain}{rest}: {kind}") if len(each.split()) <= LONGEST), plain + rest)


def _between(names: Sequence[str], found: Found) -> Fact:
    """Several elements of which one is faulty."""
    several = fact("one of several", names=listed(names, "or"))
    causes = [several]
    if targets := _targets(names):
        causes.append(fact("targets as well", targets=listed(targets)))
    # A tie-rod force with a gain of one half may, while small, stay below its own limit and exceed that of others.
    quiet = {each.name for each in found.of(Status.HEALTHY)}
    if {*names} <= {*STEERING_TORQUES} and (rest := [each for each in STEERING_TORQUES if each in quiet]):
        causes.append(fact("torques as well", rest=listed(rest)))
    reason = several.reason or f"one of {len(names)} is wrong"
    return replace(several, cause="; ".join(each.cause for each in causes), reason=reason)


def _action(names: Sequence[str]) -> str:
    places = "the part itself, its wiring, its supply"
    if tuple(names) in (MOTORS, DRIVES):
        places = "the supply and the enabling of both, then each by itself"
    if {*ACTUATORS} & {*names}:
        places += f"; and the channel of {listed(_targets(names), 'or')}"
    elif {*ACCELERATIONS} & {*names}:
        places += ", and the channel map"
    return f"check {listed(names)}: {places}"


def _why(names: Sequence[str]) -> tuple[Fact, ...]:
    """Causes of the declared faults."""
    facts = [
        fact("acceleration", name=name.replace("_", " "), motion=MOTION[name])
        for name in names
        if name in ACCELERATIONS
    ]
    if any(name not in ACCELERATIONS for name in names):
        facts.append(fact("residuals"))
    if targets := _targets(names):
        facts.append(fact("targets instead", targets=listed(targets)))
    return tuple(facts)


def _instead(found: Found, declared: Sequence[str]) -> tuple[Fact, ...]:
    """Inconsistent inputs of the filters, which have no substitute and may explain a declared fault."""
    facts = [
        fact(
            "acceleration instead",
            name=name.replace("_", " "),
            size=in_words(each.magnitude, "m/s**2"),
            motion=MOTION[name],
            start=each.start,
        )
        for name, each in found.disagreeing.items()
        if not each.sure
    ]
    # A faulty shaft torque sensor is itself inconsistent with the targets, which are then not named.
    alone = [*declared] == ["steering_shaft_torque"]
    return (
        *facts,
        *(
            fact("pair instead", targets=listed(targets), shown=_shown_by(targets))
            for targets in found.asked
            if not (alone and targets == TARGETS[:2])
        ),
    )


def _shown_by(targets: Sequence[str]) -> str:
    return "the torque in the shaft" if targets == TARGETS[:2] else "the acceleration"


def _by_cause(open_: Sequence[Element]) -> str:
    """Elements that were not judged, grouped by cause; those absent from the recording come last."""
    lacking = [each.name for each in open_ if each.status is Status.NOT_AVAILABLE and each.cause.startswith(LACKING)]
    causes: dict[str, list[str]] = {}
    for each in open_:
        if each.name not in lacking:
            causes.setdefault(each.cause.partition(";")[0], []).append(each.name)
    causes_named = [f"{listed(names)} ({cause})" for cause, names in causes.items()]
    return "; ".join((*causes_named, *([f"{listed(lacking)} (not in the recording)"] if lacking else [])))


def _lost(found: Found, healthy: Sequence[Element]) -> Verdict:
    """A signal that was lost during the drive: no fault, and not healthy either."""

    def order(loss: Loss) -> tuple[float, bool]:
        # By time, and a lost signal before the elements that cannot be judged without it.
        return math.inf if loss.since is None else loss.since, loss.status is not Status.NOT_AVAILABLE

    first = min(found.lost.values(), key=order)
    alike = [name for name, loss in found.lost.items() if loss.cause == first.cause]
    every = len(alike) >= sum(each.role == "sensor" for each in found.states)
    count = sum(each.name not in ACCELERATIONS for each in found.states)
    stated = fact("one lost" if len(alike) == 1 else "lost", cause=first.cause, names=listed(alike))
    reason = stated.reason if every else f"{listed(alike)}: {first.cause}"
    if len(reason.split()) > LONGEST:
        reason = f"{listed(alike)} not judged throughout" if len(alike) < 3 else "signals were lost"
    cause = stated.cause if every else f"{listed(alike)}: {stated.cause}"
    rest = f"{len(healthy)} of {count} are fault-free" if healthy else "nothing is judged from then on"
    return _stated(found, first.status, replace(stated, cause=cause, reason=reason), since=first.since, details=(rest,))


def _nothing_judged(found: Found, open_: Sequence[Element]) -> Verdict:
    """No judged element: the cause of a present one, or else that of the absent ones."""
    there = [each for each in open_ if each.status is not Status.NOT_AVAILABLE]
    first = (there or open_)[0]
    stated = fact("nothing judged", cause=first.cause) if there else fact("nothing recorded")
    return _stated(found, first.status, stated)


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
