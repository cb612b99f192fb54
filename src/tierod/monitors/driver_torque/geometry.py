"""What angles and torque of a column say of its signs, ratio and torsion bar."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

CLEAR = 5.0
"""A figure counts from so many standard errors on."""

FEWEST = 500
"""Samples below which nothing is said."""


class ColumnGeometry(NamedTuple):
    """Ratio and stiffness as the recording has them, with standard errors of their inverses.

    Args:
        ratio: turns of the motor per turn of the wheel; negative where a sign is wrong
        stiffness: of the bar [N m/rad]; negative where a sign is wrong
        turned: signals whose sign contradicts the others
    """

    ratio: float
    stiffness: float
    turned: tuple[str, ...]


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
        """What the pieces say; None where they do not say it clearly."""
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
        if not np.all(np.abs(share) > CLEAR * errors):
            return None
        motor, bar = share
        return ColumnGeometry(1.0 / float(motor), 1.0 / float(bar), _turned(float(motor), float(bar)))


def _turned(motor: float, bar: float) -> tuple[str, ...]:
    """A turned wheel angle turns both shares, each other signal its own."""
    signs = (math.copysign(1.0, motor), math.copysign(1.0, bar))
    wrong = {(1.0, -1.0): "driver_torque", (-1.0, 1.0): "motor_angle_mechanical", (-1.0, -1.0): "steering_wheel_angle"}
    return (wrong[signs],) if signs in wrong else ()
