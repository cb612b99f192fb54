"""Test of the estimated sideslip's changes against lateral acceleration, yaw rate and speed, without a truth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.monitors.sideslip.relations import BlocksOverDrive, RelationOverDrive


@dataclass(frozen=True)
class OwnMotionLimits:
    """Limits from which the estimate contradicts the motion.

    Args:
        slowest: speed below which lateral acceleration is uninformative
        share: tolerated difference of the share from 1; roll, place and delay of the accelerometer make 0.37
        certain: standard deviations of the share beyond that
        bands: standard deviations of the estimate that the resulting error must exceed: a 95 % band must contain it
        least: resulting error below which nothing is reported
        separable: least share of the squared estimated changes that turning does not explain; errors of 5 % of the
            estimated changes make a quarter of it, and below it the share would be that of the errors
    """

    slowest: Annotated[float, "m/s"] = 3.0
    share: Annotated[float, ""] = 0.4
    certain: Annotated[float, ""] = 3.0
    bands: Annotated[float, ""] = 1.96
    least: Annotated[float, "rad"] = math.radians(0.2)
    separable: Annotated[float, ""] = 0.01


class Share(NamedTuple):
    """Share of the estimated changes that the car really makes.

    Args:
        value: 1 where the estimate is right [-]
        deviation: standard deviation of the value [-]
        tolerance: share of the squared estimated changes that turning does not explain [-]
    """

    value: float
    deviation: float
    tolerance: float


class OwnMotionOverDrive:
    """Share of the estimated changes of the lateral speed in a - v r, independent of how the drive is cut.

    In a = v r + vy' the measured a, v and r give vy', which does not depend on stiffness, mass or distances. A place of
    the accelerometer ahead of the centre of gravity enters the term of the yaw acceleration, bank and zeros the
    constant. A share of one half means that the estimate changes twice as much as the car does.

    Args:
        rate: sampling rate [Hz]
        limits: limits of a contradiction
    """

    def __init__(self, rate: float, limits: OwnMotionLimits | None = None):
        self.limits = limits or OwnMotionLimits()
        self._blocks = BlocksOverDrive(rate, 4)
        self._relation = RelationOverDrive(4)
        self._angles, self._variance = np.zeros(3), np.zeros(2)

    def add(self, speed: np.ndarray, yaw_rate: np.ndarray, lateral: np.ndarray, sideslip: np.ndarray) -> None:
        """Add the next piece, (n,) each; NaN where missing.

        Args:
            speed: vehicle speed [m/s]
            yaw_rate: yaw rate [rad/s]
            lateral: lateral acceleration [m/s**2]
            sideslip: estimated sideslip angle [rad]
        """
        known = np.isfinite(sideslip) & (speed > self.limits.slowest)
        self._angles += (known.sum(), sideslip[known].sum(), sideslip[known] @ sideslip[known])
        blocks, changes = self._blocks.add(np.column_stack([speed, yaw_rate, lateral, speed * np.tan(sideslip)]))
        if not len(blocks):
            return
        _, turning, _, across = (changes / self._blocks.seconds).T
        turn = (blocks[:, :, 0] * blocks[:, :, 1]).mean(axis=1)
        mean = blocks.mean(axis=1)
        self._relation.add((across, turn, turning, np.ones(len(blocks))), mean[:, 2], mean[:, 0] > self.limits.slowest)

    def deviations(self, deviation: np.ndarray) -> None:
        """Add standard deviations of the estimate [rad], (n,), with the spread of the parameters; NaN where held."""
        known = deviation[np.isfinite(deviation)]
        self._variance += (len(known), known @ known)

    def share(self) -> Share | None:
        """The share; None where the drive does not determine it."""
        relation = self._relation.found()
        if relation is None:
            return None
        return Share(float(relation.values[0]), math.sqrt(relation.covariance[0, 0]), float(relation.tolerance[0]))

    def wrong(self) -> str | None:
        """Sentence on a wrong estimate; None where it changes as the car does, or within its band."""
        limits, found = self.limits, self.share()
        count, total, squares = self._angles
        if found is None or not (count and self._variance[0]):
            return None
        if found.tolerance < limits.separable:
            return None
        band = math.sqrt(self._variance[1] / self._variance[0])
        off = abs(found.value - 1.0)
        error = off * math.sqrt(max(squares / count - (total / count) ** 2, 0.0))
        if off < limits.share + limits.certain * found.deviation or error < max(limits.least, limits.bands * band):
            return None
        return (
            f"by lateral_acceleration, yaw_rate and vehicle_speed, the lateral speed changes by {found.value:.2f} ± "
            f"{found.deviation:.2f} times the estimate: stiffness, mass or distances of the vehicle file do not fit, "
            "or one of these signals, the steering angle or the steering torque is wrong"
        )
