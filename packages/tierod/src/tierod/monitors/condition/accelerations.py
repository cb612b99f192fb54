"""Consistency of inputs of the filters for which there is no hypothesis: measured accelerations and actuator targets.

With a wrong acceleration the filters declare faults of motors and drives. Kinematics predict both accelerations without
any force: the change of speed along the vehicle, and yaw rate times speed across it. This also holds on ice; grade and
bank of the road, which kinematics do not include, change slowly. A wrong target looks like an actuator with a wrong
gain or sign, or like a fault of a related sensor: the check names it as another possible cause of a declared fault.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, sqrt
from typing import Annotated, NamedTuple

import numpy as np

from tierod.methods import running
from tierod.models.automated_vehicle import AutomatedVehicle, drive_force
from tierod.monitors.condition.signals import ACCELERATIONS, FRONT_WHEELS, TARGETS, WHEELS, CarParameters
from tierod.monitors.condition.wiring import MOVING, YAW, mean_speed

BLOCK = 0.5
"""Length of a block, over which signals are averaged [s]; the noise of a wheel speed is .02 m/s**2 in its slope."""
LEAST_READ = 0.15
"""Least share of the samples of a block that a signal must have [-]; wheel speeds come at 20 Hz on slow buses."""


class Blocks:
    """Cuts the signals of a drive into blocks of equal length."""

    def __init__(self, rate: float):
        self.rate, self.width = rate, max(round(BLOCK * rate), 2)
        self._blocks: running.Blocks | None = None

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], list[float]]:
        """Signals in the blocks that the next samples complete, (blocks, samples) each, and the ends of the blocks."""
        self._blocks = self._blocks or running.Blocks(self.width, 1 + len(signals))
        times, *cut = np.moveaxis(self._blocks.add(np.column_stack((time, *signals.values()))), 2, 0)
        return dict(zip(signals, cut, strict=True)), (times[:, -1] + 1.0 / self.rate).tolist()

    def line(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and slope per second of a regression line in every block, (blocks,) each; NaN with too few samples."""
        there = np.isfinite(values)
        weight = there.astype(float)
        count = weight.sum(axis=1)
        time = (np.arange(self.width) - 0.5 * (self.width - 1)) / self.rate
        known, safe = np.where(there, values, 0.0), np.maximum(count, 1.0)
        mean, middle = known.sum(axis=1) / safe, (weight * time).sum(axis=1) / safe
        apart = (time - middle[:, None]) * weight
        spread = (apart * time).sum(axis=1)
        slope = (apart * known).sum(axis=1) / np.where(spread > 0.0, spread, 1.0)
        enough = (count >= max(LEAST_READ * self.width, 3.0)) & (spread > 0.0)
        return np.where(enough, mean - slope * middle, np.nan), np.where(enough, slope, np.nan)


def roughness(values: np.ndarray) -> np.ndarray:
    """Standard deviation of white noise in every block, from differences of consecutive samples; NaN with too few."""
    steps = np.diff(values, axis=1)
    there = np.isfinite(steps)
    count = there.sum(axis=1)
    squares = np.where(there, steps * steps, 0.0).sum(axis=1)
    return np.where(count >= 3, np.sqrt(0.5 * squares / np.maximum(count, 1)), np.nan)


LEVEL_TIME, SHAPE_TIME = 3.0, 10.0  # windows for the mean and for the standard deviation of a difference [s]
SWEEPS = 8  # iterations of the coordinate descent for gain and lag; the quadratic form in a box has a single minimum
HALF = 0.7  # least share of the blocks of a window in which both estimates must exist [-]


@dataclass(frozen=True)
class Bounds:
    """Bounds of the fault-free difference of two estimates of a quantity [unit of the quantity]."""

    single: float  # bound of the difference in one block
    level: float  # bound of its mean over `LEVEL_TIME`, after subtraction of the fault-free gain
    shape: float  # bound of its standard deviation over `SHAPE_TIME`, after subtraction of fault-free gain and lag
    # alternative bound of that, as a share of the standard deviation of the quantity [-]; the larger applies
    share: Annotated[float, ""]
    noise: float  # bound of the white noise of the reading, in the mean over `LEVEL_TIME`
    doubtful: Annotated[float, ""] = 0.7  # share of these bounds from which a difference is doubtful [-]
    # largest fault-free part of the difference that is proportional to the quantity, as a share of it [-]
    gain: Annotated[float, ""] = 0.0
    lag: Annotated[float, "s"] = 0.0  # largest fault-free delay of the reading behind the quantity


class Row(NamedTuple):
    """One block: its end [s], difference of the estimates, reference quantity, and noise of the reading."""

    end: float
    apart: float
    reference: float
    noise: float


class Difference(NamedTuple):
    """Difference beyond its bounds."""

    sure: bool  # whether it exceeds a bound; otherwise only the doubtful share of one
    window: Annotated[float, "s"]  # start of the window in which it was detected [s]
    start: Annotated[float, "s"]  # time at which the difference reached that magnitude, to half a second [s]
    found: Annotated[float, "s"]  # time of the detection [s]
    magnitude: float  # single difference, mean, standard deviation or noise
    still: bool  # whether the reading has had no noise since the start, as one that stays the same


class DifferenceCheck:
    """Compare a difference with its bounds; keep the first one that is sure, or else the first doubtful one."""

    def __init__(self, bounds: Bounds):
        self._bounds = bounds
        self._rows: deque[Row] = deque(maxlen=round(SHAPE_TIME / BLOCK))
        self._noisy = 0.0  # end of the last block in which the reading had noise [s]
        self.found: Difference | None = None

    @property
    def sure(self) -> bool:
        return self.found is not None and self.found.sure

    def add(self, row: Row) -> bool:
        """Add the next block; returns whether the difference exceeds a bound now for the first time."""
        if self.sure:
            return False
        self._rows.append(row)
        if row.noise != 0.0:
            self._noisy = row.end
        if not isfinite(row.apart):
            return False
        measures = self._measures()
        sure = next((each for each in measures if each[1] > each[2]), None)
        hit = sure or next((each for each in measures[1:] if each[1] > self._bounds.doubtful * each[2]), None)
        if hit is not None and (sure or self.found is None):
            begin, magnitude, _ = hit
            much = (row.end for row in self._rows if row.end > begin and max(abs(row.apart), row.noise) >= magnitude)
            start = next(much, begin + BLOCK) - BLOCK
            still = self._noisy <= start + 0.5 * BLOCK
            self.found = Difference(
                sure is not None, begin, min(start, self._noisy) if still else start, row.end, magnitude, still
            )
        return sure is not None

    def _measures(self) -> list[tuple[float, float, float]]:
        """Start of the window [s], magnitude and bound of the last block, of mean, noise and standard deviation.

        The first of these cannot be doubtful.
        """
        bounds, last = self._bounds, self._rows[-1]
        found = [(last.end - BLOCK, abs(last.apart), bounds.single)]
        short = round(LEVEL_TIME / BLOCK)
        known = [each for each in self._rows if isfinite(each.apart)]
        recent = [each for each in known if each.end > last.end - LEVEL_TIME - 0.5 * BLOCK][-short:]
        if len(recent) >= HALF * short:
            begin, count = recent[0].end - BLOCK, len(recent)
            apart, most = sum(each.apart for each in recent), bounds.gain * sum(each.reference for each in recent)
            # Subtract what a gain between 0 and its bound explains; `most` has the sign of the reference.
            beyond = apart - min(max(apart, min(most, 0.0)), max(most, 0.0))
            found.append((begin, abs(beyond) / count, bounds.level))
            found.append((begin, sum(each.noise for each in recent) / count, bounds.noise))
        if len(known) >= HALF * SHAPE_TIME / BLOCK:
            bound = max(bounds.shape, bounds.share * _deviation([each.reference for each in known]))
            found.append((known[0].end - BLOCK, _unexplained(known, bounds.gain, bounds.lag), bound))
        return found


def _deviation(values: Sequence[float]) -> float:
    """Standard deviation of few values, for which an array would be slower."""
    mean = sum(values) / len(values)
    return sqrt(sum((each - mean) ** 2 for each in values) / len(values))


def _unexplained(rows: Sequence[Row], gain: float, lag: float) -> float:
    """Standard deviation of the difference without the part that a fault-free gain and lag explain.

    Least squares of apart = a reference - b d(reference)/dt with 0 <= a <= gain and 0 <= b <= lag.
    """
    apart = np.array([each.apart for each in rows])
    motion = np.array([each.reference for each in rows])
    columns = np.array([motion, -np.gradient(motion, [each.end for each in rows])])
    columns -= columns.mean(axis=1, keepdims=True)
    squares, products = columns @ columns.T, columns @ apart
    most, share = np.array([gain, lag]), np.zeros(2)
    for _ in range(SWEEPS):
        for place in (0, 1):
            left = products[place] - squares[place] @ share + squares[place, place] * share[place]
            if squares[place, place] > 0.0:
                share[place] = min(max(left / squares[place, place], 0.0), most[place])
    return float(np.std(apart - share @ columns))


SENSED = ("yaw rate sensor", "rear wheels", "steering angle")
"""Witnesses of the yaw rate that use no acceleration, the most accurate first."""
AGREE, AGREE_SHARE = 0.06, 0.15
"""Largest difference of consistent yaw rates: absolute [rad/s] plus relative [-]; turning in causes as much."""
SLIP = 0.03
"""Largest slip of an axle over the acceleration [s**2/m]: .3 in an emergency stop at 10 m/s**2, the most that anti-lock
brakes allow. Without brakes the axle that is not driven has none."""
WHEELS_AGREE = 0.05
"""Largest relative difference of consistent rear wheel speeds, referred to the middle of the axle [-]."""


class Motion(NamedTuple):
    """Means of blocks of time; NaN where an input is missing, or the witnesses of the motion are inconsistent."""

    read: np.ndarray  # measured `ACCELERATIONS` without their known offsets [m/s**2], (2, blocks)
    moved: np.ndarray  # accelerations predicted from the motion [m/s**2], (2, blocks)
    rough: np.ndarray  # standard deviation of the white noise of the measured ones [m/s**2], (2, blocks)
    speed: np.ndarray  # speed of the vehicle [m/s]
    rolled: np.ndarray  # longitudinal acceleration by the rear wheels alone [m/s**2]
    growth: np.ndarray  # slope of the measured longitudinal acceleration [m/s**3]


def motion_of(cut: Mapping[str, np.ndarray], blocks: Blocks, vehicle: CarParameters) -> Motion:
    """Accelerations predicted from signals in blocks, (blocks, samples) each.

    Along the vehicle the change of speed is used, across it yaw rate times speed. Two of three yaw rates must agree, so
    that one faulty sensor does not matter; if the two wheels disagree, neither is used. Axles slip, and when tyres
    slide, rear wheels and steering angle have similar errors: both accelerations are therefore predicted as close to
    the measured ones as the range of the axles, with and without slip, and that of the yaw rates permit.
    """
    p, line = vehicle, blocks.line
    yaws, slopes = (np.array(each) for each in zip(*(line(YAW[name].estimate(cut, p)) for name in SENSED), strict=True))
    yaw, turning_in = _middle(yaws, slopes)
    half = (0.5 * p.track_width * yaw, 0.5 * p.track_width * turning_in)
    unread = np.full_like(cut[WHEELS[0]], np.nan)
    (speed, slope), (front, other) = (
        _speed([line(cut.get(name, unread) / p.wheel_speed_scale) for name in axle], *half)
        for axle in (WHEELS, FRONT_WHEELS)
    )
    read = [line(cut[name])[0] - getattr(p, f"{name}_offset", 0.0) for name in ACCELERATIONS]
    # An axle that stands is locked, or its sensors have failed.
    other = np.where(front > MOVING, other, np.nan)
    growth = line(cut[ACCELERATIONS[0]])[1]
    # Slip in proportion to the acceleration changes the speed of an axle by its product with the speed.
    slips = SLIP * np.nan_to_num(speed * growth + slope * read[0])
    across = speed * yaw + p.rear_distance * turning_in
    # Range of the yaw rates about their median; `fmin` and `fmax` ignore a missing one.
    least, most = (speed * (bound(yaws, axis=0) - yaw) for bound in (np.fmin.reduce, np.fmax.reduce))
    nearest = np.clip(read[1], across + least, across + most)
    along = np.array([slope, other, slope - slips, other - slips]) - p.rear_distance * yaw * yaw
    rolls = np.clip(read[0], *(bound(along, axis=0) for bound in (np.fmin.reduce, np.fmax.reduce)))
    predicted = (
        np.where(np.isfinite(slope), np.where(np.isfinite(read[0]), rolls, along[0]), np.nan),
        np.where(np.isfinite(read[1]), nearest, across),
    )
    moved = np.where(speed > MOVING, predicted, np.nan)
    rough = np.array([roughness(cut[name]) for name in ACCELERATIONS])
    return Motion(np.array(read), moved, rough, speed, along[0], growth)


def _middle(yaws: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Median of three yaw rates, or mean of two, with its slope, (blocks,) each; NaN if no two agree."""
    there = np.isfinite(yaws)
    order = np.argsort(np.where(there, yaws, np.inf), axis=0)
    ranked, risen = np.take_along_axis(yaws, order, axis=0), np.take_along_axis(slopes, order, axis=0)
    gaps = np.diff(ranked, axis=0)
    bound = AGREE + AGREE_SHARE * np.abs(ranked[1])
    agree = np.nanmin(np.where(np.isfinite(gaps), gaps, np.inf), axis=0) < bound
    yaw, slope = (np.where(there.all(axis=0), each[1], 0.5 * (each[0] + each[1])) for each in (ranked, risen))
    return np.where(agree, yaw, np.nan), np.where(agree, slope, np.nan)


def _speed(
    wheels: list[tuple[np.ndarray, np.ndarray]], half_turn: np.ndarray, growth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Speed and its slope, (blocks,) each, from both wheels or the only one; NaN if both disagree."""
    (left, left_slope), (right, right_slope) = wheels
    speeds = np.array([left + half_turn, right - half_turn])
    slopes = np.array([left_slope + growth, right_slope - growth])
    there = np.isfinite(speeds)
    speed, slope = (
        np.where(there, each, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1) for each in (speeds, slopes)
    )
    agree = there.any(axis=0) & ~(np.abs(speeds[0] - speeds[1]) > 0.1 + WHEELS_AGREE * np.abs(speed))
    return np.where(agree, speed, np.nan), np.where(agree, slope, np.nan)


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
ACROSS = replace(BOUNDS, gain=ROLL, lag=SLIP_LAG)  # fault-free differences of the lateral acceleration [m/s**2]
LATEST, SURELY = 0.06, 3.0
"""Delay of the longitudinal acceleration behind the wheels from which it is late [s], and number of standard deviations
by which it must exceed that. Of fault-free rounds of virtual demonstrators (seeds 142 and 201 to 203) the lower bounds
are .01 to .03 s, of the same .1 s late .10 to .13 s."""
ENOUGH = 20  # least number of blocks of half a second for an estimate of the delay


class AccelerationCheck:
    """Compare both measured accelerations with the motion, piece by piece."""

    def __init__(self, vehicle: CarParameters, rate: float, across: Bounds = ACROSS):
        self._vehicle, self._blocks = vehicle, Blocks(rate)
        self._checks = dict(zip(ACCELERATIONS, (DifferenceCheck(BOUNDS), DifferenceCheck(across)), strict=True))
        # Of growth, reading, and difference from the wheels, of all blocks.
        self._delay = running.Moments(3)

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Add the next piece; returns, for each acceleration that fails in it, the first sample without it."""
        cut, ends = self._blocks.add(time, signals)
        if not ends:
            return {}
        motion, failed = motion_of(cut, self._blocks, self._vehicle), {}
        moving = motion.speed > MOVING
        along = motion.read[0][moving]
        self._delay.add(-motion.growth[moving], along, along - motion.rolled[moving])
        for (name, check), read, moved, rough in zip(self._checks.items(), *motion[:3], strict=True):
            for row in zip(ends, (read - moved).tolist(), moved.tolist(), rough.tolist(), strict=True):
                if check.add(Row(*row)):
                    failed[name] = int(np.searchsorted(time, row[0] - 0.5 / self._blocks.rate))
        return failed

    def gone(self, name: str) -> bool:
        return self._checks[name].sure

    @property
    def late(self) -> float | None:
        """Delay of the longitudinal acceleration behind the wheels [s], by least squares; None if it is not late.

        The tyres' slip adds a share of the acceleration to the difference, and grade a constant.
        """
        squares, products, count = self._delay.products[:2, :2], self._delay.products[:2, 2], self._delay.count
        if count < ENOUGH or np.linalg.matrix_rank(squares) < len(squares):
            return None
        inverse = np.linalg.inv(squares)
        shares = inverse @ products
        variance = max(float(self._delay.products[2, 2] - shares @ products), 0.0) / (count - 3)
        least = float(shares[0] - SURELY * np.sqrt(inverse[0, 0] * variance))
        return float(shares[0]) if least > LATEST else None

    @property
    def found(self) -> dict[str, Difference]:
        """Inconsistent accelerations, sure or doubtful, by name."""
        return {name: each.found for name, each in self._checks.items() if each.found is not None}


STEERING = Bounds(single=4.0, level=0.7, shape=0.7, share=0.15, noise=np.inf)
"""Fault-free difference between the target torque of both steering motors and the torque of the shaft [N*m].

Fault-free rounds of three virtual demonstrators show .1 in the mean, and a standard deviation of .06 of the shaft's.
"""
DRIVING = Bounds(single=2.5, level=0.9, shape=0.5, share=0.35, noise=np.inf)
"""Fault-free difference between the acceleration by the targets of the drives and the measured one [m/s**2].

The same rounds show .59 in the mean, and a standard deviation of .24 of the measured one; on ice drives give less.
"""


class TargetCheck:
    """Compare the targets with the actuators' responses, piece by piece."""

    def __init__(self, vehicle: AutomatedVehicle.Parameters, rate: float):
        self._vehicle, self._blocks = vehicle, Blocks(rate)
        self._checks = {TARGETS[:2]: DifferenceCheck(STEERING), TARGETS[2:]: DifferenceCheck(DRIVING)}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        cut, ends = self._blocks.add(time, signals)
        if not ends:
            return
        p, speed = self._vehicle, mean_speed(cut) / self._vehicle.wheel_speed_scale
        force = drive_force(cut[TARGETS[2]] + cut[TARGETS[3]], p) - p.rolling_resistance - p.drag * speed * speed
        along = cut["longitudinal_acceleration"] - p.longitudinal_acceleration_offset
        ways = (
            (cut[TARGETS[0]] + cut[TARGETS[1]], cut["steering_shaft_torque"] - p.steering_shaft_torque_offset),
            (force / (p.mass + p.rolling_mass), along),
        )
        moves = self._blocks.line(speed)[0] > MOVING
        for check, (asked, shown) in zip(self._checks.values(), ways, strict=True):
            target, done = self._blocks.line(asked)[0], self._blocks.line(shown)[0]
            apart = np.where(moves, target - done, np.nan)
            for end, difference, value in zip(ends, apart.tolist(), done.tolist(), strict=True):
                check.add(Row(end, difference, value, 0.0))

    @property
    def found(self) -> tuple[tuple[str, ...], ...]:
        return tuple(targets for targets, each in self._checks.items() if each.sure)
