"""Regressions over a drive: ratio, torsion bar with torque offset, late signals, and inertia below the bar."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.regression import Solution, solved

CLEAR = 5.0
"""Least ratio of an estimate to its standard error."""

FEWEST = 500
"""Least number of samples for an estimate."""

HALF = 0.01
"""Half of the time over which rates are differences [s]; short against motion up to 10 Hz, long against the noise."""

LONGEST_LAG = 0.2
"""Largest lag that is accepted [s]; signals farther apart, or of a wrong scale, are no longer linear in the lag."""

SPAN = 0.02
"""Half of the time over which rates are differences [s]; noise of the motor's angle makes 20 rad/s^2 of it, a sweep
thousands."""

CLEAR_INERTIA = 10.0
"""Least ratio of the inertia to its standard error; friction that follows the angle is not white noise."""

LEAST = 50.0
"""Least standard deviation of the motor's acceleration for an estimate, twice that of its noise [rad/s^2]."""

SLIDING = 0.5
"""Speed of the motor over which dry friction changes its sign [rad/s]."""

_WHEEL, _MOTOR, _BAR, _MOTOR_RATE, _BAR_RATE, _MOTOR_BEND, _ONE = range(7)


class ColumnGeometry(NamedTuple):
    """Ratio and stiffness identified from a recording, and further disagreement of its three signals.

    Args:
        ratio: turns of the motor per turn of the wheel
        stiffness: stiffness of the torsion bar [N m/rad]
        torque_offset: offset of the bar's torque, if both angles are zero on the unloaded bar [N m]
        late: the signal that is latest against the other two or the other angle; "" where none stands out
        lag: its lag [s]
        ratio_uncertainty: relative uncertainty of the ratio from errors of the angles that correlate with the motion
    """

    ratio: float
    stiffness: float
    torque_offset: float = 0.0
    late: str = ""
    lag: float = 0.0
    ratio_uncertainty: float = 0.0


class GeometryOverDrive:
    """Least squares of wheel angle = motor angle / ratio + bar torque / stiffness + constant, piece by piece.

    A late signal is its value less its rate times the lag, to second order: the rates of motor angle and torque as
    further regressors give the lags between the three, and the motor's acceleration absorbs the remainder of a late
    angle.

    Args:
        rate: sampling rate [Hz]
    """

    def __init__(self, rate: float = 1000.0) -> None:
        self._half, self._rate = max(round(HALF * rate), 1), rate
        self._first: np.ndarray | None = None
        self._before = np.empty((0, 3))
        self._products = np.zeros((7, 7))

    def add(self, wheel_angle: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        """Add the next piece: angles [rad] and torque of the bar [N*m], (n,) each; NaN where missing."""
        rows = np.vstack([self._before, np.column_stack([wheel_angle, motor_angle, driver_torque])])
        self._before = rows[-2 * self._half :]
        if len(rows) <= 2 * self._half:
            return
        behind, now, ahead = rows[: -2 * self._half], rows[self._half : -self._half], rows[2 * self._half :]
        span = self._half / self._rate
        rates = (ahead - behind)[:, 1:] / (2.0 * span)
        bend = (ahead - 2.0 * now + behind)[:, 1] / span**2
        rows = np.column_stack([now, rates, bend])
        rows = rows[np.isfinite(rows).all(axis=1)]
        if not len(rows):
            return
        if self._first is None:
            # Products about the first row, or the squares of large constant angles would cancel badly.
            self._first = np.array([*rows[0, :3], 0.0, 0.0, 0.0])
        whole = np.column_stack([rows - self._first, np.ones(len(rows))])
        self._products += whole.T @ whole

    def found(self) -> ColumnGeometry | None:
        """The geometry that the pieces identify; None where it is not clear, or a sign is wrong."""
        if self._first is None or self._products[_ONE, _ONE] < FEWEST:
            return None
        rates = (_MOTOR, _BAR, _MOTOR_RATE, _BAR_RATE)
        # In a sine, angle and acceleration are linearly dependent; the acceleration is then left out.
        moving = self._shares((*rates, _MOTOR_BEND)) or self._shares(rates)
        shares = moving if moving is not None and _clear(moving) else self._shares((_MOTOR, _BAR))
        if shares is None or not _clear(shares):
            return None
        by_motor, by_bar = shares.values[:2].tolist()
        means = self._first[:3] + self._products[_ONE, :3] / self._products[_ONE, _ONE]
        constant = float(means[_WHEEL] - by_motor * means[_MOTOR] - by_bar * means[_BAR])
        late = ("", 0.0) if moving is None else _latest(moving)
        return ColumnGeometry(1.0 / by_motor, 1.0 / by_bar, -constant / by_bar, *late, self._uncertainty(shares))

    def _uncertainty(self, shares: Solution) -> float:
        """Relative uncertainty: residual over motion, since the residual is not white and may correlate with it."""
        count = self._products[_ONE, _ONE]
        power = self._products[_MOTOR, _MOTOR] - self._products[_MOTOR, _ONE] ** 2 / count
        return math.sqrt(max(shares.left, 0.0) / power) / abs(float(shares.values[0]))

    def _shares(self, signals: tuple[int, ...]) -> Solution | None:
        """Coefficients of these signals in the wheel angle; None where the signals are linearly dependent."""
        count = self._products[_ONE, _ONE]
        centred = self._products - np.outer(self._products[:, _ONE], self._products[_ONE]) / count
        normal, right = centred[np.ix_(signals, signals)], centred[list(signals), _WHEEL]
        return solved(normal, right, centred[_WHEEL, _WHEEL], count)


def _clear(shares: Solution) -> bool:
    return bool(np.all(shares.values[:2] > CLEAR * shares.deviations[:2]))


def _latest(shares: Solution) -> tuple[str, float]:
    """The latest signal and its lag [s]; where two of three agree the third, which may also be early.

    Where the lag hides the coefficient of the bar, only the angles are compared, and the later one is named.
    """
    share = shares.values
    apart = {"steering_wheel_angle": 0.0, "motor_angle_mechanical": float(share[2] / share[0])}
    if share[1] > CLEAR * shares.deviations[1]:
        apart["driver_torque"] = float(share[3] / share[1])
    if any(not abs(each) < LONGEST_LAG for each in apart.values()):
        return "", 0.0
    reference = sorted(apart.values())[len(apart) // 2 if len(apart) > 2 else 0]
    name = max(apart, key=lambda each: abs(apart[each] - reference))
    return name, apart[name] - reference


class BelowBarOverDrive:
    """Least squares of motor torque + bar torque / ratio = inertia, damping, dry friction and a constant, piecewise.

    Valid on a bench; in a car rack and road act as well. A few samples are lost at the cuts between pieces.

    Args:
        ratio: turns of the motor per turn of the wheel
        rate: sampling rate [Hz]
    """

    def __init__(self, ratio: float, rate: float) -> None:
        self._ratio, self._rate, self._step = ratio, rate, max(round(SPAN * rate), 1)
        self._products = np.zeros((5, 5))

    def add(self, motor_torque: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        """Add the next piece: torques [N*m] and angle of the motor [rad], (n,) each; NaN where missing."""
        step, span = self._step, self._step / self._rate
        if len(motor_angle) <= 2 * step:
            return
        behind, now, ahead = motor_angle[: -2 * step], motor_angle[step:-step], motor_angle[2 * step :]
        speed = (ahead - behind) / (2.0 * span)
        bend = (ahead - 2.0 * now + behind) / span**2
        torque = (motor_torque + driver_torque / self._ratio)[step:-step]
        rows = np.column_stack([torque, bend, speed, np.tanh(speed / SLIDING), np.ones(len(now))])
        rows = rows[np.isfinite(rows).all(axis=1)]
        self._products += rows.T @ rows

    def inertia(self) -> float | None:
        """Inertia of motor and gear at the motor's shaft [kg m^2]; None where it is not identifiable."""
        count, normal = self._products[4, 4], self._products[1:, 1:]
        if normal[0, 0] < LEAST**2 * count:
            return None
        found = solved(normal, self._products[1:, 0], self._products[0, 0], count)
        if found is None or not found.values[0] > CLEAR_INERTIA * found.deviations[0]:
            return None
        return float(found.values[0])
