"""What angles and torque of a column say of its ratio, its torsion bar, the offset of its torque, and late signals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

CLEAR = 5.0
"""A figure counts from so many standard errors on."""

FEWEST = 500
"""Samples below which nothing is said."""

HALF = 0.01
"""Half of the time over which rates are differences [s]: short against motion up to 10 Hz, long against the noise."""

WORST = 1e8
"""Greatest condition number of the scaled normal equations."""

LONGEST_LAG = 0.2
"""Beyond it a lag is none [s]: signals that far apart, or of a wrong scale, are no longer a line in the lag."""

_WHEEL, _MOTOR, _BAR, _MOTOR_RATE, _BAR_RATE, _MOTOR_BEND, _ONE = range(7)


class ColumnGeometry(NamedTuple):
    """Ratio and stiffness as the recording has them, and what else its three signals disagree in.

    Args:
        ratio: turns of the motor per turn of the wheel
        stiffness: of the bar [N m/rad]
        torque_offset: of the bar's torque, were both angles zero on the unloaded bar [N m]
        late: the signal that is late most, against the other two or the other angle; "" where none can be told
        lag: of it [s]
    """

    ratio: float
    stiffness: float
    torque_offset: float = 0.0
    late: str = ""
    lag: float = 0.0


class GeometryOverDrive:
    """Least squares of wheel angle = motor angle / ratio + torque of the bar / stiffness + constant, piece by piece.

    A signal that is late is its value less its rate times the lag, to second order: the rates of motor angle and torque
    beside them tell how far the three are apart, and the motor's acceleration takes what else a late angle leaves.

    Args:
        rate: of the samples [Hz]
    """

    def __init__(self, rate: float = 1000.0) -> None:
        self._half, self._rate = max(round(HALF * rate), 1), rate
        self._first: np.ndarray | None = None
        self._before = np.empty((0, 3))
        self._products = np.zeros((7, 7))

    def add(self, wheel_angle: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        """The next piece: angles [rad] and torque of the bar [N*m], (n,) each; NaN where missing."""
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
            self._first = np.array([*rows[0, :3], 0.0, 0.0, 0.0])
        whole = np.column_stack([rows - self._first, np.ones(len(rows))])
        self._products += whole.T @ whole

    def found(self) -> ColumnGeometry | None:
        """What the pieces say; None where they do not say it clearly, or a sign is wrong."""
        if self._first is None or self._products[_ONE, _ONE] < FEWEST:
            return None
        rates = (_MOTOR, _BAR, _MOTOR_RATE, _BAR_RATE)
        moving = self._shares((*rates, _MOTOR_BEND)) or self._shares(rates)  # a sine and its bend are one
        shares = moving if moving is not None and _clear(moving) else self._shares((_MOTOR, _BAR))
        if shares is None or not _clear(shares):
            return None
        by_motor, by_bar = shares[0][:2]
        means = self._first[:3] + self._products[_ONE, :3] / self._products[_ONE, _ONE]
        constant = float(means[_WHEEL] - by_motor * means[_MOTOR] - by_bar * means[_BAR])
        late = ("", 0.0) if moving is None else _latest(*moving)
        return ColumnGeometry(1.0 / float(by_motor), 1.0 / float(by_bar), -constant / float(by_bar), *late)

    def _shares(self, signals: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray] | None:
        """Shares of these signals in the wheel's angle, and their standard errors; None where they hang together."""
        count = self._products[_ONE, _ONE]
        centred = self._products - np.outer(self._products[:, _ONE], self._products[_ONE]) / count
        normal, right = centred[np.ix_(signals, signals)], centred[list(signals), _WHEEL]
        size = np.sqrt(np.diag(normal))
        if not np.all(size > 0.0) or np.linalg.cond(normal / np.outer(size, size)) > WORST:
            return None
        share = np.linalg.solve(normal, right)
        spread = max(centred[_WHEEL, _WHEEL] - share @ right, 0.0) / count
        return share, np.sqrt(spread * np.diag(np.linalg.inv(normal)))


def _clear(shares: tuple[np.ndarray, np.ndarray]) -> bool:
    return bool(np.all(shares[0][:2] > CLEAR * shares[1][:2]))


def _latest(share: np.ndarray, errors: np.ndarray) -> tuple[str, float]:
    """The signal that is late most and by how much [s]: where two of three agree, the third, should it be early too.

    Where the lag hides the bar's share only the angles are compared, and the one behind is late.
    """
    apart = {"steering_wheel_angle": 0.0, "motor_angle_mechanical": float(share[2] / share[0])}
    if share[1] > CLEAR * errors[1]:
        apart["driver_torque"] = float(share[3] / share[1])
    if any(not abs(each) < LONGEST_LAG for each in apart.values()):
        return "", 0.0
    reference = sorted(apart.values())[len(apart) // 2 if len(apart) > 2 else 0]
    name = max(apart, key=lambda each: abs(apart[each] - reference))
    return name, apart[name] - reference
