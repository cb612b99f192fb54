"""Test whether speed, accelerations, yaw rate and steering describe one motion, and which of them does not."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.findings import Defect
from tierod.methods.identification.regression import solved
from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.relations import BlocksOverDrive

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
    """Sums of two quantities over the blocks in which both are valid."""

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
    """Sums over a drive in fixed blocks, so that the result does not depend on how the recording is cut.

    Args:
        p: parameters of the vehicle
        rate: sampling rate [Hz]
        limits: limits of a contradiction
    """

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
        """Add the next piece, (n,) each; NaN where missing.

        Args:
            speed: vehicle speed [m/s]
            yaw_rate: yaw rate [rad/s]
            lateral, longitudinal: accelerations [m/s**2]
            angle: road wheel angle [rad]
        """
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
        """Add to the regression of the lateral acceleration, where the car rolls."""
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
        """The one of speed, yaw rate and lateral acceleration that contradicts the steering and the other two."""
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
