"""Whether the torques of a steering carry the hysteresis of dry friction, where its magnitude is not observable."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.errors import InputError
from tierod.physics.friction import dahl_update

_SMALLEST = 1e-6  # of a singular value over the largest: below, two columns are dependent


SMALLEST_SHARE = 0.1
"""Share from which hysteresis is said to be present, whatever chance gives [-]. Virtual cars without friction reach
0.08, since more than friction goes with the direction of motion; with 2 to 8 N*m they have 0.7 to 0.9."""


@dataclass(frozen=True)
class HysteresisPresence:
    """Evidence of the torques for the build-up of friction, against chance.

    Args:
        share: of the build-up's variance that other causes leave, explained by both torques together []
        chance: the largest such share when the build-up is shifted in time against the torques []
        seconds: of recording it rests on [s]
    """

    share: float
    chance: float
    seconds: float

    @property
    def present(self) -> bool:
        """Whether the torques follow the build-up of friction, and twice as much as any shifted copy of it."""
        return self.share > max(SMALLEST_SHARE, 2.0 * self.chance)


@dataclass(frozen=True)
class HysteresisPresenceTest:
    """Regress the build-up of friction on both torques, and shifted copies of it likewise.

    Needs neither calibrated torques nor much of a drive: only the sign pattern of hysteresis is asked for. Angle, rate
    and lateral acceleration are allowed to explain what they can first, so that elasticity and damping do not pass for
    hysteresis. Driver and motor overcome friction together, in a ratio that need not be known; each alone shows little
    of it, since the assist makes the one a function of the other.

    Args:
        dahl_angle: over which friction is supposed to build up [rad]; one degree, and within a factor of three of the
            truth the outcome hardly changes
        shifts: copies of the build-up shifted around the recording; the largest of n is passed by chance once in n + 1
        smallest_shift: share of the recording below which a shift is none []; strokes are much shorter than a tenth of
            a minute
        shortest: recording that is needed [s]; with less there are too few strokes

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
            InputError: the recording is too short, or the driver's torque or the angle does not change
        """
        others = np.column_stack([np.ones_like(time), steering_wheel_angle, steering_wheel_rate, lateral_acceleration])
        torques = np.column_stack([driver_torque, motor_torque])
        whole = np.isfinite(others).all(axis=1) & np.isfinite(torques).all(axis=1)
        seconds = float(np.count_nonzero(whole)) * float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        if seconds < self.shortest:
            raise InputError(f"hysteresis cannot be looked for in {seconds:.0f} s; give at least {self.shortest:g} s")
        build_up = self._build_up(steering_wheel_angle[whole])
        basis = _basis(others[whole])
        acting = _basis(_without(basis, torques[whole]))
        if np.ptp(driver_torque[whole]) == 0.0 or np.ptp(build_up) == 0.0:
            raise InputError(
                "hysteresis cannot be looked for: torque or angle is constant; give a recording of driving"
            )
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
    """Orthonormal columns that span the given ones; what is constant zero, or a copy of another, is left out."""
    scale = np.linalg.norm(columns, axis=0)
    left, size, _ = np.linalg.svd(columns / np.where(scale > 0.0, scale, 1.0), full_matrices=False)
    return left[:, size > _SMALLEST * size[0]]


def _explained(build_up: np.ndarray, basis: np.ndarray) -> float:
    """Share of the variance of the build-up that lies in the span of a basis."""
    power = float(build_up @ build_up)
    return float(np.sum((basis.T @ build_up) ** 2)) / power if power > 0.0 else 0.0
