"""Consistency of the actuators' targets with what the actuators do together: inputs of the filters that can be wrong.

A wrong target looks like an actuator with a wrong gain or sign, or like a fault of a sensor beside it. This check
declares no fault: it names another possible cause of the declared one.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tierod.models.automated_forces import drive_force
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.recording_checks.blocks import Blocks
from tierod.monitors.condition.recording_checks.differences import Bounds, Difference, DifferenceCheck, Row
from tierod.monitors.condition.recording_checks.witnesses import MOVING, mean_speed
from tierod.monitors.condition.signals import TARGETS

STEERING = Bounds(single=4.0, level=0.7, shape=0.7, share=0.15, noise=np.inf)
"""Torque asked of both steering motors less that of the shaft [N*m].

Fault-free rounds of three virtual demonstrators show .1 in the mean, .06 of what the shaft has about it.
"""
DRIVING = Bounds(single=2.5, level=0.9, shape=0.5, share=0.35, noise=np.inf)
"""Acceleration that the asked torque of the drives gives less the one that is read [m/s**2].

The same rounds show .59 in the mean, .24 of what is read about it; ice lets drives give less.
"""


class TargetCheck:
    """Compare the targets with what the actuators do, piece by piece.

    Args:
        vehicle: parameters of `AutomatedVehicle`
        rate: of the samples [Hz]
    """

    def __init__(self, vehicle: AutomatedVehicle.Parameters, rate: float):
        self._vehicle, self._blocks = vehicle, Blocks(rate)
        self._checks = {TARGETS[:2]: DifferenceCheck(STEERING), TARGETS[2:]: DifferenceCheck(DRIVING)}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """The next piece: time [s], signals by name, (n,) each; NaN where missing."""
        cut, ends = self._blocks.add(time, signals)
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
        for check, (asked, shown) in zip(self._checks.values(), ways, strict=True):
            target, done = self._blocks.line(asked)[0], self._blocks.line(shown)[0]
            apart = np.where(moves, target - done, np.nan)
            for end, difference, value in zip(ends, apart.tolist(), done.tolist(), strict=True):
                check.add(Row(end, difference, value, 0.0))

    @property
    def found(self) -> dict[tuple[str, ...], Difference]:
        """Inconsistent pairs of targets."""
        return {targets: each.found for targets, each in self._checks.items() if each.found is not None and each.sure}
