"""Observables of a drive that need no tyre model: scales of signals, distances of the car, zeros."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.monitors.sideslip.relations import BlocksOverDrive, Relation, RelationOverDrive

WHEELS = tuple(f"wheel_speed_{end}_{side}" for end in ("rear", "front") for side in ("left", "right"))
"""Wheel speed signals, rear wheels first, since they roll along the car."""


class Observables(NamedTuple):
    """Quantities that a drive determines, each NaN where it does not.

    Args:
        turn: logarithm of lateral acceleration over speed times yaw rate [-]
        wheelbase: wheelbase from steering angle, speed and yaw rate [m]
        understeer: additional steering angle per lateral acceleration [rad*s**2/m]
        steering_zero: steering angle of the road wheels straight ahead [rad]
        sensor_place: distance of the accelerometer ahead of the rear axle, the point that does not slip at low speed
            [m]
        track: difference of the rear wheel speeds over the yaw rate [m]
        wheel: logarithm of the speed over the mean of the wheel speeds [-]
        gain: logarithm of the speed gained over the integral of the longitudinal acceleration [-]
    """

    turn: float = math.nan
    wheelbase: float = math.nan
    understeer: float = math.nan
    steering_zero: float = math.nan
    sensor_place: float = math.nan
    track: float = math.nan
    wheel: float = math.nan
    gain: float = math.nan


@dataclass(frozen=True)
class ObservableLimits:
    """Validity limits of the relations.

    Args:
        slowest: speed below which the motion is uninformative
        slow: speed up to which the tyres of a turning car hardly slip, so that the rear axle follows its wheels
        linear: speed times yaw rate up to which tyres are linear
        gentle: change of the speed up to which wheels hardly slip
        steered: speed from which steering angle and yaw rate show the car: at walking pace the lateral acceleration is
            too small for an understeer gradient, and a delay of the yaw rate is a large part of a turn
        straight: road wheel angle up to which it is proportional to the curvature; at 0.25 rad its tangent is 2 %
            larger, and ratios still vary little
        turning: least standard deviation of speed times yaw rate for its ratio to the lateral acceleration; a noise of
            0.02, from a yaw rate in steps of 0.1 degrees per second on the motorway, makes the ratio 2 % too small
        together: least correlation of longitudinal acceleration and change of speed for their ratio
    """

    slowest: Annotated[float, "m/s"] = 3.0
    slow: Annotated[float, "m/s"] = 10.0
    linear: Annotated[float, "m/s**2"] = 4.0
    gentle: Annotated[float, "m/s**2"] = 3.0
    steered: Annotated[float, "m/s"] = 5.0
    straight: Annotated[float, "rad"] = 0.25
    turning: Annotated[float, "m/s**2"] = 0.15
    together: Annotated[float, ""] = 0.85


class ObservablesOverDrive:
    """Regressions over half-second blocks of a drive, independent of how the recording is cut.

    Args:
        rate: sampling rate [Hz]
        limits: validity limits of the relations
    """

    def __init__(self, rate: float, limits: ObservableLimits | None = None):
        self._limits = limits or ObservableLimits()
        self._blocks = BlocksOverDrive(rate, 5 + len(WHEELS))
        self._turn, self._slow = RelationOverDrive(2), RelationOverDrive(3)
        self._steer, self._track = RelationOverDrive(3), RelationOverDrive(2)
        self._wheel, self._gain, self._gained = RelationOverDrive(1), RelationOverDrive(2), RelationOverDrive(2)
        self._speeds, self._turned = np.zeros(3), RelationOverDrive(3)

    def add(self, signals: Mapping[str, np.ndarray], angle: np.ndarray) -> None:
        """Add the next piece, (n,) each; NaN where missing.

        Args:
            signals: signals by name
            angle: road wheel angle [rad]
        """
        names = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "longitudinal_acceleration")
        missing = np.full(len(angle), np.nan)
        wheels = (signals.get(name, missing) for name in WHEELS)
        rows = np.column_stack([*(signals[name] for name in names), angle, *wheels])
        blocks, changes = self._blocks.add(rows)
        if len(blocks):
            slopes = changes / self._blocks.seconds
            self._relate(blocks, slopes[:, 0], slopes[:, 1])

    def _relate(self, blocks: np.ndarray, gained: np.ndarray, turning: np.ndarray) -> None:
        limits, one = self._limits, np.ones(len(blocks))
        speed, yaw, lateral, along, angle, *wheels = blocks.mean(axis=1).T
        across = (blocks[:, :, 0] * blocks[:, :, 1]).mean(axis=1)
        rolling = speed > limits.slowest
        linear = rolling & (np.abs(across) < limits.linear)
        self._turn.add((across, one), lateral, rolling)
        self._slow.add((across, turning, one), lateral, linear & (speed < limits.slow))
        with np.errstate(divide="ignore", invalid="ignore"):
            steered = linear & (speed > limits.steered) & (np.abs(angle) < limits.straight)
            self._steer.add((yaw / speed, across, one), angle, steered)
            steered &= np.isfinite(yaw + angle)
            self._speeds += (np.sum(steered), np.sum(1.0 / speed[steered]), np.sum(speed[steered]))
        rear_left, rear_right, front_left, front_right = wheels
        self._track.add((yaw, speed), rear_right - rear_left, linear)
        self._turned.add((yaw, speed, one), rear_right - rear_left, linear)
        mean = 0.5 * (rear_left + rear_right)
        mean = np.where(np.isfinite(mean), mean, 0.5 * (front_left + front_right))
        self._wheel.add((mean,), speed, rolling)
        gentle = rolling & (np.abs(gained) < limits.gentle) & (np.abs(along) < limits.gentle)
        self._gain.add((along, one), gained, gentle)
        self._gained.add((gained, one), along, gentle)

    def lever(self, wheelbase: float, understeer: float) -> float:
        """Zero of the steering angle that a yaw rate offset imitates, with opposite sign, per offset [s].

        Args:
            wheelbase, understeer: as in `Observables`
        """
        _, slowness, speed = self._speeds / max(self._speeds[0], 1.0)
        return float(wheelbase * slowness + understeer * speed)

    def yaw_rate_offset(self) -> float:
        """Offset of the yaw rate beside the rear wheels, less two standard deviations [rad/s]; 0 without an estimate.

        In d = t r + e v + k a constant difference k of the wheels is -t times the offset; unequal radii enter e.
        """
        relation = self._turned.found()
        if relation is None or not relation.values[0] > 0.0:
            return 0.0
        offset, deviation = (
            float(each) / float(relation.values[0])
            for each in (-relation.values[2], math.sqrt(relation.covariance[2, 2]))
        )
        return math.copysign(max(abs(offset) - 2.0 * deviation, 0.0), offset)

    def found(self) -> tuple[Observables, np.ndarray]:
        """The observables, and their covariance from the noise of the drive."""
        names = Observables._fields
        values, covariance = dict.fromkeys(names, math.nan), np.zeros((len(names),) * 2)

        def keep(relation: Relation | None, places: Mapping[str, int], logarithm: bool = False) -> None:
            if relation is None or (logarithm and not relation.values[0] > 0.0):
                return
            at = [names.index(name) for name in places]
            own = list(places.values())
            scale = 1.0 / relation.values[own] if logarithm else np.ones(len(own))
            values.update(
                (n, math.log(relation.values[i]) if logarithm else float(relation.values[i])) for n, i in places.items()
            )
            covariance[np.ix_(at, at)] = relation.covariance[np.ix_(own, own)] * np.outer(scale, scale)

        keep(self._turn.found(self._limits.turning), {"turn": 0}, logarithm=True)
        keep(self._steer.found(), {"wheelbase": 0, "understeer": 1, "steering_zero": 2})
        keep(self._slow.found(), {"sensor_place": 1})
        keep(self._track.found(), {"track": 0})
        keep(self._wheel.found(), {"wheel": 0}, logarithm=True)
        gain, gained = self._gain.found(), self._gained.found()
        if gain is not None and gained is not None:
            # Noise in the regressor makes a ratio too small: the mean of both logarithms is free of that bias.
            one, other = float(gain.values[0]), float(gained.values[0])
            if one > 0.0 and one * other > self._limits.together**2:
                values["gain"] = 0.5 * math.log(one / other)
                at = names.index("gain")
                covariance[at, at] = 0.5 * (gain.covariance[0, 0] / one**2 + gained.covariance[0, 0] / other**2)
        return Observables(**values), covariance
