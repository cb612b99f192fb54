"""The catalogue of canonical signals: name in words, SI unit, meaning, direction (ISO 8855: left positive).

Every reader, monitor, plant and report uses these names. signals.csv holds the rows, from which
`docs/reference/signals.md` is generated.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from math import inf
from pathlib import Path

import numpy as np

from tierod.core.errors import InputError, nearest
from tierod.core.units import COUNT, scale


@dataclass(frozen=True)
class Signal:
    name: str  # in words, as used in every public signature
    unit: str  # SI, in the notation of pint ("rad/s", "N*m", "m/s**2"); "" for a number without unit
    meaning: str
    positive: str = ""
    plausible: tuple[float, float] = (-inf, inf)  # the range that a fault-free road vehicle can reach, in the unit
    aliases: tuple[str, ...] = ()  # names found in recordings, matched without regard to case and punctuation
    group: str = ""  # heading under which the nomenclature lists it


def _catalogue() -> Iterator[Signal]:
    with Path(__file__).with_name("signals.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            plausible = float(row["low"] or -inf), float(row["high"] or inf)
            about = row["name"], row["unit"], row["meaning"], row["positive"]
            yield Signal(*about, plausible, tuple(row["aliases"].split()), row["group"])


SIGNALS: dict[str, Signal] = {each.name: each for each in _catalogue()}  # Every canonical signal by name


def signal(name: str) -> Signal:
    try:
        return SIGNALS[name]
    except KeyError:
        raise InputError(f"'{name}' is not a canonical signal{nearest(name, SIGNALS)}") from None


def plain(name: str) -> str:
    """A name in lower case without punctuation, for comparison."""
    return "".join(character for character in name.lower() if character.isalnum())


# Ambiguous aliases: they name a quantity, but not what it belongs to
_GENERAL = (
    "speed", "velocity", "v", "yaw", "roll", "pitch", "psi", "beta", "delta", "mu", "bank", "grade", "sat"
)  # fmt: skip

_SEPARATORS = ("::", ".", "/", ":", "\\")


@cache
def _by_alias() -> dict[str, Signal]:
    table = {plain(alias): found for found in SIGNALS.values() for alias in found.aliases}
    return table | {plain(name): found for name, found in SIGNALS.items()}


def match(source: str, unit: str = "", qualified: bool = False) -> Signal | None:
    """The canonical signal that a name from a recording stands for, by name or alias; None where none is known.

    An ambiguous alias after a qualifier counts only with a suitable unit: "Engine.Speed" is the speed of the vehicle
    only in a unit of speed, such as km/h.

    Args:
        source: name in the file; of "EPS.DriverTorque" the part after the last separator is tried too
        unit: as the file writes it; "" where it has none
    """
    found = _known(source, unit, qualified)
    for separator in _SEPARATORS:
        if found is None and separator in source:
            found = _known(source.rsplit(separator, 1)[1], unit, True)
    return found


def _known(source: str, unit: str, qualified: bool) -> Signal | None:
    name = plain(source)
    found = _by_alias().get(name)
    doubtful = qualified and name in _GENERAL
    return None if found is None or (doubtful and not _fits(unit, found)) else found


def _fits(unit: str, found: Signal) -> bool:
    try:
        return bool(unit.strip()) and unit != COUNT and bool(scale(unit, found.unit))
    except InputError:
        return False


# Relative residues: two units in the last place of single precision, 256 of double precision. Conversions, means and
# interpolations of equal readings differ by less. The resolution of a 20-bit converter is four times the former.
SINGLE, DOUBLE = 2.0**-22, 2.0**-44

# Magnitude assumed for a signal without a plausible range [its unit]: five turns of the pinion in motor angle
UNBOUNDED = 100.0


@lru_cache
def residue_of(name: str) -> float:
    """Largest difference of two readings of a canonical signal that counts as rounding residue [its unit].

    It follows from the plausible range, not from the recording: the range is known at the first sample, and no fault
    changes it.
    """
    size = max(map(abs, SIGNALS[name].plausible))
    return SINGLE * (size if math.isfinite(size) else UNBOUNDED)


def residue_between(least: float, most: float) -> float:
    """Largest difference of two values of any channel that counts as rounding residue [its unit].

    Single precision applies to the range of the values, not to their magnitude: a position of five million metres may
    change by centimetres.
    """
    return max(SINGLE * (most - least), DOUBLE * max(abs(least), abs(most)))


def levels_of(values: np.ndarray, residue: float) -> tuple[np.ndarray, np.ndarray]:
    """Distinct values in increasing order, merged where they differ by a residue, and the number of each.

    Args:
        values: finite, (n,)
    """
    distinct, counts = np.unique(values, return_counts=True)
    first = np.flatnonzero(np.diff(distinct, prepend=-math.inf) > residue)
    return distinct[first], np.add.reduceat(counts, first) if len(first) else counts
