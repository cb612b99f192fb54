"""Fixed-interval smoother over drives: level and slope of every car at each drive, given all its drives."""

from __future__ import annotations

import numpy as np

from tierod.methods.trends.drive_filter import LEVEL, SLOPE, Filtered, TrendNoise, moved


def smoothed(found: Filtered, noise: TrendNoise) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of the state at each drive, given all drives of the car.

    Args:
        noise: of the walks, the same as in the filter

    Returns:
        smoothed means and covariances, (cars, drives, n) and (cars, drives, n, n)

    Source: H. E. Rauch, F. Tung, C. T. Striebel, 1965, doi 10.2514/3.3166.
    """
    mean, covariance = found.mean.copy(), found.covariance.copy()
    for k in range(mean.shape[1] - 2, -1, -1):
        gap = found.gap[:, k + 1]
        ahead, spread = found.mean[:, k].copy(), found.covariance[:, k].copy()
        moved(ahead, spread, gap, noise)
        spread[:, LEVEL, LEVEL] += found.step[:, k + 1]
        cross = found.covariance[:, k].copy()  # of the state now with the state ahead, P F'
        cross[:, :, LEVEL] += gap[:, None] * cross[:, :, SLOPE]
        back = np.swapaxes(np.linalg.solve(_regular(spread), np.swapaxes(cross, 1, 2)), 1, 2)
        mean[:, k] += np.einsum("cij,cj->ci", back, mean[:, k + 1] - ahead)
        covariance[:, k] += back @ (covariance[:, k + 1] - spread) @ np.swapaxes(back, 1, 2)
    return mean, covariance


def _regular(matrix: np.ndarray) -> np.ndarray:
    """The covariance with a small diagonal added: a coefficient without uncertainty would make it singular."""
    order = matrix.shape[-1]
    size = np.einsum("cii->c", matrix) / order
    return np.asarray(matrix + 1e-12 * np.maximum(size, 1e-12)[:, None, None] * np.eye(order))
