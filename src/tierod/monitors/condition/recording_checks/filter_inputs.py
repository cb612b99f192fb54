"""Consistency of the inputs of the filters, which no filter estimates: measured accelerations and actuator targets.

A filter with a wrong acceleration as its input declares faults of motors and drives. Kinematics predict both
accelerations without any force: change of speed along the vehicle, yaw rate times speed across it. That holds on ice,
too; slope and bank of the road, which kinematics do not show, change slowly. A wrong target looks like an actuator with
a wrong gain or sign, or like a fault of a sensor beside it: its check names another possible cause of the declared one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.models.automated_forces import drive_force
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.recording_checks.differences import Blocks, Bounds, Difference, DifferenceCheck, Row
from tierod.monitors.condition.recording_checks.motion import Motion
from tierod.monitors.condition.recording_checks.witnesses import MOVING, mean_speed
from tierod.monitors.condition.signals import ACCELERATIONS, TARGETS, CarParameters

MOTION = {"longitudinal_acceleration": "the slope of the wheel speeds", "lateral_acceleration": "yaw rate times speed"}
"""What predicts each acceleration, in words."""
BOUNDS = Bounds(single=3.5, level=1.6, shape=0.7, share=0.35, noise=1.0)
"""Fault-free differences of measured and predicted accelerations [m/s**2].

Fault-free rounds of three virtual demonstrators, ice with adhesion .15 to .3 included, show at most 1.4 in one block,
0.9 in the mean, 0.44 or 0.26 of the motion's own about its mean. A slope of 16 % has the level; sensors have a noise of
.05, rough roads one of some tenths.
"""


ROLL, SLIP_LAG = 0.2, 0.3
"""A body that rolls 7 degrees at 0.6 g adds .2 of the lateral acceleration. The lateral acceleration follows yaw rate
times speed by speed times slip angle of the rear axle per acceleration: 25 m/s with .012 rad per m/s**2, at the most.
"""
ACROSS = replace(BOUNDS, gain=ROLL, lag=SLIP_LAG)


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
        along, across: of fault-free accelerations
    """

    def __init__(self, vehicle: CarParameters, rate: float, along: Bounds = BOUNDS, across: Bounds = ACROSS):
        self._motion, self._rate = Motion(vehicle, rate), rate
        self._checks = {
            name: DifferenceCheck(bounds) for name, bounds in zip(ACCELERATIONS, (along, across), strict=True)
        }

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


STEERING = Bounds(single=4.0, level=0.7, shape=0.7, share=0.15, noise=np.inf)
"""Torque asked of both steering motors less that of the shaft [N*m].

Fault-free rounds of three virtual demonstrators show .1 in the mean, .06 of what the shaft has about it.
"""
DRIVING = Bounds(single=2.5, level=0.9, shape=0.5, share=0.35, noise=np.inf)
"""Acceleration that the asked torque of the drives gives less the one that is read [m/s**2].

The same rounds show .59 in the mean, .24 of what is read about it; ice lets drives give less.
"""


class TargetCheck:
    """Compare the targets with the actuators' responses, piece by piece.

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
