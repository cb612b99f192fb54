"""Fault-free driving: false alarms on rounds that no calibration uses, and of vehicles that have changed since."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.claims import Claim, exactly
from tierod.core.content import Heading, Item, Table
from tierod_lab.papers.condition import causes
from tierod_lab.papers.condition.drives import changed_drives, healthy_drives
from tierod_lab.papers.condition.reported import vehicles
from tierod_lab.papers.condition.runs import BEST, VARIANTS, scores
from tierod_lab.papers.condition.sensors import GOAL
from tierod_lab.papers.condition.summary import summary
from tierod_lab.studies.effort import Effort

TEXT = (
    "Rounds drawn at random, ten minutes each, with slopes, bumps, wind, halts and wet patches, the vehicles by "
    "turns; no calibration has driven them. Then the same with a mass, a cornering stiffness or a tyre radius that "
    "is 10 % more or less than when the vehicle was calibrated. A false alarm is a declaration that begins without "
    "a fault.",
)
HOURS, THOROUGH, CHANGED, CHANGED_THOROUGH = 3.0, 100.0, 1.0, 20.0
"""Hours of fault-free driving in a usual and in a thorough study; the same for changed vehicles [h]."""


def items(effort: Effort) -> Iterator[Item]:
    if not VARIANTS:
        return
    hours = 0.1 if effort.quick else THOROUGH if effort.thorough else HOURS
    later = 0.1 if effort.quick else CHANGED_THOROUGH if effort.thorough else CHANGED
    yield Heading("Fault-free driving", TEXT)
    names = (BEST,) if effort.thorough and BEST in VARIANTS else tuple(VARIANTS)
    found = {"as calibrated": scores(healthy_drives(hours, vehicles(effort)), effort, names)}
    found["10 % off"] = scores(changed_drives(later, vehicles=vehicles(effort)), effort, names)
    rows = []
    for drive, by_variant in found.items():
        for name, several in by_variant.items():
            known = summary(several)
            flagged = sum(each.flagged_share * each.healthy_hours for each in several) / known.healthy_hours
            cells = (
                f"{known.healthy_hours:.1f}",
                str(known.false_alarms),
                f"{known.bound:.3g}",
                f"{100 * flagged:.3g}",
            )
            rows.append((VARIANTS[name].title, drive, *cells))
    header = ("diagnosis", "vehicles", "hours", "false alarms", "at most per hour (95 %)", "time flagged [%]")
    yield Table("False alarms", header, tuple(rows))
    if BEST in VARIANTS:
        for key, (drive, by_variant) in zip(("alarms", "alarms-changed"), found.items(), strict=True):
            known = summary(by_variant[BEST])
            note = f"In {known.healthy_hours:.1f} h; at most {known.bound:.3g} per hour with 95 % confidence."
            claim = f"False alarms of healthy vehicles, {drive}."
            cause = causes.alarms(by_variant[BEST])
            yield Claim(f"healthy.{key}", claim, GOAL, None, known.false_alarms, exactly(0.0), "", note, cause=cause)
