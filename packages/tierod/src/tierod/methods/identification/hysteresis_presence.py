"""Test whether the torques of a steering contain the hysteresis of dry friction, if its magnitude is not observable."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.errors import InputError
from tierod.physics.friction import dahl_update

_SMALLEST = 1e-6  # singular value over the largest, below which columns count as dependent
# Smallest explained share for the presence of hysteresis [-]. Simulated cars without friction reach 0.08, since not
# only friction depends on the direction of motion; with 2 to 8 N*m of friction they have 0.7 to 0.9.
SMALLEST_SHARE = 0.1


@dataclass(frozen=True)
class HysteresisPresence:
    """Explained share of the build-up of friction, compared with that of time-shifted copies."""

    # of the variance of the build-up not explained by other causes, the share explained by both torques [-]
    share: float
    chance: float  # the largest such share for copies of the build-up shifted in time [-]
    seconds: float  # length of the recording [s]

    @property
    def present(self) -> bool:
        """Whether the torques explain the build-up of friction, and twice as much as any shifted copy of it."""
        return self.share > max(SMALLEST_SHARE, 2.0 * self.chance)


@dataclass(frozen=True)
class HysteresisPresenceTest:
    """Permutation test: regression of the build-up of friction, and of time-shifted copies, on both torques.

    It needs neither calibrated torques nor a long drive, since only the sign pattern of hysteresis matters. Angle, rate
    and lateral acceleration are regressed out first, so that elasticity and damping do not count as hysteresis. Driver
    and motor overcome friction together, in a ratio that need not be known; each alone shows little of it, since the
    assist makes one a function of the other.

    Source: own; a permutation test on the regression that Dahl's law of friction suggests (AIAA J. 14, 1976, 1675).
    """

    # assumed build-up angle of friction [rad]; within a factor of three of the truth the result hardly changes
    dahl_angle: Annotated[float, "rad"] = math.radians(1.0)
    # number of copies of the build-up, shifted cyclically; by chance the largest of n is exceeded once in n + 1
    shifts: int = 40
    # smallest shift over the length of the recording [-]; strokes must be shorter than it
    smallest_shift: Annotated[float, ""] = 0.1
    shortest: Annotated[float, "s"] = 20.0  # shortest recording [s]; a shorter one has too few strokes

    def test(
        self,
        time: np.ndarray,
        steering_wheel_angle: np.ndarray,
        steering_wheel_rate: np.ndarray,
        driver_torque: np.ndarray,
        motor_torque: np.ndarray,
        lateral_acceleration: np.ndarray,
    ) -> HysteresisPresence:
        """The result for one recording.

        Args: time [s], uniform, shape (n,) like all others; steering_wheel_angle [rad]; steering_wheel_rate [rad/s];
        lateral_acceleration [m/s**2].
        """
        others = np.column_stack([np.ones_like(time), steering_wheel_angle, steering_wheel_rate, lateral_acceleration])
        torques = np.column_stack([driver_torque, motor_torque])
        whole = np.isfinite(others).all(axis=1) & np.isfinite(torques).all(axis=1)
        seconds = float(np.count_nonzero(whole)) * float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        if seconds < self.shortest:
            raise InputError(f"hysteresis cannot be tested in {seconds:.0f} s; give at least {self.shortest:g} s")
        build_up = self._build_up(steering_wheel_angle[whole])
        basis = _basis(others[whole])
        acting = _basis(_without(basis, torques[whole]))
        if np.ptp(driver_torque[whole]) == 0.0 or np.ptp(build_up) == 0.0:
            raise InputError("hysteresis cannot be tested: torque or angle is constant; give a recording of driving")
        count = len(build_up)
        first, last = self.smallest_shift * count, (1.0 - self.smallest_shift) * count
        shifts = np.linspace(first, last, self.shifts).astype(int)
        by_chance = [_explained(_without(basis, np.roll(build_up, shift)), acting) for shift in shifts]
        return HysteresisPresence(_explained(_without(basis, build_up), acting), max(by_chance), seconds)

    def _build_up(self, angle: np.ndarray) -> np.ndarray:
        level, levels = 0.0, [0.0]
        for increment in np.diff(angle).tolist():
            level = dahl_update(level, increment, self.dahl_angle)
            levels.append(level)
        return np.array(levels)


def _without(basis: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.asarray(values - basis @ (basis.T @ values))


def _basis(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the span of columns; zero or dependent columns are left out."""
    scale = np.linalg.norm(columns, axis=0)
    left, size, _ = np.linalg.svd(columns / np.where(scale > 0.0, scale, 1.0), full_matrices=False)
    return left[:, size > _SMALLEST * size[0]]


def _explained(build_up: np.ndarray, basis: np.ndarray) -> float:
    power = float(build_up @ build_up)
    return float(np.sum((basis.T @ build_up) ** 2)) / power if power > 0.0 else 0.0
