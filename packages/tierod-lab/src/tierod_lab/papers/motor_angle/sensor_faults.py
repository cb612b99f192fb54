"""Faults of the motor angle sensor on the bench by kind, magnitude and speed: coverage, detection delay, first test."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tierod.core.claims import Claim, Goal, at_least, at_most
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Points, Table
from tierod_lab.papers.motor_angle.fault_kinds import FAULTS, STUCK, SWAPPED_PHASES, SWAPPED_SINE, drift, offset
from tierod_lab.papers.motor_angle.fault_trials import AFTER, Found, Trial, found_anywhere, found_in
from tierod_lab.papers.motor_angle.reported import ANYWHERE, BY_SPEED, SEEDS, TARGET, TURNING
from tierod_lab.studies.effort import Effort

SPEEDS = (15.0, 30.0, 60.0, 100.0)
"""Speeds of the strokes [rad/s]; below 10 rad/s nothing is compared."""

STALLS = (STUCK, SWAPPED_SINE, SWAPPED_PHASES)
"""Faults that stall the drive: found by secondary tests, if at all."""


TEXT = (
    "The bench's motor turns to and fro under control of its angle. At a random instant at which it turns fast enough "
    f"for its currents to show the angle, a fault begins and is watched for {AFTER:g} s. It lies inside the loop: the "
    "current control reads the wrong sensor, and what it reads is recorded; only steps of the angle are put into the "
    "recording alone. The drives turn at many speeds up to some 100 rad/s, those by speed to and fro at one of them.",
    "A delay runs from when the fault is as large as five degrees electrical to the first alarm of any test, and is "
    "given twice: from the clock, and of time in which the motor turned so fast that its angle was known. Between two "
    "strokes the motor stands, and nothing shows.",
)


@dataclass(frozen=True)
class Delays:
    """Delays of one fault in some trials.

    Args:
        found: outcome of every trial
    """

    found: tuple[Found, ...]

    @property
    def share(self) -> float:
        """Share of trials in which the fault was found."""
        return float(np.mean([np.isfinite(each.delay) for each in self.found])) if self.found else np.nan

    def quantile(self, share: float, turning: bool = False) -> float:
        """Quantile of the delay by the clock or of turning [ms]; infinite where too few trials detected the fault."""
        values = [each.turning if turning else each.delay for each in self.found]
        return float(np.quantile(values, share, method="higher")) if values else np.nan

    @property
    def first(self) -> str:
        """Tests that alarmed first, with their counts, in words."""
        counts = Counter(each.first for each in self.found if each.first).most_common(3)
        return ", ".join(f"{test.replace('_', ' ')} {count}" for test, count in counts)


Outcome = dict[str, Delays]
"""Delays by name of the fault."""


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Faults of the angle sensor", TEXT)
    many, few, whole = (3, 1, 3) if effort.quick else (40, 10, 40)
    mixed = tried(None, SEEDS.of(TURNING, many), effort)
    by_speed = {
        speed: tried(speed, SEEDS.of(BY_SPEED, few * len(SPEEDS))[few * place : few * (place + 1)], effort)
        for place, speed in enumerate(SPEEDS)
    }
    seeds, names = SEEDS.of(ANYWHERE, whole), [fault.name for fault in STALLS]
    anywhere = found_anywhere(names, seeds, effort)
    stalls = {name: Delays(tuple(found)) for name, found in anywhere.items()}
    yield _table(mixed)
    yield _speed_table(by_speed)
    yield _stall_table(stalls)
    yield _delay_chart(mixed)
    yield _size_chart(by_speed)
    yield from _claims(mixed, stalls)


def tried(speed: float | None, seeds: Sequence[int], effort: Effort) -> Outcome:
    """Delays of all faults in drives of some seeds.

    Args:
        speed: speed of the strokes [rad/s]; None for drives of many speeds
        seeds: seeds of the drives
        effort: runs the drives
    """
    trials = found_in([Trial(seed, speed) for seed in seeds], effort)
    return {fault.name: Delays(tuple(trial[fault.name] for trial in trials)) for fault in FAULTS}


def _share(delays: Delays) -> str:
    return f"{round(delays.share * len(delays.found))} of {len(delays.found)}" if delays.found else "0 of 0"


def _milliseconds(value: float) -> str:
    return f"{value:.0f}" if np.isfinite(value) else "∞"


def _table(mixed: Outcome) -> Table:
    header = ("fault", "found", "median [ms]", "95 % [ms]", "median, turning", "95 %, turning", "first alarm of")
    rows = tuple(
        (
            name,
            _share(each),
            *(_milliseconds(each.quantile(share)) for share in (0.5, 0.95)),
            *(_milliseconds(each.quantile(share, turning=True)) for share in (0.5, 0.95)),
            each.first,
        )
        for name, each in mixed.items()
    )
    note = (
        "A delay below zero: found before a drift had reached five degrees. ∞: not found so often. Two degrees are "
        "below what the sum forgives: half of the smallest offset worth an alarm."
    )
    return Table("Delay from a fault to the first alarm, drives of many speeds", header, rows, note)


def _speed_table(by_speed: dict[float, Outcome]) -> Table:
    header = ("fault, by speed in rad/s", *(f"{speed:g}" for speed in by_speed))
    names = [fault.name for fault in FAULTS]
    rows = tuple(
        (
            name,
            *(
                f"{100.0 * found[name].share:.0f} %, {_milliseconds(found[name].quantile(0.95, turning=True))}"
                for found in by_speed.values()
            ),
        )
        for name in names
    )
    return Table("Coverage, and 95 % of the delay [ms of turning], by speed", header, rows)


def _stall_table(stalls: Outcome) -> Table:
    rows = tuple(
        (
            name,
            _share(each),
            *(_milliseconds(each.quantile(share)) for share in (0.5, 1.0)),
            each.first,
        )
        for name, each in stalls.items()
    )
    header = ("fault", "found", "median [ms]", "worst [ms]", "first alarm of")
    note = "Standing, reversing, and in the first five seconds, while nothing is compared with the observer yet."
    return Table("Faults that let the drive stall, begun at any instant", header, rows, note)


def _delay_chart(mixed: Outcome) -> Chart:
    shown = [offset(5.0), offset(10.0), drift(20.0), STUCK]
    lines = []
    for fault in shown:
        values = np.sort([each.turning for each in mixed[fault.name].found])
        kept = values[np.isfinite(values)]
        shares = np.arange(1, len(kept) + 1) / max(len(values), 1)
        lines.append(Lines(fault.name, np.repeat(kept, 2), np.repeat(np.r_[0.0, shares], 2)[1:-1]))
    panel = Panel("", "delay (ms of turning)", "share found", tuple(lines), levels=(("95 %", 0.95),))
    return Chart(
        "motor-angle-delays",
        "Share of faults that are found, over the delay",
        "Delays count the time in which the motor turns; a drift counts from when it has reached five degrees.",
        "Curves of the share of faults found over the delay, for offsets, a drift and a stuck sensor.",
        (panel,),
    )


def _size_chart(by_speed: dict[float, Outcome]) -> Chart:
    sizes = (2.0, 3.5, 5.0, 10.0, 20.0, 60.0, 180.0)
    delay, share = [], []
    for speed, found in by_speed.items():
        each = [found[offset(size).name] for size in sizes]
        medians = np.array([one.quantile(0.5, turning=True) for one in each])
        delay.append(Points(f"{speed:g} rad/s", sizes, np.where(np.isfinite(medians), medians, np.nan)))
        share.append(Lines(f"{speed:g} rad/s", sizes, [one.share for one in each]))
    return Chart(
        "motor-angle-offset-sizes",
        "Offsets by size and speed",
        "Above: median of the delay where half of the offsets are found. Below: share found within the time watched.",
        "The larger an offset, the sooner it is found; below three degrees it is not found at all, as intended.",
        (
            Panel("", "offset (° electrical)", "delay (ms of turning)", tuple(delay), logarithmic_along=True),
            Panel("", "offset (° electrical)", "share found", tuple(share), logarithmic_along=True),
        ),
    )


def _claims(mixed: Outcome, stalls: Outcome) -> Iterator[Claim]:
    five, drifts = mixed[offset(5.0).name], mixed[drift(20.0).name]
    text = "An offset of five degrees electrical is found while turning"
    yield _claim("offset-median", f"{text}: median of the delay, of turning.", five.quantile(0.5, True), at_most(35.0))
    yield _claim("offset-p95", f"{text}: 95 % of the delay, of turning.", five.quantile(0.95, True), at_most(80.0))
    yield _claim(
        "offset-clock",
        f"{text}: 95 % of the delay, from the clock.",
        five.quantile(0.95),
        at_most(80.0),
        cause=_standing(five, 80.0),
    )
    text = "A drift of 20°/s is found within 50 ms of reaching five degrees"
    yield _claim("drift", f"{text}: 95 % of the delay, of turning.", drifts.quantile(0.95, True), at_most(50.0))
    yield _claim(
        "drift-clock",
        f"{text}: 95 % of the delay, from the clock.",
        drifts.quantile(0.95),
        at_most(50.0),
        cause=_standing(drifts, 50.0),
    )
    share = min(mixed[fault.name].share for fault in STALLS)
    yield _claim("stalling", "Stuck sensors and swapped phases are all found while turning.", share, at_least(1.0), "")
    share = min(each.share for each in stalls.values())
    yield _claim("stalling-anywhere", "The same, begun at any instant of a drive.", share, at_least(1.0), "")


def _standing(trials: Delays, goal: float) -> str:
    waited = sum(each.delay > goal >= each.turning for each in trials.found)
    return (
        f"Of the time in which the angle is known, 95 % take {trials.quantile(0.95, True):.0f} ms at most. {waited} of "
        f"{len(trials.found)} are late by the clock alone: the motor reverses or stands before the alarm, and without "
        "an induced voltage no current of a motor without saliency shows its angle."
    )


def _claim(key: str, text: str, measured: float, goal: Goal | None, unit: str = "ms", cause: str = "") -> Claim:
    return Claim(f"faults.{key}", text, TARGET, None, measured, goal, unit, cause=cause)
