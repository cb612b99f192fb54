"""Faults beyond the paper's tests: more kinds and magnitudes, two at once, and the smallest detectable magnitude."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tierod.core.claims import Claim, Goal, at_least, at_most, exactly
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.core.signals import SIGNALS
from tierod_lab.papers.condition import causes, tables
from tierod_lab.papers.condition.drives import (
    OFFSET,
    OFFSETS,
    SENSORS,
    TEST_SECONDS,
    Drive,
    Injected,
    mixed_pairs,
    more_kinds,
    sensor_pairs,
)
from tierod_lab.papers.condition.reported import vehicles
from tierod_lab.papers.condition.runs import BEST, VARIANTS, scores
from tierod_lab.papers.condition.scoring import DriveScore
from tierod_lab.papers.condition.sensors import GOAL
from tierod_lab.papers.condition.summary import Isolated, isolated, summary
from tierod_lab.papers.condition.vehicles import LONG, SHORT, THIRD
from tierod_lab.studies.effort import Effort

KINDS_TEXT = (
    "Every kind of fault of every sensor in several sizes, on three rounds, with other seeds than those of the "
    "tests. The size is a multiple of the tests' offset; gains, drifts, noise and delays are scaled to do as much "
    "harm.",
    "Kind and size are what is said 2 s after the declaration, over all faults that are declared, those that a later "
    "sample no longer shows included. Of noise, 2 s hold 200 samples, whose own standard deviation differs from that "
    "of the noise by up to 10 % in 95 of 100 cases: no estimate is closer.",
)
PAIRS_TEXT = (
    "Two sensors at once, both lost or both with an offset, and a sensor with an actuator; the second one fails 2 s "
    "after the first. Right is who names both and nothing else most of the time in which both show.",
)
SIZES = (0.5, 1.0, 2.0)  # Fault magnitudes of the campaign of kinds, in multiples of the tests' offsets
SMALL = (0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4, 0.55, 0.75, 1.0)
"""Fault magnitudes of the curve of detectable sizes, in multiples of the tests' offsets."""

TIMES = np.geomspace(0.04, 20.0, 55)  # Times of that curve [s]


def items(effort: Effort) -> Iterator[Item]:
    if BEST not in VARIANTS:
        return
    yield from _kinds(effort)
    yield from _pairs(effort)
    yield from _small(effort)


def _kinds(effort: Effort) -> Iterator[Item]:
    routes = ((SHORT, 31), (LONG, 32), (THIRD, 33))
    plans = [(number, *route) for number, route in zip(vehicles(effort), routes, strict=False)]
    drives = [each for plan in plans for each in more_kinds(*plan, sizes=(1.0,) if effort.quick else SIZES)]
    found = scores(drives[::12] if effort.quick else drives, effort, (BEST,))[BEST]
    yield Heading("Kinds and sizes", KINDS_TEXT)
    kinds = dict.fromkeys(each.drive.injected[0].kind for each in found)
    rows = []
    for kind in kinds:
        known = summary([each for each in found if each.drive.injected[0].kind == kind])
        longest = f"{known.delays_shown[-1]:.2f}" if len(known.delays_shown) else "–"
        rows.append(
            (
                kind,
                str(known.drives),
                f"{known.accuracy:.4f}",
                f"{known.wrong:.4f}",
                f"{known.missed}",
                f"{known.not_testable}",
                longest,
                f"{known.kinds:.3f}",
                f"{known.size_error:.3f}",
                f"{known.covered:.3f}",
            )
        )
    header = ("kind", "drives", "accuracy", "wrong name", "missed", "never observable", "longest delay [s]")
    yield Table(
        "Faults by kind",
        (*header, "kind right", "size within", "interval holds"),
        tuple(rows),
        "95 % of the sizes are within the last column but one; the last one is the share of the sizes that are within "
        "1.96 of their estimated standard deviations.",
    )
    yield tables.named("What went by which name", found)
    known = summary(found)
    right = "Kinds named rightly 2 s after the declaration."
    yield _claim("kinds", right, known.kinds, at_least(0.98), causes.kinds(found))
    sizes = "Relative error of sizes, 95 % quantile."
    yield _claim("sizes", sizes, known.size_error, at_most(0.1), causes.sizes(found))
    wrong = "Time of the faults with a fault-free element named."
    yield _claim("kinds-wrong", wrong, known.wrong, exactly(0.0), causes.misnamed(found))


def pairs(effort: Effort) -> tuple[list[Drive], list[Drive]]:
    """Drives with two faulty sensors, and drives with a faulty sensor and a faulty actuator."""
    plans = ((1, SHORT, 41),) if effort.quick else ((1, SHORT, 41), (2, LONG, 42))
    two = [each for plan in plans for each in sensor_pairs(*plan)]
    mixed = [each for plan in plans for share in (1.0, 0.5) for each in mixed_pairs(*plan, share)]
    return (two[::10], mixed[::16]) if effort.quick else (two, mixed)


def _pairs(effort: Effort) -> Iterator[Item]:
    two, mixed = pairs(effort)
    found, others = scores(two, effort, (BEST,))[BEST], scores(mixed, effort, (BEST,))[BEST]
    yield Heading("Two at once", PAIRS_TEXT)
    rows = tuple(
        (name, str(len(of)), *(f"{share:.3f}" for share in isolated(of)))
        for name, of in (("two sensors", found), ("a sensor and an actuator", others))
    )
    yield Table("Share of the drives by what was named", ("pair", "drives", *Isolated._fields), rows)
    yield tables.named("Two sensors", found)
    yield tables.named("A sensor and an actuator", others)
    for key, name, of in (("pairs", "pairs of sensors", found), ("mixed", "pairs of sensor and actuator", others)):
        isolation, cause = isolated(of), causes.misnamed(of)
        both, other = f"Share of {name} named, both and no other.", f"Share of {name} with a fault-free element named."
        yield _claim(f"{key}-isolated", both, isolation.right, at_least(0.9), cause)
        yield _claim(f"{key}-wrong", other, isolation.wrong, exactly(0.0), cause)


def _small(effort: Effort) -> Iterator[Item]:
    sizes = SMALL[::5] if effort.quick else SMALL
    seeds = (51,) if effort.quick else (51, 52, 53)
    drives = [
        Drive(course, TEST_SECONDS, 1 + place, seed, (Injected(sensor, OFFSET, size * OFFSETS[sensor]),))
        for sensor in SENSORS
        for size in sizes
        for place, (course, seed) in enumerate(zip((SHORT, LONG, THIRD), seeds, strict=False))
    ]
    found = scores(drives, effort, (BEST,))[BEST]
    yield _curve(found)
    rows = []
    for sensor in SENSORS:
        own = [each for each in found if each.drive.injected[0].element == sensor]
        unit = SIGNALS[sensor].unit.replace("*", "·")
        rows.append((f"{sensor} [{unit}]", *(f"{_least(own, within):.3g}" for within in (0.2, 0.5, 2.0, 20.0))))
    yield Table(
        "Smallest offset that is found every time within so long",
        ("sensor", "0.2 s", "0.5 s", "2 s", "20 s"),
        tuple(rows),
        "Of the sizes tried, the smallest from which on every larger one was found on all rounds; inf: none.",
    )


def _least(of: Sequence[DriveScore], within: float) -> float:
    """Smallest size from which on every larger one is found within a time [s] in all drives; infinite without one."""
    sizes = sorted({each.drive.injected[0].size for each in of}, reverse=True)
    least = np.inf
    for size in sizes:
        if not all(f.delay <= within for each in of for f in each.faults if f.injected.size == size):
            break
        least = size
    return float(least)


def _curve(of: Sequence[DriveScore]) -> Chart:
    marks = []
    for sensor in SENSORS:
        own = [each for each in of if each.drive.injected[0].element == sensor]
        sizes = np.array([_least(own, within) for within in TIMES]) / OFFSETS[sensor]
        marks.append(Lines(sensor.replace("_", " "), TIMES, np.where(np.isfinite(sizes), sizes, np.nan)))
    panel = Panel(
        "detectable size by time",
        "time since the offset [s]",
        "size / offset of the tests",
        tuple(marks),
        logarithmic=True,
        logarithmic_along=True,
    )
    return Chart(
        "condition-detectable-size",
        "How small an offset is found in what time",
        "Of the sizes tried, the smallest from which on every larger one was found on all rounds within that time; "
        "no point where none was.",
        "Detectable size falling with time for six sensors.",
        (panel,),
    )


def _claim(key: str, claim: str, measured: float, goal: Goal | None, cause: str) -> Claim:
    return Claim(f"beyond.{key}", claim, GOAL, None, measured, goal, cause=cause)
