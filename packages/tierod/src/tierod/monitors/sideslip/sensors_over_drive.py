"""Plausibility of speed, yaw rate and lateral acceleration: their units, and an offset of the yaw rate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.io.signs import TurnLimits
from tierod.methods.detectors.rule_design import RuleDesign, alarms_at
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.models.single_track import SingleTrack

USUAL_OFFSET: Annotated[float, "rad/s"] = math.radians(0.12)
"""Standard deviation of a production yaw rate sensor's offset after calibration [rad/s]; 0.12 degrees per second."""

OFFSET_DESIGN = RuleDesign(HoldRule(1), values=1e6, shift=8.0, spacing=math.inf)
"""One decision at the end of a recording."""


@dataclass(frozen=True)
class SensorLimits:
    """Limits beyond which a signal counts as wrong.

    Args:
        standing: speed below which the car stands
        still: spread of the yaw rate up to which it really stands
        unseen: speed up to which sensors of wheel speeds may read zero; they end at 0.3 to 0.8 m/s
        crept: yaw rate by creeping at that speed with the present steering angle, up to which a standing car counts;
            half the smallest offset that is named
        standing_time: least time at standstill for the offset
        rolling: speed above which offset and units are tested while rolling
        rolling_time: least time of such driving
        alike: factor within which lateral acceleration and steering must give the same offset; a bank, or an offset of
            the angle, changes only one of them; where the steering gives less than its inverse, none is reported
        scale: share of the mean yaw rate by which roll, tyres near their limit and a wrong steering ratio may change
            both; in turns to one side this cannot be separated from an offset
        largest: yaw rate that no car reaches
        largest_share: share of the samples above it from which the unit is wrong, rather than a few readings
    """

    standing: Annotated[float, "m/s"] = 0.1
    still: Annotated[float, "rad/s"] = 0.02
    unseen: Annotated[float, "m/s"] = 0.5
    crept: Annotated[float, "rad/s"] = 0.008
    standing_time: Annotated[float, "s"] = 1.0
    rolling: Annotated[float, "m/s"] = 5.0
    rolling_time: Annotated[float, "s"] = 10.0
    alike: Annotated[float, ""] = 2.0
    scale: Annotated[float, ""] = 0.2
    largest: Annotated[float, "rad/s"] = 3.0
    largest_share: Annotated[float, ""] = 0.01


class Offset(NamedTuple):
    """Offset of the yaw rate, and the evidence for it in words."""

    value: Annotated[float, "rad/s"]
    shown_by: str


class SensorsOverDrive:
    """Sums over a recording that test the plausibility of its sensors.

    Args:
        p: parameters of the vehicle, for its yaw rate in a steady turn
        rate: sampling rate [Hz]
        limits: limits beyond which a signal counts as wrong
    """

    def __init__(self, p: SingleTrack.Parameters, rate: float, limits: SensorLimits | None = None):
        self.limits, self._rate, self.offset_rule = limits or SensorLimits(), rate, OFFSET_DESIGN.block()
        self._car = p
        self._standing, self._rolling, self._turning = np.zeros(3), np.zeros(4), np.zeros(6)
        self._steered = np.zeros(2)
        self._readings = self._beyond = 0

    def add(self, speed: np.ndarray, yaw_rate: np.ndarray, acceleration: np.ndarray, angle: np.ndarray) -> None:
        """Add the next piece, (n,) each; NaN where missing.

        Args:
            speed: vehicle speed [m/s]
            yaw_rate: yaw rate [rad/s]
            acceleration: lateral acceleration [m/s**2]
            angle: road wheel angle [rad]
        """
        known = np.isfinite(speed) & np.isfinite(yaw_rate)
        self._readings += int(np.sum(known))
        self._beyond += int(np.sum(np.abs(yaw_rate[known]) > self.limits.largest))
        # Below the resolution of its speed a car creeps unseen, and turns if its wheels are turned.
        creeps = self.limits.unseen * np.abs(np.tan(angle)) / (self._car.front_distance + self._car.rear_distance)
        still = yaw_rate[known & (np.abs(speed) < self.limits.standing) & ~(creeps > self.limits.crept)]
        self._standing += (len(still), still.sum(), still @ still)
        steers = known & (speed > self.limits.rolling) & np.isfinite(angle)
        beside = yaw_rate[steers] - SingleTrack.steady_yaw_gain(speed[steers], self._car) * angle[steers]
        self._steered += (len(beside), beside.sum())
        rolling = known & (speed > self.limits.rolling) & np.isfinite(acceleration)
        v, r, a = speed[rolling], yaw_rate[rolling], acceleration[rolling]
        x = v * r
        self._turning += (len(x), x.sum(), a.sum(), x @ x, a @ a, x @ a)
        steered = np.isfinite(angle[rolling])
        v, r, a, d = v[steered], r[steered], a[steered], angle[rolling][steered]
        gain = SingleTrack.steady_yaw_gain(v, self._car)
        self._rolling += (len(v), np.sum(r - a / v), np.sum(r - gain * d), np.sum(r))

    def offset(self, beside_turns: float = 0.0, beside_wheels: float = 0.0) -> Offset | None:
        """Offset of the yaw rate; None where the data give none of reportable size.

        Args:
            beside_turns: offset from lateral acceleration over speed, see `MotionOverDrive.yaw_rate_offset` [rad/s]
            beside_wheels: offset from the rear wheel speeds, see `ObservablesOverDrive.yaw_rate_offset` [rad/s]
        """
        count, total, squares = self._standing
        if count >= self.limits.standing_time * self._rate:
            mean = total / count
            if math.sqrt(max(squares / count - mean * mean, 0.0)) < self.limits.still:
                return self._worth_naming(mean, "while the car stands")
        if found := self._beside_wheels(beside_wheels):
            return found
        count, beside_acceleration, beside_steering, turned = self._rolling
        rolls = count >= self.limits.rolling_time * self._rate
        one, other = (beside_acceleration / count, beside_steering / count) if rolls else (math.nan, math.nan)
        found = self._worth_naming(beside_turns, "compared with the lateral acceleration at different speeds")
        # A drifting offset of the lateral acceleration looks the same, but then the steering agrees with the yaw rate.
        if found and not abs(other) < abs(found.value) / self.limits.alike:
            return found
        if not rolls:
            return None
        alike = one * other > 0.0 and 1.0 / self.limits.alike < abs(one / other) < self.limits.alike
        smaller = min(one, other, key=abs)
        if abs(smaller) < self.limits.scale * abs(turned / count - smaller):
            return None
        return self._worth_naming(smaller, "compared with both lateral acceleration and steering") if alike else None

    def _beside_wheels(self, offset: float) -> Offset | None:
        """Offset by the rear wheel speeds, which the steering must confirm; None without both."""
        count, beside_steering = self._steered
        if count < self.limits.rolling_time * self._rate or not offset:
            return None
        ratio = beside_steering / count / offset
        if not 1.0 / self.limits.alike < ratio < self.limits.alike:
            return None
        return self._worth_naming(offset, "compared with both rear wheel speeds and steering")

    def _worth_naming(self, value: float, shown_by: str) -> Offset | None:
        named = alarms_at(self.offset_rule, float(value) / USUAL_OFFSET)
        return Offset(float(value), shown_by) if named else None

    def wrong_unit(self) -> str | None:
        """Sentence on a signal whose unit cannot be right; None where all can."""
        if self._beyond > self.limits.largest_share * max(self._readings, 1):
            return f"the yaw rate is beyond {self.limits.largest:g} rad/s, as if it were in degrees per second"
        count, x, a, xx, aa, xa = self._turning
        if count < self.limits.rolling_time * self._rate:
            return None
        power, measured, common = xx - x * x / count, aa - a * a / count, xa - x * a / count
        turns = TurnLimits()
        least = turns.acceleration**2 * count
        if max(power, measured) < least or min(power, measured) <= 0.0:
            return None
        ratio = math.sqrt(measured / power)
        together = common / math.sqrt(power * measured) >= turns.correlation
        if not together or 1.0 / turns.deviation < ratio < turns.deviation:
            return None
        return f"the lateral acceleration is {ratio:.2g} times the product of speed and yaw rate; about 1 is expected"
