"""Consistency of the measured accelerations with the motion: inputs of the filters that no filter estimates.

A filter with a wrong acceleration as its input declares faults of motors and drives. Kinematics predict both
accelerations without any force: change of speed along the vehicle, yaw rate times speed across it. That holds on ice,
too; slope and bank of the road, which kinematics do not show, change slowly.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from tierod.monitors.condition.recording_checks.differences import Bounds, DifferenceCheck, Row
from tierod.monitors.condition.recording_checks.motion import Motion
from tierod.monitors.condition.signals import ACCELERATIONS, CarParameters

MOTION = {"longitudinal_acceleration": "the slope of the wheel speeds", "lateral_acceleration": "yaw rate times speed"}
"""What predicts each acceleration, in words."""
BOUNDS = Bounds(single=3.5, level=1.6, shape=0.7, share=0.35, noise=1.0)
"""Fault-free differences of measured and predicted accelerations [m/s**2].

Fault-free rounds of three virtual demonstrators, ice with adhesion .15 to .3 included, show at most 1.4 in one block,
0.9 in the mean, 0.44 or 0.26 of the motion's own about its mean. A slope of 16 % has the level; sensors have a noise of
.05, rough roads one of some tenths.
"""


class Disagreement(NamedTuple):
    """An acceleration that is inconsistent with the motion; the fields after `element` as in `Difference`."""

    element: str
    sure: bool
    window: Annotated[float, "s"]
    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    magnitude: Annotated[float, "m/s**2"]


class AccelerationCheck:
    """Compare both accelerations with the motion, piece by piece.

    Args:
        vehicle: its parameters
        rate: of the samples [Hz]
        bounds: of fault-free accelerations
    """

    def __init__(self, vehicle: CarParameters, rate: float, bounds: Bounds = BOUNDS):
        self._motion, self._rate = Motion(vehicle, rate), rate
        self._checks = {name: DifferenceCheck(bounds) for name in ACCELERATIONS}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> dict[str, int]:
        """The next piece, and from which of its samples on each acceleration that fails in it is not to be used.

        Args:
            time: [s], (n,)
            signals: by name, (n,) each; NaN where missing
        """
        failed = {}
        for block in self._motion.add(time, signals):
            for place, (name, check) in enumerate(self._checks.items()):
                moved = block.moved[place]
                if check.add(Row(block.end, block.read[place] - moved, moved, block.rough[place])):
                    failed[name] = int(np.searchsorted(time, block.end - 0.5 / self._rate))
        return failed

    def gone(self, name: str) -> bool:
        """Whether an acceleration has failed."""
        return self._checks[name].sure

    @property
    def found(self) -> dict[str, Disagreement]:
        """Those that disagree, by name."""
        return {name: Disagreement(name, *each.found) for name, each in self._checks.items() if each.found is not None}
