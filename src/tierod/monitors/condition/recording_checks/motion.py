"""Accelerations predicted from the motion: wheel speeds, yaw rate and steering angle; no force and no tyre model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tierod.monitors.condition.recording_checks.differences import Blocks, roughness
from tierod.monitors.condition.recording_checks.witnesses import MOVING, YAW
from tierod.monitors.condition.signals import ACCELERATIONS, WHEELS, CarParameters

SENSED = ("yaw rate sensor", "rear wheels", "steering angle")
"""Estimates of the yaw rate that use no acceleration, the most exact first."""
AGREE, AGREE_SHARE = 0.06, 0.15
"""Difference of yaw rates that agree: absolute [rad/s] and relative [-]; turning in makes as much."""
WHEELS_AGREE = 0.05
"""Relative difference of rear wheel speeds that agree, both referred to the middle of the axle [-]."""


class Block(NamedTuple):
    """Means of one block of time; NaN where an input is missing or the others disagree.

    Args:
        end: of the block [s]
        read: of each of `ACCELERATIONS`, without its known offset [m/s**2]
        moved: as predicted from the motion [m/s**2]
        rough: standard deviation of its noise from sample to sample [m/s**2]
        speed: of the vehicle [m/s]
    """

    end: float
    read: tuple[float, float]
    moved: tuple[float, float]
    rough: tuple[float, float]
    speed: float


class Motion:
    """Averages a drive block by block, in pieces; the result does not depend on how a recording is cut.

    Along the vehicle the change of speed is used, across it yaw rate times speed. Of three yaw rates two must agree, so
    that one faulty sensor does not matter; of two wheels that disagree, neither is used. Where tyres slip, rear wheels
    and steering angle err alike: across the vehicle the motion is as near to the reading as the yaw rates allow.

    Args:
        vehicle: its parameters
        rate: of the samples [Hz]
    """

    def __init__(self, vehicle: CarParameters, rate: float):
        self._vehicle, self._blocks = vehicle, Blocks(rate)

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> list[Block]:
        """The blocks that the next piece completes.

        Args:
            time: [s], (n,)
            signals: by name, (n,) each; NaN where missing
        """
        cut, ends = self._blocks.add(time, signals)
        if not ends:
            return []
        p, line = self._vehicle, self._blocks.line
        yaws, slopes = zip(*(line(YAW[name].estimate(cut, p)) for name in SENSED), strict=True)
        yaws, slopes = np.array(yaws), np.array(slopes)
        yaw, turning_in = _middle(yaws, slopes)
        wheels = [line(cut[name] / p.wheel_speed_scale) for name in WHEELS]
        speed, slope = _speed(wheels, 0.5 * p.track_width * yaw, 0.5 * p.track_width * turning_in)
        read = [line(cut[name])[0] - getattr(p, f"{name}_offset", 0.0) for name in ACCELERATIONS]
        across = speed * yaw + p.rear_distance * turning_in
        least, most = (speed * (bound(yaws, axis=0) - yaw) for bound in (np.fmin.reduce, np.fmax.reduce))
        nearest = np.clip(read[1], across + least, across + most)
        predicted = (slope - p.rear_distance * yaw * yaw, np.where(np.isfinite(read[1]), nearest, across))
        moved = [np.where(speed > MOVING, each, np.nan) for each in predicted]
        rough = [roughness(cut[name]) for name in ACCELERATIONS]
        return [
            Block(end, (ax, ay), (vx, vy), (nx, ny), v)
            for end, (ax, ay, vx, vy, nx, ny, v) in zip(
                ends, np.column_stack((*read, *moved, *rough, speed)).tolist(), strict=True
            )
        ]


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
