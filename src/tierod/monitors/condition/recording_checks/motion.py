"""What a vehicle's motion tells of its accelerations: wheels, yaw rate and steering angle alone, no force, no tyre."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from tierod.monitors.condition.recording_checks.witnesses import MOVING, YAW
from tierod.monitors.condition.signals import ACCELERATIONS, WHEELS

SENSED = ("yaw rate sensor", "rear wheels", "steering angle")
"""What tells the yaw rate without the accelerations, the most exact first."""
BLOCK = 0.5
"""Time over which signals are averaged [s]; noise of wheel speeds is .02 m/s**2 in its slope."""
LEAST_READ = 0.15
"""Share of the samples of a block that a signal must have; wheel speeds come at 20 Hz on slow buses."""
AGREE, AGREE_SHARE = 0.06, 0.15
"""Up to which two yaw rates of a block agree, at none [rad/s] and as a share of them; a turn-in makes as much."""
WHEELS_AGREE = 0.05
"""Share of the speed up to which both rear wheels tell the same speed, beyond what the turn tells [-]."""


class Block(NamedTuple):
    """Means of one block of time; NaN where something lacks or two of the others disagree.

    Args:
        end: number of the sample after it
        read: of each of `ACCELERATIONS`, without its known offset [m/s**2]
        moved: what the motion tells of it [m/s**2]
        rough: standard deviation of its noise from sample to sample [m/s**2]
        speed: of the vehicle [m/s]
    """

    end: int
    read: tuple[float, float]
    moved: tuple[float, float]
    rough: tuple[float, float]
    speed: float


class Motion:
    """Averages a drive block by block, in pieces; the result does not depend on how a recording is cut.

    Along the vehicle the slope of the speed counts, across it yaw rate times speed. Of three yaw rates the middle one
    counts, so that one sensor at fault does not matter; of both wheels neither where they disagree.

    Args:
        vehicle: its parameters
        rate: of the samples [Hz]
    """

    def __init__(self, vehicle: Any, rate: float):
        self._vehicle, self._rate = vehicle, rate
        self._width = max(round(BLOCK * rate), 2)
        self._left: dict[str, np.ndarray] = {}
        self._done = 0

    def add(self, signals: Mapping[str, np.ndarray]) -> list[Block]:
        """The blocks that the next piece completes.

        Args:
            signals: by name, (n,) each; NaN where missing
        """
        whole = {name: np.concatenate([self._left.get(name, values[:0]), values]) for name, values in signals.items()}
        count = len(next(iter(whole.values()))) // self._width
        used = count * self._width
        self._left = {name: values[used:].copy() for name, values in whole.items()}
        if not count:
            return []
        cut = {name: values[:used] for name, values in whole.items()}
        found = self._blocks(cut, count)
        self._done += used
        return found

    def _blocks(self, signals: Mapping[str, np.ndarray], count: int) -> list[Block]:
        p, shape = self._vehicle, (count, self._width)
        yaws, slopes = zip(
            *(self._line(YAW[name].tells(signals, p).reshape(shape)) for name in SENSED),
            strict=True,
        )
        yaw, turning_in = _middle(np.array(yaws), np.array(slopes))
        wheels = [self._line(signals[name].reshape(shape) / p.wheel_speed_scale) for name in WHEELS]
        half_turn = 0.5 * p.track_width * yaw
        speed, slope = _speed(wheels, half_turn, 0.5 * p.track_width * turning_in)
        along = slope - p.rear_distance * yaw * yaw
        across = speed * yaw + p.rear_distance * turning_in
        read = [
            self._line(signals[name].reshape(shape))[0] - getattr(p, f"{name}_offset", 0.0) for name in ACCELERATIONS
        ]
        rough = [_roughness(signals[name].reshape(shape)) for name in ACCELERATIONS]
        drives = speed > MOVING
        columns = (*read, np.where(drives, along, np.nan), np.where(drives, across, np.nan), *rough, speed)
        return [
            Block(self._done + (place + 1) * self._width, (ax, ay), (vx, vy), (nx, ny), v)
            for place, (ax, ay, vx, vy, nx, ny, v) in enumerate(np.column_stack(columns).tolist())
        ]

    def _line(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and slope per second of every row; NaN where too few are read."""
        there = np.isfinite(values)
        weight = there.astype(float)
        count = weight.sum(axis=1)
        enough = count >= max(LEAST_READ * self._width, 3.0)
        time = (np.arange(self._width) - 0.5 * (self._width - 1)) / self._rate
        known = np.where(there, values, 0.0)
        safe = np.maximum(count, 1.0)
        mean, middle = known.sum(axis=1) / safe, (weight * time).sum(axis=1) / safe
        apart = (time - middle[:, None]) * weight
        spread = (apart * time).sum(axis=1)
        slope = (apart * known).sum(axis=1) / np.where(spread > 0.0, spread, 1.0)
        at_centre = mean - slope * middle
        return np.where(enough, at_centre, np.nan), np.where(enough & (spread > 0.0), slope, np.nan)


def _roughness(values: np.ndarray) -> np.ndarray:
    """Standard deviation of the noise of every row, from the steps between samples; NaN where few follow each other."""
    steps = np.diff(values, axis=1)
    there = np.isfinite(steps)
    count = there.sum(axis=1)
    squares = np.where(there, steps * steps, 0.0).sum(axis=1)
    return np.where(count >= 3, np.sqrt(0.5 * squares / np.maximum(count, 1)), np.nan)


def _middle(yaws: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middle of three yaw rates with its slope, (blocks,) each; NaN where fewer than two agree."""
    there = np.isfinite(yaws)
    order = np.argsort(np.where(there, yaws, np.inf), axis=0)
    ranked, risen = np.take_along_axis(yaws, order, axis=0), np.take_along_axis(slopes, order, axis=0)
    gaps = np.diff(ranked, axis=0)
    bound = AGREE + AGREE_SHARE * np.abs(ranked[1])
    agree = np.nanmin(np.where(np.isfinite(gaps), gaps, np.inf), axis=0) < bound
    three = there.all(axis=0)
    yaw = np.where(three, ranked[1], 0.5 * (ranked[0] + ranked[1]))
    slope = np.where(three, risen[1], 0.5 * (risen[0] + risen[1]))
    return np.where(agree, yaw, np.nan), np.where(agree, slope, np.nan)


def _speed(
    wheels: list[tuple[np.ndarray, np.ndarray]], half_turn: np.ndarray, growth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Speed and its slope, (blocks,) each, of both wheels or the one that there is; NaN where they disagree."""
    (left, left_slope), (right, right_slope) = wheels
    speeds, slopes = (
        np.array([left + half_turn, right - half_turn]),
        np.array([left_slope + growth, right_slope - growth]),
    )
    there = np.isfinite(speeds)
    one = there.any(axis=0)
    speed = np.where(there, speeds, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    slope = np.where(there, slopes, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    apart = np.abs(speeds[0] - speeds[1])
    agree = one & ~(apart > 0.1 + WHEELS_AGREE * np.abs(speed))
    return np.where(agree, speed, np.nan), np.where(agree, slope, np.nan)
