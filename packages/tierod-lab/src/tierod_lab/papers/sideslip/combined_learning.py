"""Convergence of the combined estimator from wrong cornering stiffnesses, and identifiability of its unknowns."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim
from tierod.core.content import Band, Chart, Heading, Item, Lines, Panel, Table
from tierod.monitors.sideslip.estimator import WORDS, Identifiability, identifiability
from tierod_lab.papers.sideslip.combined_drives import (
    WITH,
    WITHOUT_TORQUE,
    both_stiff,
    estimated,
    estimator,
    on,
    right,
)
from tierod_lab.papers.sideslip.combined_table import GOAL
from tierod_lab.papers.sideslip.reported import COMBINED, SEEDS
from tierod_lab.studies.effort import Effort

TRUE = 1.0 / 1.2
"""Ratio of true to assumed stiffness in the figure [-]."""
NEAR = 0.05
"""Relative error below which a stiffness counts as converged [-]."""
EVERY = 20
"""Decimation of the drawn curves."""

DRIVES = ("random steering", "sine, 0.05 Hz", "mixed drive from standstill", "low friction, 0.35")


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "What is identifiable, and what is not",
        (
            "Front and rear stiffness, bank, wind, friction of tyres and steering are followed together. For every "
            "unknown the estimator gives the share of its prior variance that the drive has removed, and the least "
            "identified direction among the unknowns.",
        ),
    )
    yield _convergence()
    yield from _times()
    yield _identifiability(DRIVES[:1] if effort.quick else DRIVES)


def _convergence() -> Chart:
    drive = on("random steering", SEEDS.of(COMBINED, 1)[0])
    panels = []
    for axle in ("front", "rear"):
        marks: list[Lines | Band] = []
        for readings in (WITH, WITHOUT_TORQUE):
            result = estimated(drive, both_stiff, readings)
            value, deviation = result[f"{axle}_stiffness"], result[f"{axle}_stiffness_deviation"]
            shown = slice(None, None, EVERY)
            marks.append(Lines(readings, drive.time[shown], value[shown]))
            marks.append(Band(readings, drive.time[shown], (value - deviation)[shown], (value + deviation)[shown]))
        title = f"{axle.capitalize()} axle"
        panels.append(Panel(title, "time (s)", "true over assumed stiffness", tuple(marks), (("true", TRUE),)))
    return Chart(
        "stiffness-learnt",
        "Both stiffnesses assumed 20 % too high",
        "Random steering at 25 m/s from the third second on, with and without the torque of the steering; bands are "
        "one standard deviation.",
        "Both stiffnesses come near the true ones within a few seconds.",
        tuple(panels),
    )


def _times() -> Iterator[Claim]:
    for name, readings, words in (("torque", WITH, "with"), ("no-torque", WITHOUT_TORQUE, "without")):
        latest = max(_learnt(seed, readings) for seed in SEEDS.of(COMBINED, 3))
        yield Claim(
            f"combined.stiffness-learnt-{name}",
            f"Both stiffnesses, assumed 20 % too high, are within 5 % of the true ones {words} the steering's torque.",
            GOAL,
            None,
            latest,
            None,
            "s",
            "From the beginning of the steering, for good, latest of three drives.",
        )


def _learnt(seed: int, readings: str) -> float:
    """Time from the start of steering until both stiffnesses stay converged [s]."""
    drive = on("random steering", seed)
    result = estimated(drive, both_stiff, readings)
    error = np.maximum(*(np.abs(result[f"{axle}_stiffness"] / TRUE - 1.0) for axle in ("front", "rear")))
    wrong = np.nonzero(error > NEAR)[0]
    # The random course steers from 2 s on.
    return float(drive.time[wrong[-1]]) - 2.0 if len(wrong) else 0.0


def _identifiability(drives: tuple[str, ...]) -> Table:
    found: dict[str, Identifiability] = {}
    for name in drives:
        for readings in (WITH, WITHOUT_TORQUE):
            state = estimated(on(name, SEEDS.of(COMBINED, 1)[0]), readings=readings).state
            found[f"{name}, {readings}"] = identifiability(estimator(right, readings), state)
    unknowns = next(iter(found.values())).shares
    rows = [
        (
            name,
            *(f"{each.shares[unknown]:.2f}" if unknown in each.shares else "-" for unknown in unknowns),
            _direction(each),
        )
        for name, each in found.items()
    ]
    return Table(
        "Share of the prior variance that a drive removed, and the least identified direction",
        ("drive", *(WORDS[unknown] for unknown in unknowns), "known least"),
        tuple(rows),
        "From 0.75 on an unknown counts as identified. Last column: combination with the most variance left, and how "
        "much of the prior's.",
    )


def _direction(found: Identifiability) -> str:
    return f"{found.least} ({found.left:.0%})"
