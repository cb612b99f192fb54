"""Zero of the steering angle over a drive: detects a slow shift, which filters with the offset as a state absorb."""

from __future__ import annotations

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
LEAST_OF_YAW = 0.1
"""The same for a yaw rate that angle and wheels contradict alike [rad]: wind, bank and understeer act on the angle
alone, a flat tyre on the wheels alone."""
SLOWEST = 5.0
"""Least speed for the estimation of the zero [m/s]; below it the angles of manoeuvring are large."""
SURELY = 3.0
"""Number of standard deviations that exclude the other sensor as the cause [-]."""
SHIFTING = ("steering_wheel_angle", "yaw_rate")
"""Sensors of which either may shift the zero."""


class ZeroShift(NamedTuple):
    """Shift of the zero.

    Args:
        suspects: sensor that contradicts the rear wheels, or both if they cannot isolate it
        start: time at which the zero had shifted by half of the shift
        found: time of the detection
        end: time at which it had shifted back by half; None if it lasts
        value: change of the suspect's mean reading, of the angle if there are two [unit of the reading]
        deviation: standard deviation of that change
    """

    suspects: tuple[str, ...]
    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    end: Annotated[float, "s"] | None
    value: float
    deviation: float


class _Change(NamedTuple):
    """Changes of the zero, of the yaw rate against the wheels, and of the zero by that, with their deviations."""

    suspects: tuple[str, ...]
    value: list[float]
    deviation: list[float]


class SteeringZero:
    """Compares the zero of the steering angle with that at the beginning of the drive.

    The zero of a block is the angle less that of a steady turn with the measured yaw rate. Only gentle turns count, in
    which yaw rate and angle both require less lateral acceleration than every road permits, so that no tyre slides. A
    wrong yaw rate shifts the zero as a wrong angle does. The rear wheels isolate the sensor if the change of
    the yaw rate against them excludes the other one.

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
        self._rows: list[tuple[float, float, float, float]] = []
        self._found, self._most = np.nan, 0.0

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
            zero, apart = angle - yaw / gain, yaw - rolled
            gentle = np.maximum(np.abs(speed * yaw), np.abs(speed * gain * angle)) < SLIPPERIEST
            counts = (speed > SLOWEST) & gentle & (np.abs(apart) < AGREE) & np.isfinite(zero)
        rows = np.column_stack((ends, zero, apart, -apart / np.where(counts, gain, np.nan)))[counts]
        for row in rows.tolist():
            self._rows.append(tuple(row))
            self._follow()

    def _follow(self) -> None:
        """Compare the last window with the first one, once they do not overlap."""
        if len(self._rows) < 2 * WINDOW:
            return
        last = self._changed(slice(len(self._rows) - WINDOW, None))
        shift = last.value[0]
        if np.isnan(self._found) and (
            abs(shift) > LEAST or (abs(shift) > LEAST_OF_YAW and last.suspects == SHIFTING[1:])
        ):
            self._found = self._rows[-1][0]
        self._most = max(self._most, shift, key=abs)

    def _changed(self, inside: slice) -> _Change:
        """Change between the first window and another one."""
        first, last = np.array(self._rows[:WINDOW])[:, 1:], np.array(self._rows[inside])[:, 1:]
        value, deviation = last.mean(axis=0) - first.mean(axis=0), np.hypot(last.std(axis=0), first.std(axis=0))
        deviation /= np.sqrt(APART)
        # Share of the shift that the yaw rate causes by the rear wheels: none if the angle is wrong, else all of it.
        share, doubt = value[2] / value[0], SURELY * deviation[2] / abs(value[0])
        suspects = SHIFTING[:1] if share + doubt < 0.5 else SHIFTING[1:] if share - doubt > 0.5 else SHIFTING
        return _Change(suspects, value.tolist(), deviation.tolist())

    @property
    def found(self) -> ZeroShift | None:
        """Shift beyond the limit; None without one."""
        if np.isnan(self._found):
            return None
        ends, zeros = np.array(self._rows).T[:2]
        moved = (zeros - zeros[:WINDOW].mean()) / self._most > 0.5
        # The stretch with the largest surplus of moved blocks; single ones may be on either side of the half.
        surplus = np.concatenate(([0], np.cumsum(np.where(moved, 1, -1))))
        risen = surplus - np.minimum.accumulate(surplus)
        stop = len(risen) - 1 - int(np.argmax(risen[::-1]))
        first = int(np.argmin(surplus[: stop + 1]))
        change = self._changed(slice(max(first, stop - WINDOW), stop))
        # Blocks of one bend or bank are no end.
        until = float(ends[stop - 1]) if len(moved) - stop > WINDOW // APART else None
        of = int(change.suspects == SHIFTING[1:])
        return ZeroShift(
            change.suspects, float(ends[first]), self._found, until, change.value[of], change.deviation[of]
        )
