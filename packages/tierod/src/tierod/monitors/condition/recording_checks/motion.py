"""Accelerations predicted by kinematics from wheel speeds, yaw rate and steering angle, without forces or tyres."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tierod.monitors.condition.recording_checks.differences import Blocks, roughness
from tierod.monitors.condition.recording_checks.witnesses import MOVING, YAW
from tierod.monitors.condition.signals import ACCELERATIONS, FRONT_WHEELS, WHEELS, CarParameters

SENSED = ("yaw rate sensor", "rear wheels", "steering angle")
"""Witnesses of the yaw rate that use no acceleration, the most accurate first."""
AGREE, AGREE_SHARE = 0.06, 0.15
"""Largest difference of consistent yaw rates: absolute [rad/s] plus relative [-]; turning in causes as much."""
SLIP = 0.03
"""Largest slip of an axle over the acceleration [s**2/m]: .3 in an emergency stop at 10 m/s**2, the most that anti-lock
brakes allow. Without brakes the axle that is not driven has none."""
WHEELS_AGREE = 0.05
"""Largest relative difference of consistent rear wheel speeds, referred to the middle of the axle [-]."""


class Block(NamedTuple):
    """Means of one block of time; NaN where an input is missing, or the witnesses of the motion are inconsistent.

    Args:
        end: end of the block [s]
        read: measured `ACCELERATIONS` without their known offsets [m/s**2]
        moved: accelerations predicted from the motion [m/s**2]
        rough: standard deviation of the white noise of the measured ones [m/s**2]
        speed: speed of the vehicle [m/s]
        rolled: longitudinal acceleration by the rear wheels alone [m/s**2]
        growth: slope of the measured longitudinal acceleration [m/s**3]
    """

    end: float
    read: tuple[float, float]
    moved: tuple[float, float]
    rough: tuple[float, float]
    speed: float
    rolled: float
    growth: float


class Motion:
    """Predicts the accelerations block by block; the result does not depend on how a recording is cut into pieces.

    Along the vehicle the change of speed is used, across it yaw rate times speed. Two of three yaw rates must agree, so
    that one faulty sensor does not matter; if the two wheels disagree, neither is used. Axles slip, and when tyres
    slide, rear wheels and steering angle have similar errors: both accelerations are therefore predicted as close to
    the measured ones as the range of the axles, with and without slip, and that of the yaw rates permit.

    Args:
        vehicle: parameters of the vehicle
        rate: sampling rate [Hz]
    """

    def __init__(self, vehicle: CarParameters, rate: float):
        self._vehicle, self._blocks = vehicle, Blocks(rate)

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> list[Block]:
        """Blocks that the next piece completes.

        Args:
            time: time stamps [s], (n,)
            signals: signals by name, (n,) each; NaN if missing
        """
        cut, ends = self._blocks.add(time, signals)
        if not ends:
            return []
        p, line = self._vehicle, self._blocks.line
        yaws, slopes = zip(*(line(YAW[name].estimate(cut, p)) for name in SENSED), strict=True)
        yaws, slopes = np.array(yaws), np.array(slopes)
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
        slopes_along = np.array([slope, other, slope - slips, other - slips])
        across = speed * yaw + p.rear_distance * turning_in
        # Range of the yaw rates about their median; `fmin` and `fmax` ignore a missing one.
        least, most = (speed * (bound(yaws, axis=0) - yaw) for bound in (np.fmin.reduce, np.fmax.reduce))
        nearest = np.clip(read[1], across + least, across + most)
        along = slopes_along - p.rear_distance * yaw * yaw
        rolls = np.clip(read[0], *(bound(along, axis=0) for bound in (np.fmin.reduce, np.fmax.reduce)))
        predicted = (
            np.where(np.isfinite(slope), np.where(np.isfinite(read[0]), rolls, along[0]), np.nan),
            np.where(np.isfinite(read[1]), nearest, across),
        )
        moved = [np.where(speed > MOVING, each, np.nan) for each in predicted]
        rough = [roughness(cut[name]) for name in ACCELERATIONS]
        return [
            Block(end, (ax, ay), (vx, vy), (nx, ny), *others)
            for end, (ax, ay, vx, vy, nx, ny, *others) in zip(
                ends, np.column_stack((*read, *moved, *rough, speed, along[0], growth)).tolist(), strict=True
            )
        ]


def _middle(yaws: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Median of three yaw rates, or mean of two, with its slope, (blocks,) each; NaN if no two agree."""
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
    """Speed and its slope, (blocks,) each, from both wheels or the only one; NaN if both disagree."""
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
