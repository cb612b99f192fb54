"""What angles and torque of a column say of its ratio and torsion bar."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

CLEAR = 5.0
"""A figure counts from so many standard errors on."""

FEWEST = 500
"""Samples below which nothing is said."""


class ColumnGeometry(NamedTuple):
    """Ratio and stiffness as the recording has them.

    Args:
        ratio: turns of the motor per turn of the wheel
        stiffness: of the bar [N m/rad]
    """

    ratio: float
    stiffness: float


class GeometryOverDrive:
    """Least squares of wheel angle = motor angle / ratio + torque of the bar / stiffness + constant, piece by piece."""

    def __init__(self) -> None:
        self._first: np.ndarray | None = None
        self._products = np.zeros((4, 4))

    def add(self, wheel_angle: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        """The next piece: angles [rad] and torque of the bar [N*m], (n,) each; NaN where missing."""
        rows = np.column_stack([wheel_angle, motor_angle, driver_torque])
        rows = rows[np.isfinite(rows).all(axis=1)]
        if not len(rows):
            return
        if self._first is None:
            self._first = rows[0]
        whole = np.column_stack([rows - self._first, np.ones(len(rows))])
        self._products += whole.T @ whole

    def found(self) -> ColumnGeometry | None:
        """What the pieces say; None where they do not say it clearly, or a sign is wrong."""
        count = self._products[3, 3]
        if count < FEWEST:
            return None
        centred = self._products[:3, :3] - np.outer(self._products[:3, 3], self._products[3, :3]) / count
        normal, right = centred[1:, 1:], centred[1:, 0]
        size = np.sqrt(np.diag(normal))
        if not np.all(size > 0.0) or np.linalg.cond(normal / np.outer(size, size)) > 1e8:
            return None
        share = np.linalg.solve(normal, right)
        spread = max(centred[0, 0] - share @ right, 0.0) / count
        errors = np.sqrt(spread * np.diag(np.linalg.inv(normal)))
        if not np.all(share > CLEAR * errors):
            return None
        return ColumnGeometry(*(1.0 / float(each) for each in share))
