"""The 48 tests of the sensors: accuracy of every diagnosis as the paper defines it, and its figures."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from tierod.core.claims import Claim, Goal, at_least, at_most, exactly
from tierod.core.content import Chart, Heading, Item, Panel, Points
from tierod.core.signals import SIGNALS
from tierod.monitors.condition.weighing import Returning
from tierod_lab.papers.condition import causes, tables
from tierod_lab.papers.condition.drives import LOSS, OFFSET, OUTLIER, SENSORS, Drive, sensor_tests
from tierod_lab.papers.condition.reported import vehicles
from tierod_lab.papers.condition.rules.parameters import PAPER
from tierod_lab.papers.condition.runs import BEST, VARIANTS, scores
from tierod_lab.papers.condition.scoring import AMBIGUOUS, UNNAMED, DriveScore
from tierod_lab.papers.condition.summary import share_within, summary
from tierod_lab.papers.condition.truth import KNOWN
from tierod_lab.studies.effort import Effort

GOAL = "goal of tierod"
TEXT = (
    "Six sensors, four faults, two rounds, 60 s each, the fault from 20 to 40 s (an outlier for a second): 48 "
    "tests, with every vehicle. Accuracy is that of eq (53): the share of the samples at which the state of the "
    "sensor is right. It counts samples as wrong at which a lost signal is near zero in truth; the second accuracy "
    "leaves out those at which the fault is not observable and not declared.",
)
BACK = (
    f"A sensor that is right again counts as whole after {Returning.recovers:g} s in which its fault would show; near "
    "zero a lost signal and a right one read alike, and it stays declared. Quicker would take back faults that pause."
)
STRICT = "That test knows the motion; the bank has to estimate it, and a lost signal must leave its uncertainty first."
RULES = "The paper prints neither its thresholds nor the noises and drives behind its figures, which decide."
PLACES = tuple(name.replace("_", " ") for name in SENSORS)


def campaign(effort: Effort) -> list[Drive]:
    """Tests on all vehicles; a few tests on one vehicle if quick."""
    drives = [drive for number in vehicles(effort) for drive in sensor_tests(number)]
    return drives[::5] if effort.quick else drives


def items(effort: Effort) -> Iterator[Item]:
    if not VARIANTS:
        return
    drives = campaign(effort)
    found = scores(drives, effort)
    yield Heading("The 48 tests of the sensors", TEXT)
    yield tables.compared(f"The tests, vehicles driven: {len({each.vehicle for each in drives})}", found)
    yield tables.by_group(
        "Accuracy by sensor (Figure 20), mean / worst", found, lambda each: each.drive.injected[0].element, "sensor"
    )
    yield tables.by_group("Accuracy by fault, mean / worst", found, lambda each: each.drive.injected[0].kind, "fault")
    yield _figure_twenty(found)
    for name, several in found.items():
        yield tables.confused(f"What went by which name: {VARIANTS[name].title}", several)
    if BEST in found:
        yield tables.delays("Delay [s]", found[BEST], {kind: _of_kind(kind) for kind in (LOSS, OFFSET, OUTLIER)})
        yield from _claims(found[BEST])
    yield from _baseline(found)


def _of_kind(kind: str) -> Callable[[DriveScore], bool]:
    return lambda each: each.drive.injected[0].kind == kind


def _figure_twenty(found: tables.Scores) -> Chart:
    marks = []
    for name, several in found.items():
        parts = [summary([each for each in several if each.drive.injected[0].element == sensor]) for sensor in SENSORS]
        accuracy = np.array([part.accuracy for part in parts])
        worst = np.array([part.worst for part in parts])
        marks.append(Points(VARIANTS[name].title, PLACES, accuracy, worst, accuracy))
    return Chart(
        "condition-accuracy-sensors",
        "Accuracy by sensor (Figure 20)",
        "Mean over the tests of each sensor; the line reaches down to the worst test. The paper prints more than 0.95.",
        "Accuracies of six sensors by several diagnoses.",
        (Panel("accuracy", "sensor", "accuracy", tuple(marks), levels=(("printed", 0.95),)),),
    )


def _claim(key: str, claim: str, measured: float, goal: Goal | None, cause: str, unit: str = "") -> Claim:
    return Claim(f"sensors.{key}", claim, GOAL, None, measured, goal, unit, cause=cause)


def _claims(of: Sequence[DriveScore]) -> Iterator[Claim]:
    known, wrong = summary(of), f"{causes.wrong_time(of)} {BACK}"
    yield _claim("accuracy", "Mean accuracy of the 48 tests.", known.accuracy, at_least(0.993), wrong)
    yield _claim("worst", "Accuracy of the worst test.", known.worst, at_least(0.96), wrong)
    observable = "Accuracy of the worst test of observable faults."
    yield _claim("observable-worst", observable, known.worst_excused, at_least(0.98), wrong)
    named = "Share of the faults' time in which a fault-free sensor is named."
    yield _claim("wrong", named, known.wrong, exactly(0.0), causes.misnamed(of))
    yield _claim("missed", "Faults missed.", known.missed, exactly(0.0), causes.missed(of))
    yield from _delays(of)
    yield from _strict_claims(of)
    yield _claim("kinds", "Kinds named rightly after 2 s.", known.kinds, at_least(0.98), causes.kinds(of))
    sizes = "Relative error of sizes, 95 % quantile."
    yield _claim("sizes", sizes, known.size_error, at_most(0.1), causes.sizes(of))
    for sensor in SENSORS:
        errors = [f.rmse for each in of for f in each.faults if f.injected.element == sensor and np.isfinite(f.rmse)]
        worst = float(np.sqrt(np.mean(np.square(errors)))) if errors else np.nan
        name = sensor.replace("_", " ")
        key = f"value-{sensor.replace('_', '-')}"
        claim = f"Error of what replaces the {name}, from the declaration on."
        yield _claim(
            key,
            claim,
            worst,
            at_most(KNOWN[sensor]),
            f"Of {len(errors)} drives the worst: {max(errors, default=np.nan):.3g}.",
            SIGNALS[sensor].unit,
        )


def _delays(of: Sequence[DriveScore]) -> Iterator[Claim]:
    by_kind = {kind: [each for each in of if _of_kind(kind)(each)] for kind in (OFFSET, OUTLIER, LOSS)}
    found = {kind: summary(several) for kind, several in by_kind.items()}
    shown = {kind: causes.late(several, lambda fault: fault.delay_shown) for kind, several in by_kind.items()}
    outliers, offsets, losses = found[OUTLIER].delays_shown, found[OFFSET].delays, found[LOSS].delays_shown
    late = causes.late(by_kind[OFFSET], lambda fault: fault.delay)
    outlier = "Longest delay of an observable outlier."
    yield _claim("outliers", outlier, longest(outliers), at_most(0.2), shown[OUTLIER], "s")
    yield _claim("offsets-soon", "Offsets found within 0.2 s.", share_within(offsets, 0.2), at_least(0.9), late)
    yield _claim(
        "offsets",
        "Longest delay of an offset, with limits of the vehicle's own drives.",
        longest(offsets),
        at_most(0.35),
        late,
        "s",
    )
    soon = "Losses found within 0.2 s of showing."
    yield _claim("losses-soon", soon, share_within(losses, 0.2), at_least(0.9), shown[LOSS])
    loss = "Longest delay of a loss from where it is observable."
    yield _claim("losses", loss, longest(losses), at_most(0.35), shown[LOSS], "s")


def _strict_claims(of: Sequence[DriveScore]) -> Iterator[Claim]:
    """Claims for faults that count as observable where a test with true parameters and motion detects them."""
    known, sees = summary(of).strict, "seen by a likelihood-ratio test with true parameters"
    yield _claim("strict-missed", f"Faults missed, {sees}.", known.missed, exactly(0.0), causes.missed(of))
    worst = f"Accuracy of the worst test of faults {sees}."
    yield _claim("strict-worst", worst, known.worst, at_least(0.96), f"{causes.wrong_time(of)} {BACK}")
    late = causes.late(of, lambda fault: fault.strict.delay_shown if fault.strict else np.nan)
    delay = f"Longest delay of a fault, from where it is {sees}."
    yield _claim("strict-delay", delay, longest(known.delays), at_most(0.5), f"{late} {STRICT}", "s")


def _baseline(found: tables.Scores) -> Iterator[Claim]:
    for name, several in found.items():
        if name == BEST:
            continue
        known = summary(several)
        title = VARIANTS[name].title
        source = f"{PAPER}Figure 20"
        for key, claim, printed, measured, goal in (
            ("accuracy", "Mean accuracy", "> 0.95", known.accuracy, at_least(0.95)),
            ("worst", "Accuracy of the worst test", 0.86, known.worst, at_least(0.86)),
        ):
            cause = f"{RULES} On these drives: {_weakest(several)}."
            yield Claim(
                f"rules.{name}-{key}",
                f"{claim}: {title}.",
                source,
                printed,
                measured,
                goal,
                cause=cause,
                irreproducible=True,
            )
        yield Claim(
            f"rules.{name}-wrong", f"Time with a fault-free sensor named: {title}.", source, None, known.wrong, None
        )
        yield Claim(f"rules.{name}-missed", f"Faults missed: {title}.", source, None, known.missed, None)


def _weakest(of: Sequence[DriveScore]) -> str:
    """Text with the sensors and kinds of lowest accuracy, and the number of faults that were not isolated."""
    faults = [fault for each in of for fault in each.faults]
    groups = dict.fromkeys((fault.injected.element, fault.injected.kind) for fault in faults)
    mean = {
        group: float(np.mean([f.accuracy for f in faults if (f.injected.element, f.injected.kind) == group]))
        for group in groups
    }
    least = sorted(groups, key=mean.__getitem__)[:3]
    words = ", ".join(f"{sensor.replace('_', ' ')} {kind} {mean[sensor, kind]:.3f}" for sensor, kind in least)
    ambiguous = sum(each.named in (AMBIGUOUS, UNNAMED) for each in of)
    return f"accuracy least for {words}; {ambiguous} of {len(of)} faults named not at all or only among several"


def longest(delays: np.ndarray) -> float:
    """The last of ascending delays [s]; NaN without any."""
    return float(delays[-1]) if len(delays) else float("nan")
