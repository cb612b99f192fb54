"""Regressions between the signals of a drive without a tyre model, and a test of the estimate by them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

# Averaging time of a block; long against the delays of sensors, short against a turn.
BLOCK: Annotated[float, "s"] = 0.5
STRETCH = 4  # blocks per stretch at the start, 2 s; doubled whenever `MOST` stretches are full
MOST = 64  # largest number of stretches; a covariance needs some twenty, and memory must stay bounded on a long drive
# Least numbers for a regression: 7.5 s, in six stretches that count as independent.
FEWEST_BLOCKS, FEWEST_STRETCHES = 15, 6
CONDITION = 1e4  # largest condition number of the normal equations; beyond it the coefficients are not separable


class Relation(NamedTuple):
    """Result of a regression."""

    values: np.ndarray  # coefficients, (coefficients,)
    covariance: np.ndarray  # covariance of the coefficients
    # Share of each regressor's mean square that the others do not explain, 1/VIF, (coefficients,).
    tolerance: np.ndarray


class BlocksOverDrive:
    """Fixed blocks of a drive, independent of how it is cut."""

    def __init__(self, rate: float, signals: int, seconds: float = BLOCK, fewest: int = 2):
        self._size = max(round(seconds * rate), fewest)
        self.seconds = self._size / rate
        self._rest = np.empty((0, signals))

    def add(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rows, size = np.vstack([self._rest, rows]), self._size
        # The change over a block needs the sample after it, so a block waits for the next piece.
        count = max(len(rows) - 1, 0) // size
        self._rest = rows[count * size :]
        changes = rows[size::size][:count] - rows[: count * size : size]
        return rows[: count * size].reshape(count, size, rows.shape[1]), changes


class RelationOverDrive:
    """One regression over a drive: products of regressors and target, accumulated stretch by stretch.

    The result does not depend on how the recording is cut."""

    def __init__(self, coefficients: int):
        self._sums = np.zeros((MOST, coefficients + 1, coefficients + 1))
        self._counts = np.zeros(MOST)
        self._blocks, self._length = 0, STRETCH

    def add(self, regressors: Sequence[np.ndarray], target: np.ndarray, counted: np.ndarray) -> None:
        rows = np.column_stack([*regressors, target])
        used = counted & np.isfinite(rows).all(axis=1)
        rows = np.where(used[:, None], rows, 0.0)
        # Excluded rows stay as zeros, so that stretches keep their length in time.
        while len(rows):
            room = MOST * self._length - self._blocks
            at = (self._blocks + np.arange(min(len(rows), room))) // self._length
            part = rows[: len(at)]
            np.add.at(self._sums, at, part[:, :, None] * part[:, None, :])
            np.add.at(self._counts, at, used[: len(at)])
            self._blocks += len(at)
            rows, used = rows[len(at) :], used[len(at) :]
            if self._blocks == MOST * self._length:
                self._join()

    def _join(self) -> None:
        for kept in (self._sums, self._counts):
            half = kept[0::2] + kept[1::2]
            kept[:] = 0.0
            kept[: MOST // 2] = half
        self._length *= 2

    def found(self, least: float = 0.0) -> Relation | None:
        """The regression; None with too little driving, or with too little motion to separate the coefficients.

        Args:
            least: least standard deviation of the first regressor beside a last one of ones [its unit]; noise in a
                smaller regressor makes its coefficient too small (W. A. Fuller, Measurement Error Models (1987),
                section 1.1)

        Covariance of a sum of scores that are independent from stretch to stretch only: P. J. Huber, Fifth Berkeley
        Symposium 1 (1967) 221; K.-Y. Liang, S. L. Zeger, Biometrika 73 (1986) 13.
        """
        used = self._counts > 0.0
        total = self._sums.sum(axis=0)
        normal, right = total[:-1, :-1], total[:-1, -1]
        size = np.sqrt(np.diag(normal))
        stretches = int(used.sum())
        if self._counts.sum() < FEWEST_BLOCKS or stretches < FEWEST_STRETCHES or not np.all(size > 0.0):
            return None
        if least and normal[0, 0] - normal[0, -1] ** 2 / normal[-1, -1] < least**2 * normal[-1, -1]:
            return None
        if np.linalg.cond(normal / np.outer(size, size)) > CONDITION:
            return None
        inverse = np.linalg.inv(normal)
        values = inverse @ right
        scores = self._sums[used][:, :-1, -1] - self._sums[used][:, :-1, :-1] @ values
        # Clustered (sandwich) covariance, with the usual correction for few clusters.
        few = stretches / max(stretches - len(values), 1)
        tolerance = 1.0 / (np.diag(inverse) * np.diag(normal))
        return Relation(values, few * inverse @ (scores.T @ scores) @ inverse, tolerance)


# Wheel speed signals, rear wheels first, since they roll along the car.
WHEELS = tuple(f"wheel_speed_{end}_{side}" for end in ("rear", "front") for side in ("left", "right"))


class Observables(NamedTuple):
    """Quantities that a drive determines, each NaN where it does not."""

    turn: float = math.nan  # logarithm of lateral acceleration over speed times yaw rate [-]
    wheelbase: float = math.nan  # wheelbase from steering angle, speed and yaw rate [m]
    understeer: float = math.nan  # additional steering angle per lateral acceleration [rad*s**2/m]
    steering_zero: float = math.nan  # steering angle of the road wheels straight ahead [rad]
    # Distance of the accelerometer ahead of the rear axle, the point that does not slip at low speed [m].
    sensor_place: float = math.nan
    track: float = math.nan  # difference of the rear wheel speeds over the yaw rate [m]
    wheel: float = math.nan  # logarithm of the speed over the mean of the wheel speeds [-]
    gain: float = math.nan  # logarithm of the speed gained over the integral of the longitudinal acceleration [-]


@dataclass(frozen=True)
class ObservableLimits:
    """Validity limits of the relations."""

    slowest: Annotated[float, "m/s"] = 3.0  # speed below which the motion is uninformative
    # Speed up to which the tyres of a turning car hardly slip, so that the rear axle follows its wheels.
    slow: Annotated[float, "m/s"] = 10.0
    linear: Annotated[float, "m/s**2"] = 4.0  # speed times yaw rate up to which tyres are linear
    gentle: Annotated[float, "m/s**2"] = 3.0  # change of the speed up to which wheels hardly slip
    # Speed from which steering angle and yaw rate show the car: at walking pace the lateral acceleration is too small
    # for an understeer gradient, and a delay of the yaw rate is a large part of a turn.
    steered: Annotated[float, "m/s"] = 5.0
    # Road wheel angle up to which it is proportional to the curvature; at 0.25 rad its tangent is 2 % larger, and
    # ratios still vary little.
    straight: Annotated[float, "rad"] = 0.25
    # Least standard deviation of speed times yaw rate for its ratio to the lateral acceleration; a noise of 0.02, from
    # a yaw rate in steps of 0.1 degrees per second on the motorway, makes the ratio 2 % too small.
    turning: Annotated[float, "m/s**2"] = 0.15
    # Least correlation of longitudinal acceleration and change of speed for their ratio.
    together: Annotated[float, ""] = 0.85


class ObservablesOverDrive:
    """Regressions over half-second blocks of a drive, independent of how the recording is cut."""

    def __init__(self, rate: float, limits: ObservableLimits | None = None):
        self._limits = limits or ObservableLimits()
        self._blocks = BlocksOverDrive(rate, 5 + len(WHEELS))
        self._turn, self._slow = RelationOverDrive(2), RelationOverDrive(3)
        self._steer, self._track = RelationOverDrive(3), RelationOverDrive(2)
        self._wheel, self._gain, self._gained = RelationOverDrive(1), RelationOverDrive(2), RelationOverDrive(2)
        self._speeds, self._turned = np.zeros(3), RelationOverDrive(3)

    def add(self, signals: Mapping[str, np.ndarray], angle: np.ndarray) -> None:
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
        """Zero of the steering angle that a yaw rate offset imitates, with opposite sign, per offset [s]."""
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


@dataclass(frozen=True)
class OwnMotionLimits:
    """Limits from which the estimate contradicts the motion."""

    slowest: Annotated[float, "m/s"] = 3.0  # speed below which lateral acceleration is uninformative
    # Tolerated difference of the share from 1; roll, place and delay of the accelerometer make 0.37.
    share: Annotated[float, ""] = 0.4
    certain: Annotated[float, ""] = 3.0  # standard deviations of the share beyond that
    # Standard deviations of the estimate that the resulting error must exceed: a 95 % band must contain it.
    bands: Annotated[float, ""] = 1.96
    least: Annotated[float, "rad"] = math.radians(0.2)  # resulting error below which nothing is reported
    # Least share of the squared estimated changes that turning does not explain; errors of 5 % of the estimated changes
    # make a quarter of it, and below it the share would be that of the errors.
    separable: Annotated[float, ""] = 0.01


class Share(NamedTuple):
    """Share of the estimated changes that the car really makes."""

    value: float  # 1 where the estimate is right [-]
    deviation: float  # standard deviation of the value [-]
    tolerance: float  # share of the squared estimated changes that turning does not explain [-]


class OwnMotionOverDrive:
    """Share of the estimated changes of the lateral speed in a - v r, independent of how the drive is cut.

    In a = v r + vy' the measured a, v and r give vy', which does not depend on stiffness, mass or distances. A place of
    the accelerometer ahead of the centre of gravity enters the term of the yaw acceleration, bank and zeros the
    constant. A share of one half means that the estimate changes twice as much as the car does."""

    def __init__(self, rate: float, limits: OwnMotionLimits | None = None):
        self.limits = limits or OwnMotionLimits()
        self._blocks = BlocksOverDrive(rate, 4)
        self._relation = RelationOverDrive(4)
        self._angles, self._variance = np.zeros(3), np.zeros(2)

    def add(self, speed: np.ndarray, yaw_rate: np.ndarray, lateral: np.ndarray, sideslip: np.ndarray) -> None:
        known = np.isfinite(sideslip) & (speed > self.limits.slowest)
        self._angles += (known.sum(), sideslip[known].sum(), sideslip[known] @ sideslip[known])
        blocks, changes = self._blocks.add(np.column_stack([speed, yaw_rate, lateral, speed * np.tan(sideslip)]))
        if not len(blocks):
            return
        _, turning, _, across = (changes / self._blocks.seconds).T
        turn = (blocks[:, :, 0] * blocks[:, :, 1]).mean(axis=1)
        mean = blocks.mean(axis=1)
        self._relation.add((across, turn, turning, np.ones(len(blocks))), mean[:, 2], mean[:, 0] > self.limits.slowest)

    def deviations(self, deviation: np.ndarray) -> None:
        """Add standard deviations of the estimate [rad], (n,), with the spread of the parameters; NaN where held."""
        known = deviation[np.isfinite(deviation)]
        self._variance += (len(known), known @ known)

    def share(self) -> Share | None:
        """The share; None where the drive does not determine it."""
        relation = self._relation.found()
        if relation is None:
            return None
        return Share(float(relation.values[0]), math.sqrt(relation.covariance[0, 0]), float(relation.tolerance[0]))

    def evidence(self) -> dict[str, float]:
        if (found := self.share()) is None:
            return {}
        return {"estimated_motion_share": found.value, "estimated_motion_share_deviation": found.deviation}

    def wrong(self) -> str | None:
        """Sentence on a wrong estimate; None where it changes as the car does, or within its band."""
        limits, found = self.limits, self.share()
        count, total, squares = self._angles
        if found is None or found.tolerance < limits.separable or not (count and self._variance[0]):
            return None
        band = math.sqrt(self._variance[1] / self._variance[0])
        off = abs(found.value - 1.0)
        error = off * math.sqrt(max(squares / count - (total / count) ** 2, 0.0))
        if off < limits.share + limits.certain * found.deviation or error < max(limits.least, limits.bands * band):
            return None
        return (
            f"by lateral_acceleration, yaw_rate and vehicle_speed, the lateral speed changes by {found.value:.2f} ± "
            f"{found.deviation:.2f} times the estimate: stiffness, mass or distances of the vehicle file do not fit, "
            "or one of these signals, the steering angle or the steering torque is wrong"
        )
