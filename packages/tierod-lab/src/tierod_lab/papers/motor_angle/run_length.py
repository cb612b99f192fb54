"""Time between false alarms: designed for white residuals, and measured on residuals of fault-free drives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tierod.core.claims import Claim, at_least, at_most, between, exactly
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Points, Table
from tierod.core.graph import scan
from tierod.methods.detectors.measured import threshold_from_records
from tierod.methods.detectors.stopping_rules import AverageRule, CusumRule, HoldRule, SequentialRule, StoppingRule
from tierod.monitors.motor_angle.comparison import ANGLE_DRIFT, ANGLE_THRESHOLD
from tierod_lab.papers.motor_angle.healthy_drives import MOTORS, HealthyDrives, healthy_drives
from tierod_lab.papers.motor_angle.reported import FAULT_FREE, SEEDS
from tierod_lab.studies.effort import Effort

RESIDUAL_RATE = 1000.0
"""Rate of the residuals that count [Hz]."""
SCALE = 3.0
"""Factor on the residuals of the bench, which never raise an alarm without it."""
WANTED = (20.0, 60.0, 200.0, 600.0)
"""Required times between false alarms, of turning [s]."""
ENOUGH = 100
"""Least number of alarms at the longest time for a judgement: with half as many a design is exact to a tenth only."""
TEXT = (
    "Fault-free drives of the bench, every one with a motor whose resistance, flux and inductance differ from the "
    "vehicle file's: 0.8 to 1.3, 0.94 to 1.02, and 7 % either way. The residual counts once a millisecond while the "
    "motor turns; times are of turning.",
    "It is far from white, so that no formula gives its run length. The threshold is designed from one third of the "
    f"drives, by the line that the logarithm of the run length follows, and tried on the others. Since these residuals "
    f"never raise an alarm by themselves, they are made {SCALE:g} times larger for it.",
)


@dataclass(frozen=True)
class TriedLength:
    """A threshold designed from some drives and tried on others.

    Args:
        wanted: required time between false alarms [s]
        threshold: threshold of the CUSUM, electrical [rad]
        alarms: number of false alarms on the other drives
        seconds: time of turning in the other drives [s]
    """

    wanted: float
    threshold: float
    alarms: int
    seconds: float

    @property
    def measured(self) -> float:
        """Measured time between false alarms [s]; NaN without an alarm."""
        return self.seconds / self.alarms if self.alarms else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of the time between false alarms, for alarms as a Poisson process [s]."""
        from scipy.stats import chi2

        high = 2.0 * self.seconds / chi2.ppf(0.025, 2 * self.alarms) if self.alarms else math.inf
        return float(2.0 * self.seconds / chi2.ppf(0.975, 2 * self.alarms + 2)), float(high)


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Time between false alarms", TEXT)
    yield from _white(effort.quick)
    courses = 2 if effort.quick else 800 if effort.thorough else 75
    drives = healthy_drives(courses, SEEDS.of(FAULT_FREE, courses)[0], effort)
    found = tried_lengths(drives)
    yield from _fault_free(drives, effort.thorough)
    yield _tried_table(found, drives)
    yield _chart(found)
    yield from _claims(found)


def simulated(rule: StoppingRule, threshold: float, samples: int, seed: int) -> tuple[float, int]:
    """Run length in samples on white residuals, and number of alarms behind it."""
    values = np.random.default_rng(seed).normal(size=samples)
    alarms = rule.alarms(scan(rule.block(threshold, 1.0, restart=True), values)["alarm"])
    return (samples / alarms if alarms else math.nan), alarms


def tried_lengths(drives: HealthyDrives, scale: float = SCALE) -> list[TriedLength]:
    """Design thresholds of the CUSUM of the angle from a third of the courses, and try them on the others.

    Args:
        drives: fault-free drives
        scale: factor on the residuals [-]
    """
    # Whole courses are divided, since the motors of one course share its simulated drive.
    part = max(len(drives.drives) // MOTORS // 3, 1) * MOTORS
    design, trial = drives.records(0, part, scale), drives.records(part, len(drives.drives), scale)
    deviation = math.sqrt(float(np.mean(np.concatenate(design) ** 2)))
    rule = CusumRule(ANGLE_DRIFT / deviation)
    seconds = sum(map(len, trial)) / RESIDUAL_RATE
    found = []
    for wanted in WANTED:
        threshold = threshold_from_records(rule, design, wanted * RESIDUAL_RATE).threshold
        block = rule.block(threshold, deviation, restart=True)
        alarms = sum(rule.alarms(scan(block, record)["alarm"]) for record in trial)
        found.append(TriedLength(wanted, threshold * deviation, alarms, seconds))
    return found


def _white(quick: bool) -> Iterator[Item]:
    samples = 200_000 if quick else 4_000_000
    rules = (CusumRule(0.25), CusumRule(0.5), CusumRule(1.0), AverageRule(0.1), HoldRule(3), SequentialRule(1.0))
    rows, worst = [], 0.0
    for wanted in (200.0, 1000.0):
        for seed, rule in enumerate(rules):
            threshold = rule.threshold_for(wanted)
            length, alarms = simulated(rule, threshold, samples, seed)
            worst = max(worst, abs(length / wanted - 1.0))
            rows.append((rule.name, f"{wanted:g}", f"{threshold:.3f}", f"{length:.1f}", f"{alarms}"))
    header = ("rule", "wanted [samples]", "threshold [deviations or evidence]", "simulated [samples]", "alarms")
    yield Table("White residuals: run length as designed and as simulated", header, tuple(rows))
    yield Claim(
        "run-length.white",
        "White residuals: the run length is as designed, for every rule.",
        "target of tierod",
        None,
        # A quick study has some hundred alarms, which give the run length to 7 % only.
        None if quick else 100.0 * worst,
        at_most(5.0),
        "percent",
        f"the greatest difference of {len(rows)}, each over {samples / 1e6:g} million samples"
        + (": too few to judge" if quick else ""),
    )


def _fault_free(drives: HealthyDrives, thorough: bool) -> Iterator[Item]:
    bound = 3.0 / drives.turning
    residuals = np.concatenate([drive.residuals for drive in drives.drives])
    rows = (
        ("hours of driving", f"{drives.hours:.1f}"),
        ("hours of turning", f"{drives.turning:.1f}"),
        ("motors", f"{len(drives.drives)}"),
        ("drives with an alarm of any test", f"{drives.alarms}"),
        ("residual, root mean square [rad]", f"{np.sqrt(np.mean(residuals.astype(float) ** 2)):.4f}"),
        ("residual, greatest [rad]", f"{drives.greatest:.3f}"),
        *((f"its autocorrelation over {lag} ms", f"{_correlation(drives, lag):.2f}") for lag in (1, 5, 20, 100)),
    )
    yield Table("Fault-free drives", ("", "value"), rows, "Of the residual of the electrical angle where it counts.")
    yield Claim(
        "faults.none-false",
        "No alarm of any test in fault-free drives.",
        "target of tierod",
        None,
        float(drives.alarms),
        exactly(0.0),
        "",
        f"{drives.turning:.2g} h of turning: fewer than {bound:.2g} per hour at 95 %, no more is shown; the sum "
        f"forgives {ANGLE_DRIFT:g} rad a value and alarms at {ANGLE_THRESHOLD:g} rad",
    )
    yield Claim(
        "faults.hours",
        "Hours of turning in which fault-free drives were watched for false alarms.",
        "target of tierod",
        None,
        drives.turning if thorough else None,
        at_least(10.0),
        "h",
        "" if thorough else f"{drives.turning:.2g} h; all of them with '--thorough'",
    )


def _correlation(drives: HealthyDrives, lag: int) -> float:
    pairs = [(each.residuals[:-lag], each.residuals[lag:]) for each in drives.drives if len(each.residuals) > lag]
    energy = sum(float(np.sum(each.residuals.astype(float) ** 2)) for each in drives.drives)
    return sum(float(early.astype(float) @ late.astype(float)) for early, late in pairs) / energy


def _tried_table(found: list[TriedLength], drives: HealthyDrives) -> Table:
    rows = tuple(
        (
            f"{each.wanted:g}",
            f"{each.threshold:.3f}",
            f"{each.alarms}",
            f"{each.measured:.1f}" if each.alarms else "–",
            f"{each.interval[0]:.0f} to {each.interval[1]:.0f}" if each.alarms else f"above {each.interval[0]:.0f}",
        )
        for each in found
    )
    return Table(
        f"Fault-free residuals times {SCALE:g}: designed from a third of the drives, tried on the others",
        ("wanted [s]", "threshold [rad]", "alarms", "found [s]", "95 % interval [s]"),
        rows,
        f"{found[0].seconds / 3600.0:.1f} of {drives.turning:.1f} h of turning were tried on.",
    )


def _chart(found: list[TriedLength]) -> Chart:
    wanted = [each.wanted for each in found]
    low, high = zip(*(each.interval for each in found), strict=True)
    marks = (
        Lines("as designed", wanted, wanted, dashed=True),
        Points("as found", wanted, [each.measured for each in found], low, high),
    )
    panel = Panel("", "wanted (s)", "found (s)", marks, logarithmic=True, logarithmic_along=True)
    return Chart(
        "motor-angle-run-length",
        "Time between false alarms of coloured residuals",
        "With 95 % intervals of what alarms that come by chance allow.",
        "Times between false alarms as found on other drives, beside those that the thresholds were designed for.",
        (panel,),
    )


def _claims(found: list[TriedLength]) -> Iterator[Claim]:
    for each in found if found[-1].alarms >= ENOUGH else []:
        if each.wanted not in (60.0, 600.0):
            continue
        yield Claim(
            f"run-length.coloured-{each.wanted:.0f}",
            f"Coloured residuals: designed for {each.wanted:g} s between false alarms, found over that.",
            "target of tierod",
            None,
            each.measured / each.wanted,
            between(0.8, 1.2),
            "",
            f"{each.alarms} alarms",
        )
