"""Rounding residues: differences between readings that arithmetic made, not the sensor."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from tierod.core.signals import SIGNALS

SINGLE, DOUBLE = 2.0**-22, 2.0**-44
"""Two units in the last place of single precision, 256 of double precision: conversions, means and interpolations
of readings that are alike differ by less. The step of a converter of 20 bits is four times the former."""

UNBOUNDED = 100.0
"""Size that is taken of a signal without a plausible range, in its unit: five turns of a pinion by a motor's angle."""


@lru_cache
def residue_of(name: str) -> float:
    """Greatest difference of two readings of a canonical signal that is a residue [its unit].

    The plausible range decides, not the recording: it is known with the first sample, and nothing broken moves it.

    Args:
        name: of a signal of the catalogue
    """
    size = max(map(abs, SIGNALS[name].plausible))
    return SINGLE * (size if math.isfinite(size) else UNBOUNDED)


def residue_between(least: float, most: float) -> float:
    """Greatest difference of two values of any channel that is a residue [its unit].

    A position of five million metres may move by centimetres, so single precision counts of the range alone.

    Args:
        least, most: of its values
    """
    return max(SINGLE * (most - least), DOUBLE * max(abs(least), abs(most)))


def levels_of(values: np.ndarray, residue: float) -> tuple[np.ndarray, np.ndarray]:
    """Distinct values in rising order, those that differ by a residue as one, and how many there are of each.

    Args:
        values: finite, (n,)
        residue: greatest difference that is none
    """
    distinct, counts = np.unique(values, return_counts=True)
    first = np.flatnonzero(np.diff(distinct, prepend=-math.inf) > residue)
    return distinct[first], np.add.reduceat(counts, first) if len(first) else counts
