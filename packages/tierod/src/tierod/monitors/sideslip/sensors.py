"""Plausibility of speed, yaw rate, accelerations and steering over a drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Defect
from tierod.io.signs import TurnLimits
from tierod.methods.detectors.rule_design import RuleDesign, alarms_at
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.methods.identification.regression import solved
from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.observables import BlocksOverDrive

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
    """Sums over a recording that test the plausibility of its sensors."""

    def __init__(self, p: SingleTrack.Parameters, rate: float, limits: SensorLimits | None = None):
        self.limits, self._rate, self.offset_rule = limits or SensorLimits(), rate, OFFSET_DESIGN.block()
        self._car = p
        self._standing, self._rolling, self._turning = np.zeros(3), np.zeros(4), np.zeros(6)
        self._steered = np.zeros(2)
        self._readings = self._beyond = 0

    def add(self, speed: np.ndarray, yaw_rate: np.ndarray, acceleration: np.ndarray, angle: np.ndarray) -> None:
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


BLOCK: Annotated[float, "s"] = 1.0
"""Averaging time; below 1 Hz a car follows its steering wheel without delay."""

STEPS = 5
"""Steps per block at which changes of the speed are tested."""


@dataclass(frozen=True)
class MotionLimits:
    """Limits beyond which two measurements of the same motion contradict each other.

    Args:
        contradicts: share of the larger quantity that the other leaves unexplained, mean removed; virtual and real
            cars stay below 0.45, swapped signals above 0.95
        agrees: share up to which the two confirm each other
        lateral: root mean square of the larger one from which turns are compared [m/s^2]
        longitudinal: the same for speed gained in a second [m/s]; hills alone make less
        gentle: largest compared change of speed in a second [m/s]; beyond, wheels slip
        leap: change of the speed within a fifth of a second that no car makes [m/s]
        leaping: share of such changes from which the speed is wrong; locking wheels make 0.02
        seconds: least driving time of the comparisons
        gaining: the same for speed gained; a stop with locking wheels must not decide
        rolling: speed from which turns are used for the offset of the yaw rate [m/s]
        rolling_time: least time of such driving [s]; four terms are estimated, and successive turns err alike
        condition: largest condition number of that regression; at a single speed it is singular
    """

    contradicts: Annotated[float, ""] = 0.75
    agrees: Annotated[float, ""] = 0.4
    lateral: Annotated[float, "m/s**2"] = 0.5
    longitudinal: Annotated[float, "m/s"] = 0.8
    gentle: Annotated[float, "m/s"] = 4.0
    leap: Annotated[float, "m/s"] = 3.5
    leaping: Annotated[float, ""] = 0.05
    seconds: Annotated[float, "s"] = 10.0
    gaining: Annotated[float, "s"] = 30.0
    rolling: Annotated[float, "m/s"] = 3.0
    rolling_time: Annotated[float, "s"] = 60.0
    condition: Annotated[float, ""] = 1e4


class _Pair:
    def __init__(self) -> None:
        self._sums = np.zeros(6)

    def add(self, x: np.ndarray, y: np.ndarray) -> None:
        there = np.isfinite(x) & np.isfinite(y)
        x, y = x[there], y[there]
        self._sums += (len(x), x.sum(), y.sum(), x @ x, y @ y, x @ y)

    def unexplained(self, seconds: float, least: float) -> float:
        """Share of the larger quantity that the other does not explain; NaN with too little driving."""
        count, x, y, xx, yy, xy = self._sums
        if count * BLOCK < seconds:
            return math.nan
        xx, yy, xy = xx - x * x / count, yy - y * y / count, xy - x * y / count
        larger = max(xx, yy)
        return math.sqrt(max(xx + yy - 2.0 * xy, 0.0) / larger) if larger > least * least * count else math.nan


class MotionOverDrive:
    """Sums over a drive in fixed blocks, so that the result does not depend on how the recording is cut."""

    def __init__(self, p: SingleTrack.Parameters, rate: float, limits: MotionLimits | None = None):
        self.limits = limits or MotionLimits()
        self._car = p
        self._blocks = BlocksOverDrive(rate, 5, BLOCK, STEPS)
        self._turn, self._yaw, self._side, self._gain = _Pair(), _Pair(), _Pair(), _Pair()
        self._leaps = self._steps = 0
        self._rolling = np.zeros((5, 5))

    def add(
        self,
        speed: np.ndarray,
        yaw_rate: np.ndarray,
        lateral: np.ndarray,
        longitudinal: np.ndarray,
        angle: np.ndarray,
    ) -> None:
        blocks, changes = self._blocks.add(np.column_stack([speed, yaw_rate, lateral, longitudinal, angle]))
        if not len(blocks):
            return
        gained = changes[:, 0]
        v, r, a, along, d = np.moveaxis(blocks, 2, 0)
        steered = SingleTrack.steady_yaw_gain(v, self._car) * d
        self._turn.add((v * r).mean(axis=1), a.mean(axis=1))
        self._yaw.add((v * r).mean(axis=1), (v * steered).mean(axis=1))
        self._side.add(a.mean(axis=1), (v * steered).mean(axis=1))
        along = BLOCK * along.mean(axis=1)
        gentle = (np.abs(gained) < self.limits.gentle) & (np.abs(along) < self.limits.gentle)
        self._gain.add(gained[gentle], along[gentle])
        self._roll(v, r, a)
        steps = np.abs(np.diff(v[:, :: v.shape[1] // STEPS], axis=1))
        self._steps += int(np.isfinite(steps).sum())
        self._leaps += int((steps > self.limits.leap).sum())

    def _roll(self, v: np.ndarray, r: np.ndarray, a: np.ndarray) -> None:
        rows = np.column_stack([(v * r).mean(axis=1), r.mean(axis=1), v.mean(axis=1), np.ones(len(v)), a.mean(axis=1)])
        rows = rows[np.isfinite(rows).all(axis=1) & (rows[:, 2] > self.limits.rolling)]
        self._rolling += rows.T @ rows

    def yaw_rate_offset(self) -> float:
        """Offset of the yaw rate, reduced by two standard deviations towards zero [rad/s]; 0 without an estimate.

        In a = g v r + c r + o v + k the coefficient o is that of a yaw rate offset -o; an offset of the acceleration or
        bank of the road enters k, an offset of the speed c, roll and gain errors g.
        """
        limits, count = self.limits, self._rolling[3, 3]
        matrix, right, power = self._rolling[:4, :4], self._rolling[:4, 4], self._rolling[4, 4]
        if count * BLOCK < limits.rolling_time:
            return 0.0
        found = solved(matrix, right, power, count, limits.condition)
        if found is None:
            return 0.0
        term, deviation = float(found.values[2]), float(found.deviations[2])
        return -math.copysign(max(abs(term) - 2.0 * deviation, 0.0), term)

    def wrong(self) -> tuple[Defect, ...]:
        """Defects of signals that contradict the motion given by the others."""
        limits = self.limits
        leaps = self._leaps / max(self._steps, 1)
        if self._steps * BLOCK / STEPS >= limits.seconds and leaps > limits.leaping:
            fifth = f"{limits.leap:g} m/s within {BLOCK / STEPS:g} s"
            sentence = f"vehicle_speed jumps by more than {fifth} in {100.0 * leaps:.0f} % of the steps"
            return (Defect(("vehicle_speed",), f"{sentence}, which is impossible"),)
        turn = self._turn.unexplained(limits.seconds, limits.lateral)
        gain = self._gain.unexplained(limits.gaining, limits.longitudinal)
        if turn > limits.contradicts:
            return (self._of_a_turn(gain),)
        if not gain > limits.contradicts:
            return ()
        if turn < limits.agrees:
            sentence = "longitudinal_acceleration contradicts the change of vehicle_speed, which the turns confirm"
            return (Defect(("longitudinal_acceleration",), sentence),)
        names = ("longitudinal_acceleration", "vehicle_speed")
        return (
            Defect(names, "longitudinal_acceleration and vehicle_speed contradict each other: one of them is wrong"),
        )

    def _of_a_turn(self, gain: float) -> Defect:
        limits = self.limits
        yaw = self._yaw.unexplained(limits.seconds, limits.lateral)
        side = self._side.unexplained(limits.seconds, limits.lateral)
        if yaw < limits.agrees and not side < limits.agrees:
            return Defect(
                ("lateral_acceleration",),
                "lateral_acceleration contradicts yaw rate, speed and steering angle, which fit each other",
            )
        if side < limits.agrees and not yaw < limits.agrees:
            return Defect(
                ("yaw_rate",),
                "yaw_rate contradicts lateral acceleration, speed and steering angle, which fit each other",
            )
        if gain > limits.contradicts:
            sentence = (
                "vehicle_speed contradicts yaw rate and lateral acceleration in turns, and longitudinal_acceleration"
            )
            return Defect(("vehicle_speed",), sentence)
        names = ("vehicle_speed", "yaw_rate", "lateral_acceleration")
        return Defect(
            names,
            "vehicle_speed, yaw_rate and lateral_acceleration contradict each other in turns: one of them is wrong",
        )
