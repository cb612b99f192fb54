"""Faults injected into recordings of real cars: detection, isolation, and false alarms without a fault."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_least, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Channel, Recording
from tierod.monitors.condition.definition import SLOW, WITH_WHEELS, WITHOUT_WHEELS, rolling_monitor
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition import causes, tables
from tierod_lab.papers.condition.by_rules import said as said_by_rules
from tierod_lab.papers.condition.drives import LOSS, OFFSET, OFFSETS, OUTLIER, OUTLIER_FACTOR, Drive, Injected
from tierod_lab.papers.condition.real_diagnoses import RULES, SETTLED, accuracy, healthy_ratios, learnt, said
from tierod_lab.papers.condition.real_recordings import CARS, SENSORS, RealCar, on_grid
from tierod_lab.papers.condition.runs import BEST, VARIANTS
from tierod_lab.papers.condition.scoring import GRACE, DriveScore, score
from tierod_lab.papers.condition.sensors import GOAL
from tierod_lab.papers.condition.summary import isolated, summary
from tierod_lab.papers.condition.truth import KNOWN, Declared, Truth
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.studies.effort import Effort

TEXT = (
    "A minute of a RAV4 on a highway and 20 s of a passenger car in tight bends, with the sensors that both have: "
    "rear wheel speeds, yaw rate, steering angle, accelerations (that of the passenger car along the road is not "
    "recorded). Their torques are unknown, so the bank judges them by their motion. Its limits come from the "
    "first half of the highway minute, its noises from there and from the first 9 s of the passenger car, offsets it "
    "finds on the way; the rules learn understeer and thresholds on the same beginnings. What is later is judged: each "
    "sensor fails at three instants, lost, with an offset of the tests' size and either sign, and an outlier of a "
    "second. A fault is observable where it exceeds three standard deviations of the accuracy required of the "
    "demonstrator's sensors, or of the estimate by the other sensors of this car, measured on the beginning, where "
    "that is less exact. Faults missed by either criterion alone stand beside it.",
)


class Judged(NamedTuple):
    """Diagnosis of the recording of a car."""

    quiet: DriveScore  # score of the unchanged recording after its learning part
    found: list[DriveScore]  # scores with every fault; observable by the less accurate of the two criteria below
    asked: list[DriveScore]  # the same, observable by the accuracy required of the demonstrator's sensors
    own: list[DriveScore]  # the same, observable by the accuracy that the other sensors of this car reach


def items(effort: Effort) -> Iterator[Item]:
    if BEST not in VARIANTS:
        return
    yield Heading("Real cars", TEXT)
    rows, claims = [], []
    recordings = {car: car.recording() for car in CARS}
    for car, recording in recordings.items():
        if recording is None:
            claims.append(
                Claim(f"cars.{car.vehicle}", f"Faults in a {car.name}.", GOAL, None, None, exactly(0.0), "", NO_DATA)
            )
            continue
        for name in (BEST, RULES):
            found = judged(car, recording, name, effort.quick)
            rows.append((car.name, VARIANTS[name].title, *_figures(found)))
            if name == BEST:
                yield tables.named(f"What went by which name: {car.name}", found.found)
                claims += _claims(car, found, accuracy(car, recording))
    here = {car: recording for car, recording in recordings.items() if recording is not None}
    if here:
        yield Table("Faults put into recordings of real cars", _HEADER, tuple(rows), _NOTE)
        if not effort.quick:
            yield at_other_instants(here)
        yield _accuracies(here)
        yield _ratios(here)
    yield from claims


_HEADER = (
    *("car", "diagnosis", "faults", "missed", "never observable", "missed, as required"),
    *(
        "missed, by the car's sensors",
        "named rightly",
        "ambiguous",
        "time wrong",
        "median delay [s]",
        "longest [s]",
        "kind right",
        "false alarms",
    ),
)
_NOTE = "The last column counts declarations after the learning in the recording as it was made."


def _figures(of: Judged) -> tuple[str, ...]:
    known, isolation = summary(of.found), isolated(of.found)
    delays = known.delays_shown
    return (
        str(len(of.found)),
        str(known.missed),
        str(known.not_testable),
        str(summary(of.asked).missed),
        str(summary(of.own).missed),
        f"{isolation.right:.3f}",
        f"{isolation.ambiguous:.3f}",
        f"{known.wrong:.4f}",
        f"{np.median(delays) if len(delays) else np.nan:.2f}",
        f"{max(delays, default=np.nan):.2f}",
        f"{known.kinds:.3f}" if np.isfinite(known.kinds) else "–",
        str(of.quiet.false_alarms),
    )


def _claims(car: RealCar, of: Judged, own: Mapping[str, float]) -> list[Claim]:
    known, isolation = summary(of.found), isolated(of.found)
    missed, none = "Injected faults missed", exactly(0.0)
    asked, alone = (
        f"{missed}, observable by the demonstrator's accuracy",
        f"{missed}, observable by the car's own sensors",
    )
    lost = [f"{causes.missed(several)} {_beside(own)}" for several in (of.found, of.asked, of.own)]
    misnamed = causes.misnamed(of.found)
    return [
        Claim(f"cars.{car.vehicle}-{key}", f"{claim}, {car.name}.", GOAL, None, measured, goal, cause=cause)
        for key, claim, measured, goal, cause in (
            ("missed", missed, known.missed, none, lost[0]),
            ("missed-asked", asked, summary(of.asked).missed, none, lost[1]),
            ("missed-own", alone, summary(of.own).missed, none, lost[2]),
            ("named", "Injected faults named and nothing else", isolation.right, at_least(0.9), misnamed),
            ("wrong", "Time of the faults with a fault-free sensor named", known.wrong, none, misnamed),
            (
                "alarms",
                "False alarms where nothing was injected",
                of.quiet.false_alarms,
                none,
                causes.alarms([of.quiet]),
            ),
        )
    ]


def _beside(own: Mapping[str, float]) -> str:
    """Text with the accuracies of a car beside those required of the demonstrator, and the noises of the bank."""
    words = ", ".join(
        f"{name.replace('_', ' ')} {known:.2g} ({KNOWN[name]:.2g} asked of the demonstrator)"
        for name, known in own.items()
    )
    return (
        f"The other sensors of this car estimate each reading to: {words}. The bank reckons with noises and limits "
        "that two cars need together, on rough roads too, and a fault counts only where it exceeds those; limits of "
        "the car's own fault-free drives may mend a part."
    )


def at_other_instants(here: Mapping[RealCar, Recording]) -> Table:
    """Table of the bank with the same faults at many instants of the judged part."""
    rows = []
    for car, recording in here.items():
        first, last = recording.span
        starts = np.arange(car.learning + 1.0, last - first - car.lasting - GRACE, car.lasting / 4.0)
        found = judged(replace(car, starts=tuple(starts.tolist())), recording).found
        known, isolation = summary(found), isolated(found)
        wrong, later = sum(each.wrong_share > 0.0 for each in found), sum(each.false_alarms for each in found)
        cells = (len(starts), len(found), known.missed, f"{isolation.right:.3f}", wrong, later)
        rows.append((car.name, *map(str, cells)))
    header = (
        "car",
        "instants",
        "faults",
        "missed",
        "named rightly",
        "with a fault-free sensor named",
        "declared afterwards",
    )
    note = f"Afterwards: a fault-free sensor, or the one that failed more than {GRACE:g} s after the end of its fault."
    return Table("The bank, with faults at other instants", header, tuple(rows), note)


def _accuracies(here: Mapping[RealCar, Recording]) -> Table:
    measured = {car: accuracy(car, recording) for car, recording in here.items()}
    rows = tuple(
        (name, f"{KNOWN[name]:.3g}", *(f"{found[name]:.3g}" for found in measured.values())) for name in SENSORS
    )
    note = "Of the filter that leaves the sensor out, against its reading, on the beginning of each recording."
    title = "Accuracy of a reading estimated by the other sensors, standard deviation"
    return Table(title, ("sensor", "asked of the demonstrator", *(car.name for car in here)), rows, note)


def _ratios(here: Mapping[RealCar, Recording]) -> Table:
    rows = []
    for car, recording in here.items():
        first, last = recording.span
        for what, start, stop in (
            ("learnt", SETTLED, car.learning),
            ("not seen before", car.learning, last - first),
        ):
            figures = healthy_ratios(car, recording, start, stop)
            rows.append((car.name, what, f"{stop - start:.0f}", *(f"{each:.1f}" for each in figures)))
    rows.append(("limits", "", "", f"{WITH_WHEELS:g}", f"{WITHOUT_WHEELS:g}", f"{SLOW:g}"))
    header = ("car", "part", "length [s]", "with wheels, short", "without wheels, short", "long")
    note = "Largest ratio of any hypothesis that lasts for three samples, per sample; over 0.05 s and over 0.5 s."
    return Table("Ratios of fault-free recordings [nat]", header, tuple(rows), note)


def judged(
    car: RealCar,
    recording: Recording,
    name: str = BEST,
    quick: bool = False,
    kinds: Callable[[str, float, float], tuple[Injected, ...]] | None = None,
) -> Judged:
    """Scores of a recording after its learning part, unchanged and with every injected fault.

    Args:
        name: diagnosis, the bank or the rules that discriminate
        quick: whether each fault is injected at one instant only
        kinds: function that gives the faults of a sensor from its name, start [s] and duration [s]; those of the tests
            if None
    """
    own = accuracy(car, recording)
    measures = [{name: max(own[name], KNOWN[name]) for name in SENSORS}, KNOWN, own]
    if name == RULES:
        recording = on_grid(recording)
        diagnosis = partial(said_by_rules, learnt(car, recording))
    else:
        diagnosis = partial(said, rolling_monitor(car.known))
    starts = car.starts[:1] if quick else car.starts
    faults = [
        each for start in starts for sensor in SENSORS for each in (kinds or faults_of)(sensor, start, car.lasting)
    ]
    scored = [_scored(car, recording, diagnosis, (each,), measures) for each in faults]
    return Judged(
        _scored(car, recording, diagnosis, (), measures)[0], *(list(each) for each in zip(*scored, strict=True))
    )


def faults_of(sensor: str, start: float, lasting: float) -> tuple[Injected, ...]:
    """The faults of the tests for one sensor.

    Args:
        start: beginning of the faults on the clock of the recording [s]
        lasting: duration of all but the outlier, which lasts for a second [s]
    """
    end, size = start + lasting, OFFSETS[sensor]
    return (
        Injected(sensor, LOSS, start=start, end=end),
        Injected(sensor, OFFSET, size, start, end),
        Injected(sensor, OFFSET, -size, start, end),
        Injected(sensor, OUTLIER, OUTLIER_FACTOR, start, start + 1.0),
    )


def _scored(
    car: RealCar,
    fault_free: Recording,
    diagnosis: Callable[[Recording], Declared],
    faults: tuple[Injected, ...],
    measures: Sequence[Mapping[str, float]],
) -> list[DriveScore]:
    """Scores after the learning part, one per criterion of observability; the unchanged recording is the truth."""
    declared = diagnosis(injected(fault_free, [each.fault for each in faults]) if faults else fault_free)
    time = declared.time
    judged_from = int(np.searchsorted(time, time[0] + car.learning))
    read = {
        each.element: np.interp(time, fault_free[each.element].time, fault_free[each.element].values) for each in faults
    }
    off = {each.element: _failing(each, time, read[each.element]) - read[each.element] for each in faults}
    truth = Truth(
        {name: each[judged_from:] for name, each in off.items()},
        {name: each[judged_from:] for name, each in read.items()},
        {},
    )
    # A label for the score; nothing is simulated.
    drive = Drive(car.name, float(time[-1]), 0, 0, faults)
    later = declared.since(judged_from)
    return [score(drive, truth._replace(known=known), later) for known in measures]


def _failing(each: Injected, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    name = each.element
    return injected(Recording({name: Channel(name, time, values, "")}), [each.fault])[name].values
