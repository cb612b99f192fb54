"""Runs diagnoses over drives: calibrates once per vehicle, simulates once for all variants, and scores alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple

from tierod.core.recording import Recording
from tierod_lab.papers.condition.drives import Drive
from tierod_lab.papers.condition.recorded import each
from tierod_lab.papers.condition.scoring import DriveScore, score
from tierod_lab.papers.condition.truth import Declared, truth_of
from tierod_lab.studies.effort import Effort


class Variant(NamedTuple):
    """A diagnosis of the study."""

    title: str  # title for tables
    # module with `calibrate(vehicle, quick)`, which returns a picklable calibration of a vehicle, and `declare(known,
    # recording, name)`, which returns a `Declared`
    module: str


_RULES = "tierod_lab.papers.condition.by_rules"
VARIANTS: Mapping[str, Variant] = {
    "rules-printed": Variant("rules as printed", _RULES),
    "rules": Variant("rules, corrected", _RULES),
    "rules-discriminating": Variant("rules that discriminate", _RULES),
    "bank": Variant("bank of filters", "tierod_lab.papers.condition.by_bank"),
}
"""Diagnoses that the study compares, by the name of the monitor's variant."""

BEST = "bank"  # The default diagnosis, for which the goals are set

_known: dict[tuple[str, int, bool], Any] = {}
_scored: dict[tuple[Any, ...], list[DriveScore]] = {}


def calibrations(names: Iterable[str], vehicles: Iterable[int], effort: Effort) -> dict[tuple[str, int], Any]:
    """Calibrations of every variant to every vehicle, by (module of the variant, number of the vehicle).

    Args:
        effort: effort of the study, with the workers; a quick one calibrates on a few minutes

    Raises:
        InputError: a calibration failed
    """
    modules = dict.fromkeys(VARIANTS[name].module for name in names)
    numbers = tuple(dict.fromkeys(vehicles))
    wanted = [(module, number, effort.quick) for module in modules for number in numbers]
    missing = [each for each in wanted if each not in _known]
    made = effort.made(_calibrate, missing, lambda each: f"the calibration of vehicle {each[1]}")
    _known.update(zip(missing, made, strict=True))
    return {(module, number): _known[module, number, quick] for module, number, quick in wanted}


def _calibrate(wanted: tuple[str, int, bool]) -> Any:
    module, number, quick = wanted
    return import_module(module).calibrate(number, quick)


def diagnosed(name: str, drive: Drive, recording: Recording, known: Mapping[tuple[str, int], Any]) -> Declared:
    """Declarations of a variant over a drive."""
    module = VARIANTS[name].module
    declared: Declared = import_module(module).declare(known[module, drive.vehicle], recording, name)
    return declared


def scores(drives: Sequence[Drive], effort: Effort, names: Sequence[str] | None = None) -> dict[str, list[DriveScore]]:
    """The scores of many drives, by variant; computed once and cached in the process.

    Args:
        effort: effort of the study, with the workers; a quick one calibrates on a few minutes
        names: names of the variants; all if None
    """
    names = tuple(VARIANTS) if names is None else tuple(names)
    # With the module itself, as tests put another module under the same name.
    key = {name: (name, import_module(VARIANTS[name].module), effort.quick, *drives) for name in names}
    missing = tuple(name for name in names if key[name] not in _scored)
    if missing:
        known = calibrations(missing, (drive.vehicle for drive in drives), effort)
        found = each(partial(_scores_of, missing, known), drives, effort)
        _scored.update({key[name]: [row[place] for row in found] for place, name in enumerate(missing)})
    return {name: list(_scored[key[name]]) for name in names}


def _scores_of(
    names: tuple[str, ...], known: Mapping[tuple[str, int], Any], drive: Drive, recording: Recording
) -> list[DriveScore]:
    truth = truth_of(drive, recording)
    return [score(drive, truth, diagnosed(name, drive, recording, known)) for name in names]
