"""Statistics of the sideslip monitor over a drive: motions, estimate against truth, signs of signals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.graph import Result
from tierod.core.series import runs
from tierod.methods.detectors.reversing import ReversingLimits
from tierod.models.single_track import SingleTrack
from tierod.monitors.harness.related_signals import odd_ones_out
from tierod.monitors.sideslip.observables import ObservablesOverDrive, OwnMotionOverDrive
from tierod.monitors.sideslip.sensors import MotionOverDrive, SensorsOverDrive
from tierod.monitors.sideslip.tuning import BAND

STANDING = ReversingLimits().standing


class Largest(NamedTuple):
    """Sideslip angle with the largest lower bound of its band, with what belongs to its sample.

    Args:
        lower: lower bound of the 95 % band of the magnitude; minus infinity without a sample
        value, deviation: sideslip angle and its standard deviation, with the spread of the parameters
        own: standard deviation by the estimator alone
        geometry: sideslip angle of the same turn if the rear tyres did not slip
        speed: vehicle speed
    """

    lower: Annotated[float, "rad"] = -math.inf
    value: Annotated[float, "rad"] = 0.0
    deviation: Annotated[float, "rad"] = 0.0
    own: Annotated[float, "rad"] = 0.0
    geometry: Annotated[float, "rad"] = 0.0
    speed: Annotated[float, "m/s"] = 0.0


class Announced(NamedTuple):
    """Announcements of the limit of grip.

    Args:
        first: time of the first sample [s]; infinite without one
        samples: number of samples
        used: largest share of the front axle's grip in use [-]
    """

    first: float = math.inf
    samples: int = 0
    used: float = 0.0


class Samples(NamedTuple):
    """Samples of the next piece, (n,) each.

    Args:
        time: [s]
        speed: [m/s]; NaN where missing
        reverses: whether the car is known to reverse
        judged: whether a sample may enter a headline
        value, deviation, own, geometry: see `Largest` [rad]
        ahead: whether the limit of grip is announced
        used: share of the front axle's grip in use [-]
    """

    time: np.ndarray
    speed: np.ndarray
    reverses: np.ndarray
    judged: np.ndarray
    value: np.ndarray
    deviation: np.ndarray
    own: np.ndarray
    geometry: np.ndarray
    ahead: np.ndarray
    used: np.ndarray


class Part(NamedTuple):
    """Samples of one motion within a piece.

    Args:
        samples: those that may count
        reversed: whether all samples of the motion before them belong to reversing
        ended: whether the motion ends with them
    """

    samples: slice
    reversed: bool
    ended: bool


def parts_of_motions(speed: np.ndarray, reverses: np.ndarray) -> Iterator[Part]:
    """The motions of the next piece; an empty part of none comes first where the motion before it has ended.

    Args:
        speed: [m/s]; NaN where missing, which ends no motion
    """
    moves = ~(np.abs(speed) < STANDING)
    if len(moves) and not moves[0]:
        yield Part(slice(0, 0), False, ended=True)
    for start, stop in zip(*runs(moves), strict=True):
        known = np.flatnonzero(reverses[start:stop])
        begin = start + int(known[-1]) + 1 if len(known) else start
        yield Part(slice(begin, stop), bool(len(known)), ended=stop < len(moves))


class FiguresOverMotions:
    """Largest sideslip angle and announcements of the limit of grip; a motion that turns out to reverse leaves none.

    A car with unsigned speeds shows only after some turning that it reverses: figures of a motion count once it has
    ended, or the drive has. The result does not depend on how the drive is cut.
    """

    def __init__(self) -> None:
        self._largest, self._announced = Largest(), Announced()
        self._moving = Largest(), Announced()

    @property
    def largest(self) -> Largest:
        """Sideslip angle with the largest lower bound."""
        return max(self._largest, self._moving[0])

    @property
    def announced(self) -> Announced:
        """Announcements of the limit of grip."""
        return _joined(self._announced, self._moving[1])

    def add(self, samples: Samples) -> None:
        for part in parts_of_motions(samples.speed, samples.reverses):
            if part.reversed:
                self._moving = Largest(), Announced()
            self._move(Samples(*(each[part.samples] for each in samples)))
            if part.ended:
                self._largest, self._announced = self.largest, self.announced
                self._moving = Largest(), Announced()

    def _move(self, samples: Samples) -> None:
        largest, announced = self._moving
        known = samples.judged & np.isfinite(samples.deviation)
        if known.any():
            lower = np.where(known, np.abs(samples.value) - BAND * samples.deviation, -math.inf)
            at = int(np.argmax(lower))
            names = (samples.value, samples.deviation, samples.own, samples.geometry, samples.speed)
            largest = max(largest, Largest(float(lower[at]), *(float(each[at]) for each in names)))
        ahead = samples.ahead & samples.judged
        first = float(samples.time[np.argmax(ahead)]) if ahead.any() else math.inf
        used = float(np.max(samples.used[samples.judged], initial=0.0))
        self._moving = largest, _joined(announced, Announced(first, int(ahead.sum()), used))


def _joined(one: Announced, other: Announced) -> Announced:
    return Announced(min(one.first, other.first), one.samples + other.samples, max(one.used, other.used))


TRUTHS = ("sideslip_angle", "truth_sideslip_angle")
"""Channels with a reference for the estimate: from an optical sensor, or from a simulation."""

WALKING: Annotated[float, "m/s"] = 2.0
"""Speed up to which no sideslip and no limit of grip enter the headline: there the geometry of the turn makes the
sideslip, and the slip of a tyre, over a rolling speed near zero, says nothing of its force."""

TOGETHER = ("steering angle", "yaw rate", "lateral acceleration", "steering torque")
"""Signals with the same sign in a steady turn."""

CLEAR = 0.5
"""Magnitude of the correlation from which two signals agree or disagree in sign [-]; slow turns give above 0.9."""

FASTEST_STANDING = 3.0
"""Speed [m/s] up to which the car counts as manoeuvring, where torque and lateral acceleration are uninformative."""

FEWEST = 300
"""Least number of samples of a correlation."""


class SideslipDrive:
    """Collector of all statistics over a drive: estimate, signs, sensors, and the motion given by the signals."""

    def __init__(self, parameters: SingleTrack.Parameters, ratio: float, rate: float):
        self.figures, self.signs, self.motions = EstimateFigures(), SignsOverDrive(), FiguresOverMotions()
        self.sensors, self.motion = SensorsOverDrive(parameters, rate), MotionOverDrive(parameters, rate)
        self.observables, self.own_motion = ObservablesOverDrive(rate), OwnMotionOverDrive(rate)
        self.rate, self._ratio = rate, ratio

    @property
    def seconds(self) -> float:
        """Time for which the sideslip was estimated, above walking pace [s]."""
        return self.figures.samples / self.rate

    def yaw_rate_offsets(self) -> tuple[float, float]:
        """Offset of the yaw rate from the lateral acceleration and from the rear wheel speeds [rad/s]."""
        return self.motion.yaw_rate_offset(), self.observables.yaw_rate_offset()

    def add(
        self,
        running: np.ndarray,
        reverses: np.ndarray,
        signals: Mapping[str, np.ndarray],
        result: Result,
        contradictions: bool = True,
    ) -> None:
        speed, yaw_rate = signals["vehicle_speed"], signals["yaw_rate"]
        lateral, along = signals["lateral_acceleration"], signals["longitudinal_acceleration"]
        measured, wheel = signals["road_wheel_angle"], self._ratio * signals["steering_wheel_angle"]
        angle = np.where(np.isfinite(measured), measured, wheel)
        torque = np.where(np.isfinite(signals["motor_torque"]), signals["motor_torque"], signals["motor_current"])
        running = running & np.isfinite(speed) & np.isfinite(yaw_rate)
        self.figures.add(running, reverses, result, truth_in(signals), speed, angle, torque)
        self.sensors.add(speed, yaw_rate, lateral, angle)
        self.motion.add(speed, yaw_rate, lateral, along, angle)
        self.signs.add(speed, dict(zip(TOGETHER, (angle, yaw_rate, lateral, torque), strict=True)))
        if contradictions:
            self.observables.add(signals, angle)
            self.own_motion.add(speed, yaw_rate, lateral, np.where(running, result["statement.magnitude"], np.nan))

    def evidence(self) -> dict[str, float]:
        """Estimated time, and the correlations between signals where a sign is wrong."""
        found = {"enabled_s": self.seconds, "enabled_share": self.figures.samples / max(self.figures.seen, 1)}
        if self.motions.largest.speed:
            found["largest_sideslip_by_geometry_rad"] = self.motions.largest.geometry
        if self.signs.turned():
            agreements = self.signs.agreements().items()
            found |= {f"agreement of {one} and {other}": value for (one, other), value in agreements}
        return found


class EstimateFigures:
    """Statistics of an estimate over a recording, against the truth where there is one."""

    def __init__(self) -> None:
        self.seen = self.compared = self.covered = self.angles = self.torques = 0
        self.fastest = 0.0
        # Number of judged samples and sum of their standard deviations: over ended motions, and over the present one.
        self._judged, self._moving = np.zeros(2), np.zeros(2)
        self.squared_error = self.absolute_error = 0.0
        self._last_truth = math.nan

    @property
    def samples(self) -> int:
        """Number of samples with an estimate above walking pace, without motions that turned out to reverse."""
        return int((self._judged + self._moving)[0])

    @property
    def mean_deviation(self) -> float:
        """Mean standard deviation of the sideslip angle over them [rad]."""
        return float((self._judged + self._moving)[1]) / max(self.samples, 1)

    def add(
        self,
        running: np.ndarray,
        reverses: np.ndarray,
        result: Result,
        truth: np.ndarray,
        speed: np.ndarray,
        angle: np.ndarray,
        torque: np.ndarray,
    ) -> None:
        sideslip, deviation = result["statement.magnitude"], result["statement.deviation"]
        self.seen += len(running)
        judged = running & (speed > WALKING)
        for part in parts_of_motions(speed, reverses):
            counted = deviation[part.samples][judged[part.samples]]
            self._moving = (0.0 if part.reversed else self._moving) + np.array([len(counted), counted.sum()])
            if part.ended:
                self._judged, self._moving = self._judged + self._moving, np.zeros(2)
        self.angles += int(np.isfinite(angle).sum())
        self.torques += int(np.isfinite(torque).sum())
        self.fastest = max(self.fastest, float(np.nanmax(speed, initial=0.0)))
        # A truth that is slower than the grid is held: repeated values are stale and must not count again.
        fresh = np.diff(truth, prepend=self._last_truth) != 0.0
        self._last_truth = float(truth[-1]) if len(truth) else self._last_truth
        known = running & np.isfinite(truth) & fresh
        error, band = (sideslip - truth)[known], BAND * deviation[known]
        self.compared += len(error)
        self.covered += int(np.sum(np.abs(error) <= band))
        self.squared_error += float(error @ error)
        self.absolute_error += float(np.abs(error).sum())

    def beside_truth(self) -> dict[str, float]:
        """Evidence: errors against the truth where there is one, and the mean standard deviation."""
        mean = {"mean_deviation_rad": self.mean_deviation}
        if not self.compared:
            return mean
        return {
            "error_against_truth_rms_rad": math.sqrt(self.squared_error / self.compared),
            "error_against_truth_mean_absolute_rad": self.absolute_error / self.compared,
            "truth_within_band_share": self.covered / self.compared,
            **mean,
        }


def truth_in(signals: Mapping[str, np.ndarray]) -> np.ndarray:
    """Reference for the estimate [rad]; NaN where the recording has none."""
    measured, simulated = (signals[name] for name in TRUTHS)
    return np.where(np.isfinite(simulated), simulated, measured)


class SignsOverDrive:
    """Sums of products of the signals of `TOGETHER` over a recording, where the car rolls."""

    def __init__(self) -> None:
        size = len(TOGETHER)
        self._products, self._squares = np.zeros((size, size)), np.zeros((size, size))
        self._counts = np.zeros((size, size))

    def add(self, speed: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        rolling = np.isfinite(speed) & (speed > FASTEST_STANDING)
        for (i, one), (j, other) in combinations(enumerate(TOGETHER), 2):
            a, b = signals[one], signals[other]
            both = rolling & np.isfinite(a) & np.isfinite(b)
            x, y = a[both], b[both]
            self._products[i, j] += x @ y
            self._squares[i, j] += x @ x
            self._squares[j, i] += y @ y
            self._counts[i, j] += len(x)

    def agreements(self) -> dict[tuple[str, str], float]:
        """Correlation about zero, -1 to 1, of every pair with enough samples."""
        found = {}
        for (i, one), (j, other) in combinations(enumerate(TOGETHER), 2):
            size = np.sqrt(self._squares[i, j] * self._squares[j, i])
            if self._counts[i, j] >= FEWEST and size > 0.0:
                found[one, other] = float(self._products[i, j] / size)
        return found

    def turned(self) -> tuple[str, ...]:
        """The signal of `TOGETHER` whose sign contradicts the others; several where they cannot be separated."""
        clear = {pair: value > 0.0 for pair, value in self.agreements().items() if abs(value) > CLEAR}
        return odd_ones_out(TOGETHER, clear)
