"""Covariance of estimates whose residuals are coloured: the sandwich with Newey and West's middle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def long_run_covariance(scores: Sequence[np.ndarray]) -> np.ndarray:
    """Covariance of the sum of scores that depend on each other over time, (parameters, parameters).

    Bartlett's weights over as many samples as Andrews' rule for first-order autoregression asks for, the most that any
    parameter asks for, at most a tenth of the shortest experiment.

    Args:
        scores: derivative of the cost of every sample by the parameters, one array (n, parameters) per experiment

    Source: W. K. Newey, K. D. West, Econometrica 55 (1987) 703; D. W. K. Andrews, Econometrica 59 (1991) 817, eq (6.4).
    """
    lags = min(_bandwidth(scores), min(len(each) for each in scores) // 10)
    total = np.zeros((scores[0].shape[1],) * 2)
    for each in scores:
        total += each.T @ each
        for lag in range(1, lags + 1):
            shifted = each[lag:].T @ each[:-lag]
            total += (1.0 - lag / (lags + 1.0)) * (shifted + shifted.T)
    return total


def _bandwidth(scores: Sequence[np.ndarray]) -> int:
    before, after = np.concatenate([each[:-1] for each in scores]), np.concatenate([each[1:] for each in scores])
    power = np.sum(before**2, axis=0)
    correlation = np.sum(before * after, axis=0) / np.where(power > 0.0, power, 1.0)
    correlation = np.clip(correlation, -0.97, 0.97)
    alpha = 4.0 * correlation**2 / (1.0 - correlation**2) ** 2
    return int(np.ceil(1.1447 * (np.max(alpha) * len(before)) ** (1.0 / 3.0)))


def sandwich(
    information: np.ndarray, scores: Sequence[np.ndarray], known_before: np.ndarray | None = None
) -> np.ndarray:
    """Covariance of an estimate: information^-1 J information^-1, J the long-run covariance of the scores.

    Args:
        information: second derivatives of the cost, or their expectation
        scores: as of `long_run_covariance`
        known_before: information that came from elsewhere and is part of the whole; it is as uncertain as it says

    A coordinate of which there is no information (a noise that was found to be nil) gets no variance.

    Source: P. J. Huber, Fifth Berkeley Symposium 1 (1967) 221.
    """
    diagonal = np.diag(information)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, np.inf))
    inverse = np.linalg.pinv(information * np.outer(scale, scale), hermitian=True) * np.outer(scale, scale)
    middle = long_run_covariance(scores)
    return inverse @ (middle if known_before is None else middle + known_before) @ inverse
