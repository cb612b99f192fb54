"""The 48 tests of the sensors: every diagnosis by the measure of the paper, and the figures that it prints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from tierod.core.claims import Claim, Goal, at_least, at_most, exactly
from tierod.core.content import Chart, Heading, Item, Panel, Points
from tierod.experiments.effort import Effort
from tierod.papers.condition import tables
from tierod.papers.condition.drives import SENSORS, Drive, sensor_tests
from tierod.papers.condition.faults import LOSS, OFFSET, OUTLIER
from tierod.papers.condition.reported import vehicles
from tierod.papers.condition.runs import BEST, VARIANTS, scores
from tierod.papers.condition.scoring import DriveScore
from tierod.papers.condition.summary import Summary, share_within, summary

PAPER = "Li, Frey, Gauterin, "
GOAL = "goal of tierod"
TEXT = (
    "Six sensors, four faults, two rounds, 60 s each, the fault from 20 to 40 s (an outlier for a second): 48 "
    "tests, with every vehicle. Accuracy is that of eq (53): the share of the samples at which the state of the "
    "sensor is right. It counts samples as wrong at which a lost signal is near zero in truth; the second accuracy "
    "leaves out those at which the fault is not observable and not declared.",
)
VALUES = {
    "wheel_speed_rear_left": (0.015, "m/s"),
    "wheel_speed_rear_right": (0.015, "m/s"),
    "yaw_rate": (0.01, "rad/s"),
    "steering_wheel_angle": (0.1, "rad"),
    "steering_shaft_torque": (0.35, "N*m"),
    "tie_rod_force": (45.0, "N"),
}
"""Goal of the error of every sensor's replaced value, root mean square, and its unit."""

STRICT = "That test knows the motion; the bank has to estimate it, and a lost signal must leave its uncertainty first."
RULES = "The paper prints neither thresholds nor noises; with the drives of its authors they may be met."
PLACES = tuple(name.replace("_", " ") for name in SENSORS)


def campaign(effort: Effort) -> list[Drive]:
    """The tests of all vehicles, or a few of one."""
    drives = [drive for number in vehicles(effort) for drive in sensor_tests(number)]
    return drives[::5] if effort.quick else drives


def items(effort: Effort) -> Iterator[Item]:
    """Accuracy as in Figure 20, delays, confusion, replaced values."""
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


def _claim(key: str, claim: str, measured: float, goal: Goal | None, unit: str = "", note: str = "") -> Claim:
    return Claim(f"sensors.{key}", claim, GOAL, None, measured, goal, unit, note)


def _claims(of: Sequence[DriveScore]) -> Iterator[Claim]:
    known = summary(of)
    offsets = summary([each for each in of if each.drive.injected[0].kind == OFFSET]).delays
    outliers = summary([each for each in of if each.drive.injected[0].kind == OUTLIER]).delays_shown
    losses = summary([each for each in of if each.drive.injected[0].kind == LOSS]).delays_shown
    yield _claim("accuracy", "Mean accuracy of the 48 tests.", known.accuracy, at_least(0.993))
    yield _claim("worst", "Accuracy of the worst test.", known.worst, at_least(0.96))
    yield _claim(
        "observable-worst",
        "Accuracy of the worst test of observable faults.",
        known.worst_excused,
        at_least(0.98),
    )
    yield _claim("wrong", "Share of the faults' time in which a fault-free sensor is named.", known.wrong, exactly(0.0))
    yield _claim("missed", "Faults missed.", known.missed, exactly(0.0))
    yield _claim("outliers", "Longest delay of an observable outlier.", longest(outliers), at_most(0.2), "s")
    yield _claim("offsets-soon", "Offsets found within 0.2 s.", share_within(offsets, 0.2), at_least(0.9))
    yield _claim("offsets", "Longest delay of an offset.", longest(offsets), at_most(0.35), "s")
    yield _claim("losses-soon", "Losses found within 0.2 s of showing.", share_within(losses, 0.2), at_least(0.9))
    yield _claim("losses", "Longest delay of a loss from where it is observable.", longest(losses), at_most(0.35), "s")
    yield from _strict_claims(known)
    yield _claim("kinds", "Kinds named rightly after 2 s.", known.kinds, at_least(0.98))
    yield _claim("sizes", "Relative error of sizes, 95 % quantile.", known.size_error, at_most(0.1))
    for sensor, (limit, unit) in VALUES.items():
        errors = [f.rmse for each in of for f in each.faults if f.injected.element == sensor and np.isfinite(f.rmse)]
        worst = float(np.sqrt(np.mean(np.square(errors)))) if errors else np.nan
        name = sensor.replace("_", " ")
        key = f"value-{sensor.replace('_', '-')}"
        yield _claim(key, f"Error of what replaces the {name}, from the declaration on.", worst, at_most(limit), unit)


def _strict_claims(known: Summary) -> Iterator[Claim]:
    """The same, where a fault is observable as soon as a test with true parameters and motion detects it."""
    sees = "seen by a likelihood-ratio test with true parameters"
    yield _claim("strict-missed", f"Faults missed, {sees}.", known.strict.missed, exactly(0.0))
    yield _claim("strict-worst", f"Accuracy of the worst test of faults {sees}.", known.strict.worst, at_least(0.96))
    late = f"Longest delay of a fault, from where it is {sees}."
    yield _claim("strict-delay", late, longest(known.strict.delays), at_most(0.5), "s", STRICT)


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
            yield Claim(f"rules.{name}-{key}", f"{claim}: {title}.", source, printed, measured, goal, "", RULES)
        yield Claim(
            f"rules.{name}-wrong", f"Time with a fault-free sensor named: {title}.", source, None, known.wrong, None
        )
        yield Claim(f"rules.{name}-missed", f"Faults missed: {title}.", source, None, known.missed, None)


def longest(delays: np.ndarray) -> float:
    """The longest of some delays [s]; NaN of none."""
    return float(delays[-1]) if len(delays) else float("nan")
