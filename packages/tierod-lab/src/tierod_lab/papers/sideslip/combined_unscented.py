"""The combined estimator with an unscented filter in place of the extended one: the cost of linearisation."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from tierod.core.claims import Claim
from tierod.core.content import Item, Table
from tierod.core.graph import scan
from tierod.monitors.sideslip.estimator import CombinedSideslip
from tierod.monitors.sideslip.tuning import CombinedTuning
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.sideslip.combined_drives import WITHOUT_TORQUE, both_stiff, errors, estimator, on, rms
from tierod_lab.papers.sideslip.combined_table import GOAL
from tierod_lab.papers.sideslip.reported import COMBINED, SEEDS
from tierod_lab.studies.effort import Effort

FEWER = CombinedTuning(side_force=None, side_moment=None)
"""Tuning without wind states, since the unscented filter takes at most twelve states."""

DRIVES = ("random steering", "sine, 0.3 Hz", "sine, 0.05 Hz", "mixed drive from standstill", "low friction, 0.35")


def unscented(block: CombinedSideslip) -> CombinedSideslip:
    """The same estimator and noises with an unscented filter, which has no innovation gate."""
    own = block.filter
    points: Any = UnscentedFilter(
        own.model, own.parameters, own.initial_mean, own.initial_variance, own.process_noise, own.measurement_noise
    )
    return dataclasses.replace(block, filter=points)


def items(effort: Effort) -> Iterator[Item]:
    if effort.quick:
        return
    extended = estimator(both_stiff, WITHOUT_TORQUE, FEWER)
    blocks = {"extended": extended, "unscented": unscented(extended)}
    rows, gain = [], 0.0
    for name in DRIVES:
        drives = [on(name, seed) for seed in SEEDS.of(COMBINED, 2)]
        found = {
            kind: rms(np.concatenate([errors(drive, scan(block, drive.samples))[0] for drive in drives]))
            for kind, block in blocks.items()
        }
        gain = max(gain, found["extended"] - found["unscented"])
        rows.append((name, *(f"{each:.3f}" for each in found.values())))
    yield Table(
        "Extended and unscented filter, stiffnesses assumed 20 % too high: root mean square error (degrees)",
        ("drive", *blocks),
        tuple(rows),
        "Without the steering's torque and without wind among the states; two drives each.",
    )
    yield Claim(
        "combined.unscented-gain",
        "What an unscented filter gains over the extended one, at most.",
        GOAL,
        None,
        gain,
        None,
        "deg",
    )
