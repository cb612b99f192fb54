"""The monitor on salient motors with load steps: errors, effect of wrong parameters, detection delay, false alarms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, Goal, at_most, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan
from tierod_lab.papers.motor_angle.fault_drives import RATE
from tierod_lab.papers.motor_angle.fault_kinds import offset
from tierod_lab.papers.motor_angle.fault_trials import Found
from tierod_lab.papers.motor_angle.healthy_drives import AlarmWatch
from tierod_lab.papers.motor_angle.observer_drives import FLUX, RESISTANCE
from tierod_lab.papers.motor_angle.reported import SALIENT, SALIENT_FAULTS, SALIENT_HOURS, SEEDS, TARGET
from tierod_lab.papers.motor_angle.salient_drives import (
    FAST,
    LOAD,
    LOW_SUPPLY,
    RIGHT,
    Assumed,
    fast_drive,
    found_on_salient,
    salient_drive,
    salient_monitor,
)
from tierod_lab.studies.effort import Effort

RATIOS = (1.0, 1.1, 1.5, 2.0, 3.0)
"""Saliency ratios: q-axis over d-axis inductance."""
SECONDS, SETTLED = 20.0, 2.0
"""Duration of a drive whose error is measured, and warm-up in it [s]."""
LONG = 60.0
"""Duration of a fault-free drive [s]."""
TEXT = (
    f"Drives of {SECONDS:g} s on a bench whose motor has more inductance across the flux than along it, with the least "
    f"current for a torque, under a load that steps by up to {LOAD:g} N*m within one sample, twice a second. Fast "
    f"drives turn at up to {FAST:g} rad/s on {LOW_SUPPLY:g} V, where the drive weakens the flux.",
    "Then what the vehicle file says is wrong: one inductance, or winding and magnets. The error is that of the angle "
    "of the shaft.",
)
WRONG = {
    "as true": RIGHT,
    "along the flux 5 % high": Assumed(direct=1.05),
    "across the flux 5 % high": Assumed(quadrature=1.05),
    "across the flux 5 % low": Assumed(quadrature=0.95),
    "across the flux 10 % high": Assumed(quadrature=1.1),
    "resistance 20 % low": Assumed(resistance=0.8),
    "flux 4 % high": Assumed(flux=1.04),
}
"""Errors of the vehicle file by name."""


class Course(NamedTuple):
    """One drive to be measured: saliency ratio, seed, errors of the vehicle file, and whether it is fast."""

    ratio: float
    seed: int
    assumed: Assumed
    fast: bool


class Drawn(NamedTuple):
    """Result of a fault-free drive: time with a valid angle [s], and whether any test alarmed."""

    known: float
    alarmed: bool


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Salient motors, and loads that step", TEXT)
    count = 1 if effort.quick else 6
    right = _errors(effort, RATIOS, {"as true": RIGHT}, count)
    fast = _errors(effort, RATIOS, {"as true": RIGHT}, count, fast=True)
    rows = tuple(
        (f"{ratio:g}", *(f"{pick(each[ratio, 'as true']):.4f}" for each in (right, fast) for pick in (np.median, max)))
        for ratio in RATIOS
    )
    header = ("across over along", "rms, median [rad]", "worst [rad]", "fast: median [rad]", "fast: worst [rad]")
    yield Table("Error of the angle on salient motors", header, rows, f"{count} drives each way and ratio.")
    wrong = _errors(effort, RATIOS[1:], WRONG, 1 if effort.quick else 3)
    yield _wrong_table(wrong)
    text = "Salient motors with a load that steps: error of the angle, worst root mean square"
    yield _claim("error", f"{text}.", max(map(max, right.values())), at_most(0.004), "rad")
    yield _claim("weakened", f"{text}, with weakened flux.", max(map(max, fast.values())), at_most(0.004), "rad")
    off = max(max(wrong[ratio, "across the flux 5 % high"]) for ratio in RATIOS[1:])
    yield _claim("five-percent", f"{text}, inductance across the flux 5 % high.", off, at_most(0.008), "rad")
    yield from _offsets(effort)
    yield from _hours(effort)


def error(course: Course) -> float:
    """Rms error of the angle over one drive [rad]."""
    make = fast_drive if course.fast else salient_drive
    seen = make(course.ratio, course.seed, SECONDS)
    found = scan(salient_monitor(course.ratio, course.assumed), seen.samples)
    away = (found["estimate.motor_angle"] - seen.angle)[round(SETTLED * RATE) :]
    return float(np.sqrt(np.mean(away**2)))


def watched(seed: int) -> Drawn:
    """Result of a fault-free drive of a motor whose parameters differ at random from its vehicle file."""
    random = np.random.default_rng([seed, 19])
    ratio = float(random.uniform(1.0, 3.0))
    spans = ((0.95, 1.05), (0.95, 1.05), RESISTANCE, FLUX)
    assumed = Assumed(*(1.0 / float(random.uniform(*span)) for span in spans))
    seen = (fast_drive if random.random() < 0.2 else salient_drive)(ratio, seed, LONG)
    found = scan(AlarmWatch(salient_monitor(ratio, assumed)), seen.samples)
    return Drawn(float(found["known"].sum()) / RATE, bool(found["alarmed"][-1]))


def _offset_found(given: tuple[float, int, float]) -> Found | None:
    ratio, seed, degrees = given
    return found_on_salient(ratio, seed, offset(degrees))


def _errors(
    effort: Effort, ratios: tuple[float, ...], files: dict[str, Assumed], count: int, fast: bool = False
) -> dict[tuple[float, str], list[float]]:
    """Rms errors by ratio and vehicle file, one per drive [rad]."""
    keys = [(ratio, name) for ratio in ratios for name in files for _ in range(count)]
    seeds = [SEEDS.of(SALIENT, count)[number % count] for number in range(len(keys))]
    given = [Course(ratio, seed, files[name], fast) for (ratio, name), seed in zip(keys, seeds, strict=True)]
    found: dict[tuple[float, str], list[float]] = {}
    for key, value in zip(keys, effort.made(error, given), strict=True):
        found.setdefault(key, []).append(value)
    return found


def _wrong_table(wrong: dict[tuple[float, str], list[float]]) -> Table:
    rows = tuple((name, *(f"{max(wrong[ratio, name]):.4f}" for ratio in RATIOS[1:])) for name in WRONG)
    header = ("vehicle file", *(f"{ratio:g}" for ratio in RATIOS[1:]))
    note = (
        "Only the inductance across the flux moves the angle: by its error times the current across, over the active "
        "flux. Resistance and flux are learnt."
    )
    return Table(
        "Error of the angle where the file is wrong, worst root mean square [rad], by ratio", header, rows, note
    )


def _offsets(effort: Effort) -> Iterator[Item]:
    count = 2 if effort.quick else 15
    given = [
        (ratio, seed, degrees)
        for ratio in RATIOS
        for seed in SEEDS.of(SALIENT_FAULTS, count)
        for degrees in (-5.0, 5.0)
    ]
    found = [each for each in effort.made(_offset_found, given) if each is not None]
    text = "Salient motors: an offset of five degrees electrical is found while turning"
    note = f"{len(found)} offsets"
    turning = float(np.quantile([each.turning for each in found], 0.95, method="higher"))
    yield _claim("offset", f"{text}: 95 % of the delay, of turning.", turning, at_most(50.0), "ms", note)
    clock = float(np.quantile([each.delay for each in found], 0.95, method="higher"))
    waited = sum(each.delay > 50.0 >= each.turning for each in found)
    cause = (
        f"Of the time in which the angle is known, 95 % take {turning:.0f} ms at most. {waited} of {len(found)} are "
        "late by the clock alone: the motor reverses or stands before the alarm, and the active flux shows no angle "
        "there. On a salient motor a high-frequency voltage would."
    )
    yield _claim("offset-clock", f"{text}: 95 % of the delay, from the clock.", clock, at_most(50.0), "ms", note, cause)


def _hours(effort: Effort) -> Iterator[Item]:
    count = 3 if effort.quick else 600 if effort.thorough else 60
    drives = effort.made(watched, SEEDS.of(SALIENT_HOURS, count))
    hours, turning = count * LONG / 3600.0, sum(each.known for each in drives) / 3600.0
    alarms = float(sum(each.alarmed for each in drives))
    note = (
        f"{hours:.2g} h, {turning:.2g} h of them turning; ratios of 1 to 3, inductances within 5 %, winding and "
        "magnets warm or cold; one drive in five fast"
    )
    yield _claim(
        "none-false", "No alarm of any test on salient motors, load steps included.", alarms, exactly(0.0), "", note
    )


def _claim(
    key: str, text: str, measured: float | None, goal: Goal | None, unit: str, note: str = "", cause: str = ""
) -> Claim:
    return Claim(f"salient.{key}", text, TARGET, None, measured, goal, unit, note, cause=cause)
