"""Whether what is asked of the actuators goes with what they do together: it is an input of the filters, and can fail.

A wrong target looks like an actuator that gives too little, too much, or the opposite; a filter may as well blame the
sensors beside it. This check accuses nothing: it says what else may be the cause of what is declared.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tierod.models.automated_forces import drive_force
from tierod.monitors.condition.recording_checks.beside import Beside, Bounds, Difference, Row
from tierod.monitors.condition.recording_checks.blocks import Blocks
from tierod.monitors.condition.recording_checks.coverage import TARGETS
from tierod.monitors.condition.recording_checks.witnesses import MOVING, mean_speed

STEERING = Bounds(single=4.0, level=0.7, shape=0.7, share=0.15, noise=np.inf)
"""Torque asked of both steering motors less that of the shaft [N*m].

Fault-free rounds of three virtual demonstrators show .1 in the mean, .06 of what the shaft has about it.
"""
DRIVING = Bounds(single=2.5, level=0.9, shape=0.5, share=0.35, noise=np.inf)
"""Acceleration that the asked torque of the drives gives less the one that is read [m/s**2].

The same rounds show .59 in the mean, .24 of what is read about it; ice lets drives give less.
"""


class AskedCheck:
    """Follows what is asked beside what is done, piece by piece.

    Args:
        vehicle: parameters of `AutomatedVehicle`
        rate: of the samples [Hz]
    """

    def __init__(self, vehicle: Any, rate: float):
        self._vehicle, self._rate, self._blocks = vehicle, rate, Blocks(rate)
        self._beside = {TARGETS[:2]: Beside(STEERING), TARGETS[2:]: Beside(DRIVING)}
        self._begin: float | None = None

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """The next piece: time [s], signals by name, (n,) each; NaN where missing."""
        begin = self._begin = float(time[0]) if self._begin is None else self._begin
        cut, ends = self._blocks.add(signals)
        if not ends:
            return
        p, speed = self._vehicle, mean_speed(cut) / self._vehicle.wheel_speed_scale
        force = drive_force(cut[TARGETS[2]] + cut[TARGETS[3]], p) - p.rolling_resistance - p.drag * speed * speed
        ways = (
            (cut[TARGETS[0]] + cut[TARGETS[1]], cut["steering_shaft_torque"] - p.steering_shaft_torque_offset),
            (
                force / (p.mass + p.rolling_mass),
                cut["longitudinal_acceleration"] - p.longitudinal_acceleration_offset,
            ),
        )
        moves = self._blocks.line(speed)[0] > MOVING
        for beside, (asked, shown) in zip(self._beside.values(), ways, strict=True):
            told, done = self._blocks.line(asked)[0], self._blocks.line(shown)[0]
            apart = np.where(moves, told - done, np.nan)
            for end, difference, value in zip(ends, apart.tolist(), done.tolist(), strict=True):
                beside.add(Row(begin + end / self._rate, difference, value, 0.0))

    @property
    def found(self) -> dict[tuple[str, ...], Difference]:
        """What is asked and does not go with what is done, by the targets."""
        return {targets: each.found for targets, each in self._beside.items() if each.found is not None and each.sure}
