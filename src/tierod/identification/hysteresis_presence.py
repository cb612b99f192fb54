"""Whether the driver's torque carries the hysteresis of dry friction, where its size cannot be told."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.errors import InputError
from tierod.physics.friction import dahl_update


@dataclass(frozen=True)
class HysteresisPresence:
    """How much of the driver's torque goes with the build-up of friction, against chance.

    Args:
        share: of the torque's variance that other causes leave, explained by the build-up of friction []
        chance: the largest such share when the build-up is shifted in time against the torque []
        seconds: of recording it rests on [s]
    """

    share: float
    chance: float
    seconds: float

    @property
    def present(self) -> bool:
        """Whether the torque follows the build-up of friction more than any shifted copy of it, by a factor of two."""
        return self.share > 2.0 * self.chance


@dataclass(frozen=True)
class HysteresisPresenceTest:
    """Regress the driver's torque on the build-up of friction, and on shifted copies of it.

    Needs neither calibrated torques nor much of a drive: only the sign pattern of hysteresis is asked for. Angle, rate,
    lateral acceleration and motor torque are allowed to explain what they can first, so that elasticity, damping and
    assist do not pass for hysteresis.

    Args:
        dahl_angle: over which friction is supposed to build up [rad]; one degree, and within a factor of three of the
            truth the outcome hardly changes
        shifts: copies of the build-up shifted around the recording; the largest of n is passed by chance once in n + 1
        smallest_shift: share of the recording below which a shift is none []; strokes are much shorter than a tenth of
            a minute
        shortest: recording that is needed [s]; with less there are too few strokes to tell

    Source: own; a permutation test on the regression that Dahl's law of friction suggests (AIAA J. 14, 1976, 1675).
    """

    dahl_angle: Annotated[float, "rad"] = math.radians(1.0)
    shifts: int = 40
    smallest_shift: Annotated[float, ""] = 0.1
    shortest: Annotated[float, "s"] = 20.0

    def test(
        self,
        time: np.ndarray,
        steering_wheel_angle: np.ndarray,
        steering_wheel_rate: np.ndarray,
        driver_torque: np.ndarray,
        motor_torque: np.ndarray,
        lateral_acceleration: np.ndarray,
    ) -> HysteresisPresence:
        """The outcome for one recording.

        Args:
            time: [s], uniform, shape (n,) as all others
            steering_wheel_angle: [rad]
            steering_wheel_rate: [rad/s]
            driver_torque, motor_torque: in any unit
            lateral_acceleration: [m/s**2]

        Raises:
            InputError: the recording is too short, or the torque or the angle does not change
        """
        others = np.column_stack(
            [np.ones_like(time), steering_wheel_angle, steering_wheel_rate, lateral_acceleration, motor_torque]
        )
        whole = np.isfinite(others).all(axis=1) & np.isfinite(driver_torque)
        seconds = float(np.count_nonzero(whole)) * float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        if seconds < self.shortest:
            raise InputError(f"hysteresis cannot be looked for in {seconds:.0f} s; give at least {self.shortest:g} s")
        build_up = self._build_up(steering_wheel_angle[whole])
        scale = np.std(others[whole], axis=0)
        basis, _ = np.linalg.qr(others[whole] / np.where(scale > 0.0, scale, 1.0))
        torque = _without(basis, driver_torque[whole])
        if np.ptp(driver_torque[whole]) == 0.0 or np.ptp(build_up) == 0.0:
            raise InputError(
                "hysteresis cannot be looked for: torque or angle is constant; give a recording of driving"
            )
        count = len(build_up)
        first, last = self.smallest_shift * count, (1.0 - self.smallest_shift) * count
        shifts = np.linspace(first, last, self.shifts).astype(int)
        by_chance = [_explained(torque, _without(basis, np.roll(build_up, shift))) for shift in shifts]
        return HysteresisPresence(_explained(torque, _without(basis, build_up)), max(by_chance), seconds)

    def _build_up(self, angle: np.ndarray) -> np.ndarray:
        level, levels = 0.0, [0.0]
        for increment in np.diff(angle).tolist():
            level = dahl_update(level, increment, self.dahl_angle)
            levels.append(level)
        return np.array(levels)


def _without(basis: np.ndarray, values: np.ndarray) -> np.ndarray:
    return values - basis @ (basis.T @ values)


def _explained(torque: np.ndarray, regressor: np.ndarray) -> float:
    power = float(regressor @ regressor)
    return float(torque @ regressor) ** 2 / (power * float(torque @ torque)) if power > 0.0 else 0.0
