"""The same five-state filter, as a user of filterpy writes it."""

from __future__ import annotations

import time

import numpy as np


def nanoseconds_per_step(samples: np.ndarray, matrices: dict[str, np.ndarray], repeats: int = 3) -> float:
    """Best duration of one predict and update, with the direction of motion set in the transition [ns].

    Args:
        samples: driver torque, motor torque, lateral acceleration, angle, rate, yaw rate, shape (n, 6)
        matrices: A at standstill, friction (entry of A per direction of motion), B, GQG, C, R, P, x
    """
    from filterpy.kalman import KalmanFilter

    best = np.inf
    for _ in range(repeats):
        filter_ = KalmanFilter(dim_x=5, dim_z=3, dim_u=3)
        filter_.F, filter_.B, filter_.H = matrices["A"].copy(), matrices["B"], matrices["C"]
        filter_.Q, filter_.R = matrices["GQG"], matrices["R"]
        filter_.x, filter_.P = matrices["x"].copy(), matrices["P"].copy()
        friction = matrices["friction"]
        inputs, measured = samples[:, :3, None], samples[:, 3:, None]
        start = time.perf_counter()
        for u, y in zip(inputs, measured, strict=True):
            filter_.F[1, 4] = friction * np.sign(y[1, 0])
            filter_.predict(u)
            filter_.update(y)
        best = min(best, (time.perf_counter() - start) / len(samples) * 1e9)
    return best
