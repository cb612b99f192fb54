"""Rounding residues: differences between readings that stem from arithmetic, not from the sensor."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from tierod.core.signals import SIGNALS

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
