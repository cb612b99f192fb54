"""Drives through diagnoses: calibrated once for every vehicle, driven once for all variants, scored alike."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple

from tierod.recording import Recording
from tierod.studies.condition.declared import Declared
from tierod.studies.condition.drives import Drive
from tierod.studies.condition.recorded import each
from tierod.studies.condition.scoring import DriveScore, score, truth_of
from tierod.studies.registry import Effort


class Variant(NamedTuple):
    """A way to diagnose a recording.

    Args:
        title: for tables
        module: with `calibrate(vehicle, quick)`, which gives something picklable that is known of a vehicle, and
            `declare(known, recording, name)`, which gives a `Declared`
    """

    title: str
    module: str


_RULES = "tierod.studies.condition.by_rules"
VARIANTS: Mapping[str, Variant] = {
    "rules-printed": Variant("rules as printed", _RULES),
    "rules": Variant("rules, corrected", _RULES),
    "rules-discriminating": Variant("rules that discriminate", _RULES),
}
"""Every diagnosis that the study holds against the others, by the name of the monitor's variant."""

BEST = "bank"
"""The default diagnosis, which the goals are about."""

_known: dict[tuple[str, int, bool], Any] = {}


def calibrations(names: Iterable[str], vehicles: Iterable[int], quick: bool) -> dict[tuple[str, int], Any]:
    """What every variant has learnt of every vehicle, by (module of the variant, number of the vehicle).

    Args:
        names: of the variants
        vehicles: numbers of the demonstrators
        quick: whether a few minutes of driving have to do
    """
    found = {}
    for module in dict.fromkeys(VARIANTS[name].module for name in names):
        for number in dict.fromkeys(vehicles):
            key = (module, number, quick)
            if key not in _known:
                _known[key] = import_module(module).calibrate(number, quick)
            found[module, number] = _known[key]
    return found


def diagnosed(name: str, drive: Drive, recording: Recording, known: Mapping[tuple[str, int], Any]) -> Declared:
    """What a variant says of a drive."""
    module = VARIANTS[name].module
    return import_module(module).declare(known[module, drive.vehicle], recording, name)


def scores(
    drives: Sequence[Drive], effort: Effort, names: Sequence[str] | None = None, folder: str | None = None
) -> dict[str, list[DriveScore]]:
    """The scores of many drives, by variant.

    Args:
        drives: what to drive
        effort: how many processes, and whether calibration has to be short
        names: of the variants; all if None
        folder: where recordings are kept, if anywhere
    """
    names = tuple(VARIANTS) if names is None else tuple(names)
    known = calibrations(names, (drive.vehicle for drive in drives), effort.quick)
    work = partial(_scored, names, known)
    processes = effort.processes or os.cpu_count() or 1
    found = each(work, drives, folder, min(processes, len(drives)))
    return {name: [row[place] for row in found] for place, name in enumerate(names)}


def _scored(
    names: tuple[str, ...], known: Mapping[tuple[str, int], Any], drive: Drive, recording: Recording
) -> list[DriveScore]:
    truth = truth_of(drive, recording)
    return [score(drive, truth, diagnosed(name, drive, recording, known)) for name in names]
