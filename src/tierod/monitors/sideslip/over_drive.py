"""Figures of an estimate of the sideslip over the pieces of a recording, beside the truth where there is one."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tierod.core.graph import Result

TRUTHS = ("sideslip_angle", "truth_sideslip_angle")
"""Channels that a recording may have to hold the estimate against: of an optical sensor, or of a simulation."""

BAND = 1.96
"""Standard deviations within which 95 % of a Gaussian error lie."""

KNOWN = 0.05
"""Standard deviation [rad] up to which an angle may be the largest one: more is had before the estimate has settled."""


class OverDrive:
    """Figures over the pieces of a recording."""

    def __init__(self) -> None:
        self.seen = self.samples = self.compared = self.covered = self.angles = self.torques = 0
        self.peak = self.peak_deviation = self.deviation = self.fastest = 0.0
        self.squared_error = self.absolute_error = 0.0
        self._last_truth = math.nan

    def add(
        self,
        running: np.ndarray,
        result: Result,
        truth: np.ndarray,
        speed: np.ndarray,
        angle: np.ndarray,
        torque: np.ndarray,
    ) -> None:
        """The next piece, (n,) each; NaN where missing.

        Args:
            running: whether the estimator ran
            result: of the estimator
            truth: sideslip angle [rad]
            speed: [m/s]
            angle: of the road wheels [rad]
            torque: of the steering's motor, or its current
        """
        sideslip, deviation = result["sideslip_angle"], result["sideslip_angle_deviation"]
        self.seen += len(running)
        self.samples += int(running.sum())
        self.angles += int(np.isfinite(angle).sum())
        self.torques += int(np.isfinite(torque).sum())
        self.fastest = max(self.fastest, float(np.nanmax(speed, initial=0.0)))
        self.deviation += float(np.sum(deviation[running]))
        # A truth that comes more slowly than the grid is held, and stale until it changes.
        fresh = np.diff(truth, prepend=self._last_truth) != 0.0
        self._last_truth = float(truth[-1]) if len(truth) else self._last_truth
        judged = running & np.isfinite(truth) & fresh
        error, band = (sideslip - truth)[judged], BAND * deviation[judged]
        self.compared += len(error)
        self.covered += int(np.sum(np.abs(error) <= band))
        self.squared_error += float(error @ error)
        self.absolute_error += float(np.abs(error).sum())
        told = running & (deviation < KNOWN)
        if told.any():
            at = int(np.argmax(np.where(told, np.abs(sideslip), -1.0)))
            if abs(sideslip[at]) > abs(self.peak):
                self.peak, self.peak_deviation = float(sideslip[at]), float(deviation[at])


def truth_in(signals: Mapping[str, np.ndarray]) -> np.ndarray:
    """What the estimate is held against [rad]; NaN where the recording has nothing."""
    measured, simulated = (signals[name] for name in TRUTHS)
    return np.where(np.isfinite(simulated), simulated, measured)
