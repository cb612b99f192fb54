"""Dynamic time warping of signals within a band."""

from __future__ import annotations

import numpy as np

from tierod.core.errors import ParameterError


def warped(moved: np.ndarray, fixed: np.ndarray, band: int) -> np.ndarray:
    """Signals warped in time so that they follow other signals as closely as possible.

    The path through the plane of both times starts and ends at the common ends, advances by one sample in either time
    or in both, and minimises the sum of absolute differences. Where several samples of the moved signal belong to one
    of the fixed signal, their mean is taken.

    Args:
        moved: signals to be warped, (many, samples)
        fixed: signals that they are to follow, (many, samples)
        band: largest difference of both times [samples] (Sakoe and Chiba); 0 leaves the signals unchanged

    Returns:
        the moved signals in the time of the fixed ones, (many, samples)

    Raises:
        ParameterError: shapes that differ, or a negative band

    Source: Sakoe and Chiba, IEEE Trans. ASSP 26 (1978) 43, symmetric form without slope constraint, unit weights.
    """
    if moved.shape != fixed.shape or moved.ndim != 2:
        shapes = f"{moved.shape} and {fixed.shape}"
        raise ParameterError(f"courses of shapes {shapes} do not match; give (many, samples) twice")
    if band < 0:
        raise ParameterError(f"the band of a warping is {band} samples; expected zero or more")
    return _means(moved, *_path(_totals(moved, fixed, band), band))


def _totals(moved: np.ndarray, fixed: np.ndarray, band: int) -> np.ndarray:
    """Smallest sums of differences up to each pair of samples, (samples of fixed, many, 2 band + 3).

    For fixed sample i, column band + 1 + k is that of moved sample i + k; the outermost columns are infinite.
    """
    many, samples = fixed.shape
    totals = np.full((samples, many, 2 * band + 3), np.inf)
    for i in range(samples):
        for k in range(max(-band, -i), min(band, samples - 1 - i) + 1):
            place = band + 1 + k
            here = np.abs(fixed[:, i] - moved[:, i + k])
            if i == 0 and k == 0:
                totals[0, :, place] = here
                continue
            best = totals[i, :, place - 1]
            if i > 0:
                best = np.minimum(best, np.minimum(totals[i - 1, :, place], totals[i - 1, :, place + 1]))
            totals[i, :, place] = here + best
    return totals


def _path(totals: np.ndarray, band: int) -> tuple[np.ndarray, np.ndarray]:
    samples, many, _ = totals.shape
    rows = np.arange(many)
    first, last = np.zeros((many, samples), int), np.zeros((many, samples), int)
    at = np.full(many, samples - 1)
    for i in range(samples - 1, 0, -1):
        last[:, i] = at
        staying = np.ones(many, bool)
        while staying.any():
            place = band + 1 + at - i
            aside = totals[i, rows, place - 1]
            back, up = totals[i - 1, rows, place], totals[i - 1, rows, place + 1]
            # Of equally good steps the one in both times is taken, which gives the shortest path.
            staying &= aside < np.minimum(back, up)
            at = at - staying
        first[:, i] = at
        place = band + 1 + at - i
        at = at - (totals[i - 1, rows, place] <= totals[i - 1, rows, place + 1])
    last[:, 0] = at
    return first, last


def _means(moved: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    sums = np.concatenate([np.zeros((len(moved), 1)), np.cumsum(moved, axis=1)], axis=1)
    rows = np.arange(len(moved))[:, None]
    result: np.ndarray = (sums[rows, last + 1] - sums[rows, first]) / (last + 1 - first)
    return result
