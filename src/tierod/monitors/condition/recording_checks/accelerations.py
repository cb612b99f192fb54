"""Whether the accelerations go with the motion: sensors that the filters take in, that can fail, and that none judges.

A filter that believes a wrong acceleration blames what makes forces, the motors and the drives. The motion tells what
an accelerometer should read without any force: the slope of the speed along, yaw rate times speed across. That holds on
ice as well; slopes and banks of the road, which it does not see, change slowly.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.monitors.condition.recording_checks.beside import Beside, Bounds, Row
from tierod.monitors.condition.recording_checks.motion import Motion
from tierod.monitors.condition.signals import ACCELERATIONS

MOTION = {"longitudinal_acceleration": "the slope of the wheel speeds", "lateral_acceleration": "yaw rate times speed"}
"""What tells each of them, in words."""
BOUNDS = Bounds(single=3.5, level=1.6, shape=0.7, share=0.35, noise=1.0)
"""Of fault-free accelerations beside the motion [m/s**2].

Fault-free rounds of three virtual demonstrators, ice with adhesion .15 to .3 included, show at most 1.4 in one block,
0.9 in the mean, 0.44 or 0.26 of the motion's own about its mean. A slope of 16 % has the level; sensors have a noise of
.05, rough roads one of some tenths.
"""


class Disagreement(NamedTuple):
    """That an acceleration does not go with the motion, see `Difference`; sizes in m/s**2."""

    element: str
    sure: bool
    window: Annotated[float, "s"]
    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    size: Annotated[float, "m/s**2"]


class AccelerationCheck:
    """Follows both accelerations beside the motion, piece by piece, and what has disagreed.

    Args:
        vehicle: its parameters
        rate: of the samples [Hz]
        bounds: of fault-free accelerations
    """

    def __init__(self, vehicle: Any, rate: float, bounds: Bounds = BOUNDS):
        self._motion, self._rate = Motion(vehicle, rate), rate
        self._beside = {name: Beside(bounds) for name in ACCELERATIONS}
        self._begin: float | None = None

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> dict[str, int]:
        """The next piece, and from which of its samples on each acceleration that fails in it is not to be used.

        Args:
            time: [s], (n,)
            signals: by name, (n,) each; NaN where missing
        """
        begin = self._begin = float(time[0]) if self._begin is None else self._begin
        failed = {}
        for block in self._motion.add(signals):
            end = begin + block.end / self._rate
            for place, (name, beside) in enumerate(self._beside.items()):
                moved = block.moved[place]
                if beside.add(Row(end, block.read[place] - moved, moved, block.rough[place])):
                    failed[name] = int(np.searchsorted(time, end - 0.5 / self._rate))
        return failed

    def gone(self, name: str) -> bool:
        """Whether an acceleration has failed."""
        return self._beside[name].sure

    @property
    def found(self) -> dict[str, Disagreement]:
        """Those that disagree, by name."""
        return {name: Disagreement(name, *each.found) for name, each in self._beside.items() if each.found is not None}
