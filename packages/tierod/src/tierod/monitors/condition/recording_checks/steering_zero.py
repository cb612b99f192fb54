"""Zero of the steering angle over a drive: detects a slow shift, which filters with the offset as a state absorb."""

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
"""Number of blocks of half a second in a mean zero: long enough for bends to both sides, and for wind and road to
change."""
APART = 6
"""Number of independent zeros among these: bends and banks last some seconds."""
LEAST = 0.2
"""Least shift of the zero that is a fault [rad]. Without a fault, a road bank of 4 % shifts it by .02, a flat tyre by
.1, an understeer gradient with an error of half its value by .08 at 2 m/s**2; 34 drives of 21 virtual cars with
parameters from brochures (seeds below 100) show .06 at most."""
SLOWEST = 5.0
"""Least speed for the estimation of the zero [m/s]; below it the angles of manoeuvring are large."""


class ZeroShift(NamedTuple):
    """Shift of the zero.

    Args:
        start: time at which the zero had shifted by half of the detected shift
        found: time of the detection
        value: mean zero of the last window less that of the first one
        deviation: standard deviation of that difference
    """

    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    value: Annotated[float, "rad"]
    deviation: Annotated[float, "rad"]


class SteeringZero:
    """Compares the zero of the steering angle with that at the beginning of the drive.

    The zero of a block is the angle less that of a steady turn with the measured yaw rate, which the rear wheels must
    confirm. Only gentle turns count, in which yaw rate and angle both require less lateral acceleration than every road
    permits, so that no tyre slides.

    Args:
        vehicle: parameters of the vehicle
        rate: sampling rate [Hz]
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
        """Add the next piece.

        Args:
            time: time stamps [s], (n,)
            signals: signals by name, (n,) each; NaN if missing
        """
        cut, ends = self._blocks.add(time, signals)
        if not ends:
            return
        p = self._vehicle
        read = (*(YAW[name].estimate(cut, p) for name in (YAW_SENSOR, "rear wheels")), mean_speed(cut))
        yaw, rolled, speed, angle = (self._blocks.line(each)[0] for each in (*read, cut["steering_wheel_angle"]))
        yaw, rolled = yaw - p.yaw_rate_offset, rolled - p.wheel_speed_difference * speed / p.track_width
        speed = speed / p.wheel_speed_scale
        # A negative gradient would have a critical speed, at which the gain is infinite.
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
