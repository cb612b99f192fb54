"""Consistency of inputs of the filters for which there is no hypothesis: measured accelerations and actuator targets.

With a wrong acceleration the filters declare faults of motors and drives. Kinematics predict both accelerations without
any force: the change of speed along the vehicle, and yaw rate times speed across it. This also holds on ice; grade and
bank of the road, which kinematics do not include, change slowly. A wrong target looks like an actuator with a wrong
gain or sign, or like a fault of a related sensor: the check names it as another possible cause of a declared fault.
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

MOTION = {
    "longitudinal_acceleration": "the derivative of the wheel speeds",
    "lateral_acceleration": "yaw rate times speed",
}
"""Prediction of each acceleration, in words."""
BOUNDS = Bounds(single=3.5, level=1.6, shape=0.7, share=0.35, noise=1.0)
"""Fault-free differences of measured and predicted accelerations [m/s**2].

Fault-free rounds of three virtual demonstrators, ice with adhesion .15 to .3 included, show at most 1.4 in one block,
0.9 in the mean, and a standard deviation of 0.44, or of 0.26 of that of the motion. A grade of 16 % reaches the level;
sensors have a noise of .05, rough roads of some tenths.
"""


ROLL, SLIP_LAG = 0.2, 0.3
"""Fault-free gain [-] and lag [s] of the lateral acceleration: a body that rolls by 7 degrees at 0.6 g adds a share of
.2; the lag behind yaw rate times speed is speed times rear slip angle per acceleration, at most 25 m/s with .012 rad
per m/s**2.
"""
ACROSS = replace(BOUNDS, gain=ROLL, lag=SLIP_LAG)
"""Fault-free differences of the lateral acceleration [m/s**2]."""


LATEST, SURELY = 0.06, 3.0
"""Delay of the longitudinal acceleration behind the wheels from which it is late [s], and number of standard deviations
by which it must exceed that. Of fault-free rounds of virtual demonstrators (seeds 142 and 201 to 203) the lower bounds
are .01 to .03 s, of the same .1 s late .10 to .13 s."""
ENOUGH = 20
"""Least number of blocks of half a second for an estimate of the delay."""


class Disagreement(NamedTuple):
    """Acceleration that is inconsistent with the motion; the fields after `element` are those of `Difference`."""

    element: str
    sure: bool
    window: Annotated[float, "s"]
    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    magnitude: Annotated[float, "m/s**2"]


class AccelerationCheck:
    """Compare both measured accelerations with the motion, piece by piece.

    Args:
        vehicle: parameters of the vehicle
        rate: sampling rate [Hz]
        along, across: bounds for the longitudinal and the lateral acceleration
    """

    def __init__(self, vehicle: CarParameters, rate: float, along: Bounds = BOUNDS, across: Bounds = ACROSS):
        self._motion, self._rate = Motion(vehicle, rate), rate
        self._checks = {
            name: DifferenceCheck(bounds) for name, bounds in zip(ACCELERATIONS, (along, across), strict=True)
        }
        # Sums of products of growth, reading, 1, and difference from the wheels, of all blocks.
        self._sums = np.zeros((4, 4))

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Add the next piece; returns, for each acceleration that fails in it, the first sample without it.

        Args:
            time: time stamps [s], (n,)
            signals: signals by name, (n,) each; NaN if missing
        """
        failed = {}
        for block in self._motion.add(time, signals):
            row = np.array([-block.growth, block.read[0], 1.0, block.read[0] - block.rolled])
            if np.isfinite(row).all() and block.speed > MOVING:
                self._sums += np.outer(row, row)
            for place, (name, check) in enumerate(self._checks.items()):
                moved = block.moved[place]
                if check.add(Row(block.end, block.read[place] - moved, moved, block.rough[place])):
                    failed[name] = int(np.searchsorted(time, block.end - 0.5 / self._rate))
        return failed

    def gone(self, name: str) -> bool:
        """Whether an acceleration has failed."""
        return self._checks[name].sure

    @property
    def late(self) -> float | None:
        """Delay of the longitudinal acceleration behind the wheels [s], by least squares; None if it is not late.

        The tyres' slip adds a share of the acceleration to the difference, and grade a constant.
        """
        squares, products, count = self._sums[:3, :3], self._sums[:3, 3], self._sums[2, 2]
        if count < ENOUGH or np.linalg.matrix_rank(squares) < len(squares):
            return None
        inverse = np.linalg.inv(squares)
        shares = inverse @ products
        variance = max(float(self._sums[3, 3] - shares @ products), 0.0) / (count - len(squares))
        least = float(shares[0] - SURELY * np.sqrt(inverse[0, 0] * variance))
        return float(shares[0]) if least > LATEST else None

    @property
    def found(self) -> dict[str, Disagreement]:
        """Inconsistent accelerations, sure or doubtful, by name."""
        return {name: Disagreement(name, *each.found) for name, each in self._checks.items() if each.found is not None}


STEERING = Bounds(single=4.0, level=0.7, shape=0.7, share=0.15, noise=np.inf)
"""Fault-free difference between the target torque of both steering motors and the torque of the shaft [N*m].

Fault-free rounds of three virtual demonstrators show .1 in the mean, and a standard deviation of .06 of the shaft's.
"""
DRIVING = Bounds(single=2.5, level=0.9, shape=0.5, share=0.35, noise=np.inf)
"""Fault-free difference between the acceleration by the targets of the drives and the measured one [m/s**2].

The same rounds show .59 in the mean, and a standard deviation of .24 of the measured one; on ice drives give less.
"""


class TargetCheck:
    """Compare the targets with the actuators' responses, piece by piece.

    Args:
        vehicle: parameters of `AutomatedVehicle`
        rate: sampling rate [Hz]
    """

    def __init__(self, vehicle: AutomatedVehicle.Parameters, rate: float):
        self._vehicle, self._blocks = vehicle, Blocks(rate)
        self._checks = {TARGETS[:2]: DifferenceCheck(STEERING), TARGETS[2:]: DifferenceCheck(DRIVING)}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """Add the next piece: time [s], signals by name, (n,) each; NaN if missing."""
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
        """Differences of the inconsistent pairs of targets, by names of the pair."""
        return {targets: each.found for targets, each in self._checks.items() if each.found is not None and each.sure}
