"""Slow, obvious filters with full matrices and inverses: the oracles of the fast ones."""

import numpy as np


def kalman_step(mean, covariance, predict, observe, Q, R, measured, mask=None, update="schmidt"):
    """One step of the (extended) Kalman filter.

    predict(x) -> (x-, F); observe(x-) -> (expected, C); NaN in measured is left out; mask is e of every state.
    Returns mean, covariance, innovation, its variances, NIS, count.
    """
    predicted, F = predict(mean)
    before = F @ covariance @ F.T + Q
    expected, C = observe(predicted)
    innovation = measured - expected
    spread = np.diag(C @ before @ C.T + R)
    used = np.isfinite(innovation)
    mask = np.ones(len(mean)) if mask is None else mask
    E = np.diag(mask)
    if not used.any():
        return predicted, before, innovation, spread, 0.0, 0
    C, r, R = C[used], innovation[used], R[np.ix_(used, used)]
    S = C @ before @ C.T + R
    K = before @ C.T @ np.linalg.inv(S)
    gain = E @ K
    if update == "schmidt":
        left = np.eye(len(mean)) - gain @ C
        after = left @ before @ left.T + gain @ R @ gain.T
    else:
        after = (np.eye(len(mean)) - K @ C) @ before
    return predicted + gain @ r, after, innovation, spread, float(r @ np.linalg.inv(S) @ r), int(used.sum())


def sigma_points(mean, covariance, alpha, beta, kappa):
    """Points and weights of the scaled unscented transform, as printed by van der Merwe."""
    n = len(mean)
    scale = alpha**2 * (n + kappa) - n
    root = np.linalg.cholesky((n + scale) * covariance)
    points = np.vstack([mean, mean + root.T, mean - root.T])
    side = 1.0 / (2.0 * (n + scale))
    mean_weights = np.full(2 * n + 1, side)
    mean_weights[0] = scale / (n + scale)
    spread_weights = mean_weights.copy()
    spread_weights[0] += 1.0 - alpha**2 + beta
    return points, mean_weights, spread_weights


def unscented_step(mean, covariance, transition, output, Q, R, measured, alpha, beta, kappa, redraw=True):
    """One step of the unscented filter; NaN in measured is left out."""
    points, wm, wc = sigma_points(mean, covariance, alpha, beta, kappa)
    images = np.array([transition(point) for point in points])
    predicted = wm @ images
    before = (wc[:, None] * (images - predicted)).T @ (images - predicted) + Q
    points = sigma_points(predicted, before, alpha, beta, kappa)[0] if redraw else images
    seen = np.array([output(point) for point in points])
    expected = wm @ seen
    innovation = measured - expected
    used = np.isfinite(innovation)
    S = (wc[:, None] * (seen - expected)).T @ (seen - expected) + R
    cross = (wc[:, None] * (points - predicted)).T @ (seen - expected)
    spread = np.diag(S)
    if not used.any():
        return predicted, before, innovation, spread, 0.0, 0
    S, cross, r = S[np.ix_(used, used)], cross[:, used], innovation[used]
    K = cross @ np.linalg.inv(S)
    nis = float(r @ np.linalg.inv(S) @ r)
    return predicted + K @ r, before - K @ S @ K.T, innovation, spread, nis, int(used.sum())
