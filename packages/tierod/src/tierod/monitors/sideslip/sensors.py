"""Plausibility of speed, yaw rate, accelerations and steering over a drive: signs, units, offset, one motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.facts import Fact, defect
from tierod.io.signs import TurnLimits, turn_ratio
from tierod.methods.detectors.rule_design import RuleDesign, alarms_at
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod.methods.identification.experiment import solved
from tierod.methods.relations import odd_ones_out
from tierod.methods.running import Moments
from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.observables import BlocksOverDrive

# Signals with the same sign in a steady turn.
TOGETHER = ("steering angle", "yaw rate", "lateral acceleration", "steering torque")
# Standard deviation of a production yaw rate sensor's offset after calibration [rad/s]; 0.12 degrees per second.
USUAL_OFFSET: Annotated[float, "rad/s"] = math.radians(0.12)
# One decision at the end of a recording.
OFFSET_DESIGN = RuleDesign(HoldRule(1), values=1e6, shift=8.0, spacing=math.inf)
BLOCK: Annotated[float, "s"] = 1.0  # averaging time; below 1 Hz a car follows its steering wheel without delay
STEPS = 5  # steps per block at which changes of the speed are tested


@dataclass(frozen=True)
class SensorLimits:
    """Limits beyond which a signal counts as wrong."""

    # Speed above which signs are compared; below, torque and lateral acceleration are uninformative.
    turning: Annotated[float, "m/s"] = 3.0
    # Correlation from which two signals agree or disagree in sign; slow turns give above 0.9.
    clear: Annotated[float, ""] = 0.5
    fewest: int = 300  # least number of samples of a correlation
    standing: Annotated[float, "m/s"] = 0.1  # speed below which the car stands
    still: Annotated[float, "rad/s"] = 0.02  # spread of the yaw rate up to which it really stands
    # Speed up to which sensors of wheel speeds may read zero; they end at 0.3 to 0.8 m/s.
    unseen: Annotated[float, "m/s"] = 0.5
    # Yaw rate by creeping at that speed with the present steering angle, up to which a standing car counts; half the
    # smallest offset that is named.
    crept: Annotated[float, "rad/s"] = 0.008
    standing_time: Annotated[float, "s"] = 1.0  # least time at standstill for the offset
    rolling: Annotated[float, "m/s"] = 5.0  # speed above which offset and units are tested while rolling
    rolling_time: Annotated[float, "s"] = 10.0  # least time of such driving
    # Factor within which lateral acceleration and steering must give the same offset; a bank, or an offset of the
    # angle, changes only one of them; where the steering gives less than its inverse, none is reported.
    alike: Annotated[float, ""] = 2.0
    # Share of the mean yaw rate by which roll, tyres near their limit and a wrong steering ratio may change both; in
    # turns to one side this cannot be separated from an offset.
    scale: Annotated[float, ""] = 0.2
    largest: Annotated[float, "rad/s"] = 3.0  # yaw rate that no car reaches
    # Share of the samples above it from which the unit is wrong, rather than a few readings.
    largest_share: Annotated[float, ""] = 0.01
    # Share of the larger of two quantities that the other leaves unexplained, mean removed, from which they contradict
    # each other; virtual and real cars stay below 0.45, swapped signals above 0.95.
    contradicts: Annotated[float, ""] = 0.75
    agrees: Annotated[float, ""] = 0.4  # share up to which the two confirm each other
    lateral: Annotated[float, "m/s**2"] = 0.5  # root mean square of the larger one from which turns are compared
    longitudinal: Annotated[float, "m/s"] = 0.8  # the same for speed gained in a second; hills alone make less
    gentle: Annotated[float, "m/s"] = 4.0  # largest compared change of speed in a second; beyond, wheels slip
    leap: Annotated[float, "m/s"] = 3.5  # change of the speed within a fifth of a second that no car makes
    # Share of such changes from which the speed is wrong; locking wheels make 0.02.
    leaping: Annotated[float, ""] = 0.05
    comparing_time: Annotated[float, "s"] = 10.0  # least driving time of the comparisons
    gaining_time: Annotated[float, "s"] = 30.0  # the same for speed gained; a stop with locking wheels must not decide
    # Least time above `turning` for the regression of the lateral acceleration; four terms are estimated, and
    # successive turns err alike.
    regressed_time: Annotated[float, "s"] = 60.0
    # Largest condition number of that regression; at a single speed it is singular.
    condition: Annotated[float, ""] = 1e4


class Offset(NamedTuple):
    """Offset of the yaw rate, and the evidence for it in words."""

    value: Annotated[float, "rad/s"]
    shown_by: str


def _unexplained(pair: Moments, seconds: float, least: float) -> float:
    """Share of the larger of two quantities that the other does not explain; NaN with too little driving."""
    first, second = np.diag(pair.products)
    larger = max(first, second)
    if pair.count * BLOCK < seconds or not larger > least * least * pair.count:
        return math.nan
    return math.sqrt(max(first + second - 2.0 * float(pair.products[0, 1]), 0.0) / larger)


class SensorsOverDrive:
    """Sums over a drive that test the plausibility of its sensors; the result does not depend on how it is cut.

    Args:
        p: parameters of the vehicle, for its yaw rate in a steady turn
    """

    def __init__(self, p: SingleTrack.Parameters, rate: float):
        self.limits, self._rate, self._car = SensorLimits(), rate, p
        self.offset_rule = OFFSET_DESIGN.block()
        # Products and squares of the signals of TOGETHER, and numbers of common samples, by pairs.
        self._products, self._squares, self._common = np.zeros((3, len(TOGETHER), len(TOGETHER)))
        self._standing, self._rolling, self._steered = (np.zeros(n) for n in (3, 4, 2))
        self._readings = self._beyond = self._leaps = self._steps = 0
        self._blocks = BlocksOverDrive(rate, 5, BLOCK, STEPS)
        self._turning, self._turn, self._yaw, self._side, self._gain = (Moments() for _ in range(5))
        self._regressed = np.zeros((5, 5))

    def add(
        self,
        speed: np.ndarray,
        yaw_rate: np.ndarray,
        lateral: np.ndarray,
        longitudinal: np.ndarray,
        angle: np.ndarray,
        torque: np.ndarray,
    ) -> None:
        """Add the next piece, (n,) each; NaN where missing; the angle is that of the road wheels."""
        turns = speed > self.limits.turning
        rows = np.column_stack([angle, yaw_rate, lateral, torque])[turns]
        there = np.isfinite(rows)
        rows = np.where(there, rows, 0.0)
        self._products += rows.T @ rows
        self._squares += (rows**2).T @ there
        self._common += there.T.astype(float) @ there
        self._add_samples(speed, yaw_rate, lateral, angle)
        self._add_blocks(np.column_stack([speed, yaw_rate, lateral, longitudinal, angle]))

    def _add_samples(self, speed: np.ndarray, yaw_rate: np.ndarray, lateral: np.ndarray, angle: np.ndarray) -> None:
        limits = self.limits
        known = np.isfinite(speed) & np.isfinite(yaw_rate)
        self._readings += int(np.sum(known))
        self._beyond += int(np.sum(np.abs(yaw_rate[known]) > limits.largest))
        # Below the resolution of its speed a car creeps unseen, and turns if its wheels are turned.
        creeps = limits.unseen * np.abs(np.tan(angle)) / (self._car.front_distance + self._car.rear_distance)
        still = yaw_rate[known & (np.abs(speed) < limits.standing) & ~(creeps > limits.crept)]
        self._standing += (len(still), still.sum(), still @ still)
        rolling = known & (speed > limits.rolling)
        v, r, a, d = (each[rolling] for each in (speed, yaw_rate, lateral, angle))
        beside = r - SingleTrack.steady_yaw_gain(v, self._car) * d
        steers, accelerates = np.isfinite(d), np.isfinite(a)
        self._steered += (steers.sum(), beside[steers].sum())
        self._turning.add(v * r, a)
        both = steers & accelerates
        self._rolling += (both.sum(), np.sum((r - a / v)[both]), np.sum(beside[both]), np.sum(r[both]))

    def _add_blocks(self, rows: np.ndarray) -> None:
        limits = self.limits
        blocks, changes = self._blocks.add(rows)
        if not len(blocks):
            return
        v, r, a, along, d = np.moveaxis(blocks, 2, 0)
        turn, across, steered = (v * r).mean(axis=1), a.mean(axis=1), v * SingleTrack.steady_yaw_gain(v, self._car) * d
        self._turn.add(turn, across)
        self._yaw.add(turn, steered.mean(axis=1))
        self._side.add(across, steered.mean(axis=1))
        gained, integral = changes[:, 0], BLOCK * along.mean(axis=1)
        gentle = (np.abs(gained) < limits.gentle) & (np.abs(integral) < limits.gentle)
        self._gain.add(gained[gentle], integral[gentle])
        terms = np.column_stack([turn, r.mean(axis=1), v.mean(axis=1), np.ones(len(v)), across])
        terms = terms[np.isfinite(terms).all(axis=1) & (terms[:, 2] > limits.turning)]
        self._regressed += terms.T @ terms
        steps = np.abs(np.diff(v[:, :: v.shape[1] // STEPS], axis=1))
        self._steps += int(np.isfinite(steps).sum())
        self._leaps += int((steps > limits.leap).sum())

    def agreements(self) -> dict[tuple[str, str], float]:
        """Correlation about zero, -1 to 1, of every pair of `TOGETHER` with enough samples."""
        found = {}
        for (i, one), (j, other) in combinations(enumerate(TOGETHER), 2):
            size = np.sqrt(self._squares[i, j] * self._squares[j, i])
            if self._common[i, j] >= self.limits.fewest and size > 0.0:
                found[one, other] = float(self._products[i, j] / size)
        return found

    def turned(self) -> tuple[str, ...]:
        """The signal of `TOGETHER` whose sign contradicts the others; several where they cannot be separated."""
        clear = {pair: value > 0.0 for pair, value in self.agreements().items() if abs(value) > self.limits.clear}
        return odd_ones_out(TOGETHER, clear)

    def wrong_unit(self) -> str | None:
        """Sentence on a signal whose unit cannot be right; None where all can."""
        if self._beyond > self.limits.largest_share * max(self._readings, 1):
            return f"the yaw rate is beyond {self.limits.largest:g} rad/s, as if it were in degrees per second"
        turns = TurnLimits()
        ratio = turn_ratio(self._turning, turns)
        if ratio is None or self._turning.count < self.limits.rolling_time * self._rate:
            return None
        if 1.0 / turns.deviation < ratio < turns.deviation:
            return None
        return f"the lateral acceleration is {ratio:.2g} times the product of speed and yaw rate; about 1 is expected"

    def offset(self, beside_wheels: float = 0.0) -> Offset | None:
        """Offset of the yaw rate; None where the data give none of reportable size.

        Args:
            beside_wheels: offset from the rear wheel speeds, see `ObservablesOverDrive.yaw_rate_offset` [rad/s]
        """
        limits = self.limits
        count, total, squares = self._standing
        if count >= limits.standing_time * self._rate:
            mean = total / count
            if math.sqrt(max(squares / count - mean * mean, 0.0)) < limits.still:
                return self._worth_naming(mean, "while the car stands")
        if found := self._beside_wheels(beside_wheels):
            return found
        count, beside_acceleration, beside_steering, turned = self._rolling
        rolls = count >= limits.rolling_time * self._rate
        one, other = (beside_acceleration / count, beside_steering / count) if rolls else (math.nan, math.nan)
        found = self._worth_naming(self.beside_turns(), "compared with the lateral acceleration at different speeds")
        # A drifting offset of the lateral acceleration looks the same, but then the steering agrees with the yaw rate.
        if found and not abs(other) < abs(found.value) / limits.alike:
            return found
        if not rolls:
            return None
        alike = one * other > 0.0 and 1.0 / limits.alike < abs(one / other) < limits.alike
        smaller = min(one, other, key=abs)
        if not alike or abs(smaller) < limits.scale * abs(turned / count - smaller):
            return None
        return self._worth_naming(smaller, "compared with both lateral acceleration and steering")

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

    def beside_turns(self) -> float:
        """Offset by the lateral acceleration, reduced by two deviations towards zero [rad/s]; 0 without an estimate.

        In a = g v r + c r + o v + k the coefficient o is that of a yaw rate offset -o; an offset of the acceleration or
        bank of the road enters k, an offset of the speed c, roll and gain errors g.
        """
        sums, count = self._regressed, self._regressed[3, 3]
        if count * BLOCK < self.limits.regressed_time:
            return 0.0
        found = solved(sums[:4, :4], sums[:4, 4], sums[4, 4], count, self.limits.condition)
        if found is None:
            return 0.0
        term, deviation = float(found.values[2]), float(found.deviations[2])
        return -math.copysign(max(abs(term) - 2.0 * deviation, 0.0), term)

    def wrong_motion(self) -> Fact | None:
        """The signal that contradicts the motion given by the others; several where they cannot be separated."""
        limits = self.limits
        leaps = self._leaps / max(self._steps, 1)
        if self._steps * BLOCK / STEPS >= limits.comparing_time and leaps > limits.leaping:
            fifth = f"{limits.leap:g} m/s within {BLOCK / STEPS:g} s"
            sentence = f"vehicle_speed jumps by more than {fifth} in {100.0 * leaps:.0f} % of the steps"
            return defect(("vehicle_speed",), f"{sentence}, which is impossible")
        turn = _unexplained(self._turn, limits.comparing_time, limits.lateral)
        gain = _unexplained(self._gain, limits.gaining_time, limits.longitudinal)
        if turn > limits.contradicts:
            return self._wrong_turn(gain > limits.contradicts)
        if not gain > limits.contradicts:
            return None
        if turn < limits.agrees:
            sentence = "longitudinal_acceleration contradicts the change of vehicle_speed, which the turns confirm"
            return defect(("longitudinal_acceleration",), sentence)
        names = ("longitudinal_acceleration", "vehicle_speed")
        return defect(names, f"{' and '.join(names)} contradict each other: one of them is wrong")

    def _wrong_turn(self, gains_otherwise: bool) -> Fact:
        """The one of speed, yaw rate and lateral acceleration that contradicts the steering and the other two."""
        limits = self.limits
        fit = [
            _unexplained(each, limits.comparing_time, limits.lateral) < limits.agrees
            for each in (self._yaw, self._side)
        ]
        for name, other, fits in (
            ("lateral_acceleration", "yaw rate", fit[0] and not fit[1]),
            ("yaw_rate", "lateral acceleration", fit[1] and not fit[0]),
        ):
            if fits:
                return defect((name,), f"{name} contradicts {other}, speed and steering angle, which fit each other")
        if gains_otherwise:
            sentence = "contradicts yaw rate and lateral acceleration in turns, and longitudinal_acceleration"
            return defect(("vehicle_speed",), f"vehicle_speed {sentence}")
        names = ("vehicle_speed", "yaw_rate", "lateral_acceleration")
        sentence = "vehicle_speed, yaw_rate and lateral_acceleration contradict each other in turns"
        return defect(names, f"{sentence}: one of them is wrong")
