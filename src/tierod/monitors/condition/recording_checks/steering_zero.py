"""Zero of the steering angle over a drive: a slow change of it, which filters that learn the zero follow."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from tierod.models.rolling_car import RollingCar
from tierod.monitors.condition.bank.skidding import SLIPPERIEST
from tierod.monitors.condition.recording_checks.differences import Blocks
from tierod.monitors.condition.recording_checks.motion import AGREE
from tierod.monitors.condition.recording_checks.witnesses import YAW, YAW_SENSOR, mean_speed
from tierod.physics.single_track import steady_yaw_gain, understeer_gradient

WINDOW = 60
"""Blocks of half a second of whose zeros the mean is taken: bends to both sides, and wind and road change meanwhile."""
APART = 6
"""Of them, independent zeros: bends and banks last some seconds."""
LEAST = 0.2
"""Change of the zero that is a fault [rad]. Fault-free, a road banked by 4 % needs .02, a flat tyre .1, an understeer
gradient that is half wrong .08 at 2 m/s**2; 34 drives of 21 virtual cars by their brochures (seeds below 100) show at
most .06."""
SLOWEST = 5.0
"""Speed from which on it is looked at [m/s]: below, the angles of manoeuvring are large."""


class ZeroShift(NamedTuple):
    """A change of the zero.

    Args:
        start: when the angle had shifted by half of what it was found by
        found: when it was detected
        value: mean of the last window of the drive less the first one
        deviation: standard deviation of that
    """

    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    value: Annotated[float, "rad"]
    deviation: Annotated[float, "rad"]


class SteeringZero:
    """Compares the zero of the steering angle with that of the drive's beginning, piece by piece.

    Block by block the zero is the angle less that of a steady turn with the measured yaw rate, which the rear wheels
    confirm. Only gentle turns count, with angles that ask for no more than every road gives: there no tyre slides.

    Args:
        vehicle: its parameters
        rate: of the samples [Hz]
    """

    def __init__(self, vehicle: RollingCar.Parameters, rate: float):
        p = self._vehicle = vehicle
        self._blocks = Blocks(rate)
        self._gradient = understeer_gradient(
            p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, p.rear_cornering_stiffness
        )
        self._first: list[float] = []
        self._last: deque[tuple[float, float]] = deque(maxlen=WINDOW)
        self.found: ZeroShift | None = None

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """The next piece.

        Args:
            time: [s], (n,)
            signals: by name, (n,) each; NaN where missing
        """
        cut, ends = self._blocks.add(time, signals)
        if not ends:
            return
        p = self._vehicle
        read = (*(YAW[name].estimate(cut, p) for name in (YAW_SENSOR, "rear wheels")), mean_speed(cut))
        yaw, rolled, speed, angle = (self._blocks.line(each)[0] for each in (*read, cut["steering_wheel_angle"]))
        yaw, rolled = yaw - p.yaw_rate_offset, rolled - p.wheel_speed_difference * speed / p.track_width
        speed = speed / p.wheel_speed_scale
        gain = p.steering_ratio * steady_yaw_gain(speed, p.front_distance + p.rear_distance, max(self._gradient, 0.0))
        with np.errstate(invalid="ignore", divide="ignore"):
            zero = angle - yaw / gain
            gentle = np.maximum(np.abs(speed * yaw), np.abs(speed * gain * angle)) < SLIPPERIEST
            counts = (speed > SLOWEST) & gentle & (np.abs(yaw - rolled) < AGREE) & np.isfinite(zero)
        for end, value in zip(np.array(ends)[counts].tolist(), zero[counts].tolist(), strict=True):
            self._count(end, value)

    def _count(self, end: float, value: float) -> None:
        if len(self._first) < WINDOW:
            self._first.append(value)
            return
        self._last.append((end, value))
        if len(self._last) < WINDOW:
            return
        zeros, usual = np.array([each for _, each in self._last]), float(np.mean(self._first))
        shift = float(np.mean(zeros)) - usual
        deviation = float(np.hypot(np.std(zeros), np.std(self._first)) / np.sqrt(APART))
        if self.found is not None:
            self.found = self.found._replace(value=shift, deviation=deviation)
        elif abs(shift) > LEAST:
            moved = [when for when, each in self._last if (each - usual) / shift > 0.5]
            self.found = ZeroShift(moved[0], end, shift, deviation)
