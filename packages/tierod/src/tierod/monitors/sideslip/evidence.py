"""Statistics of the sideslip monitor over a drive: estimate, its motions from standstill to standstill, and truth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.graph import Result
from tierod.core.series import runs
from tierod.methods.detectors.reversing import ReversingLimits
from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.observables import ObservablesOverDrive, OwnMotionOverDrive
from tierod.monitors.sideslip.sensors import SensorsOverDrive
from tierod.monitors.sideslip.tuning import BAND

# Channels with a reference for the estimate: from an optical sensor, or from a simulation.
TRUTHS = ("sideslip_angle", "truth_sideslip_angle")
# Speed up to which no sideslip and no limit of grip enter the headline: there the geometry of the turn makes the
# sideslip, and the slip of a tyre, over a rolling speed near zero, says nothing of its force.
WALKING: Annotated[float, "m/s"] = 2.0


class Largest(NamedTuple):
    """Sideslip angle with the largest lower bound of its band, with what belongs to its sample."""

    # Lower bound of the 95 % band of the magnitude; minus infinity without a sample.
    lower: Annotated[float, "rad"] = -math.inf
    # Sideslip angle and its standard deviation, with the spread of the parameters.
    value: Annotated[float, "rad"] = 0.0
    deviation: Annotated[float, "rad"] = 0.0
    own: Annotated[float, "rad"] = 0.0  # standard deviation by the estimator alone
    geometry: Annotated[float, "rad"] = 0.0  # sideslip angle of the same turn if the rear tyres did not slip
    speed: Annotated[float, "m/s"] = 0.0


class Announced(NamedTuple):
    """Announcements of the limit of grip."""

    first: float = math.inf  # time of the first sample [s]; infinite without one
    samples: int = 0  # number of samples
    used: float = 0.0  # largest share of the front axle's grip in use [-]

    def joined(self, other: Announced) -> Announced:
        return Announced(min(self.first, other.first), self.samples + other.samples, max(self.used, other.used))


class Samples(NamedTuple):
    """Samples of the next piece, (n,) each."""

    time: np.ndarray
    speed: np.ndarray
    reverses: np.ndarray  # whether the car is known to reverse
    judged: np.ndarray  # whether a sample may enter a headline
    # See `Largest`.
    value: np.ndarray
    deviation: np.ndarray
    own: np.ndarray
    geometry: np.ndarray
    ahead: np.ndarray  # whether the limit of grip is announced
    used: np.ndarray  # share of the front axle's grip in use


def parts_of_motions(speed: np.ndarray, reverses: np.ndarray) -> Iterator[tuple[slice, bool, bool]]:
    """Samples of each motion in the next piece; whether those before them belong to reversing; whether it ends there.

    A missing speed ends no motion. An empty part comes first where the motion of the previous piece has ended.
    """
    moves = ~(np.abs(speed) < ReversingLimits.standing)
    if len(moves) and not moves[0]:
        yield slice(0, 0), False, True
    for start, stop in zip(*runs(moves), strict=True):
        known = np.flatnonzero(reverses[start:stop])
        begin = start + int(known[-1]) + 1 if len(known) else start
        yield slice(begin, stop), bool(len(known)), stop < len(moves)


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
        return max(self._largest, self._moving[0])

    @property
    def announced(self) -> Announced:
        return self._announced.joined(self._moving[1])

    def add(self, samples: Samples) -> None:
        for part, reversed_, ended in parts_of_motions(samples.speed, samples.reverses):
            if reversed_:
                self._moving = Largest(), Announced()
            self._move(Samples(*(each[part] for each in samples)))
            if ended:
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
        self._moving = largest, announced.joined(Announced(first, int(ahead.sum()), used))


class SideslipDrive:
    """Statistics over a drive: the estimate, beside a truth where there is one, and the motion that the signals give.

    Args:
        ratio: road wheel angle over steering wheel angle
    """

    def __init__(self, parameters: SingleTrack.Parameters, ratio: float, rate: float):
        self.motions, self.sensors = FiguresOverMotions(), SensorsOverDrive(parameters, rate)
        self.observables, self.own_motion = ObservablesOverDrive(rate), OwnMotionOverDrive(rate)
        self.rate, self._ratio = rate, ratio
        self.angles = self.torques = False
        self.fastest = 0.0
        self._seen = self._compared = self._covered = 0
        self._squared_error = self._absolute_error = 0.0
        # Number of judged samples and sum of their standard deviations: over ended motions, and over the present one.
        self._judged, self._moving = np.zeros(2), np.zeros(2)
        self._last_truth = math.nan

    @property
    def seconds(self) -> float:
        """Time with an estimate above walking pace, without motions that turned out to reverse [s]."""
        return float((self._judged + self._moving)[0]) / self.rate

    @property
    def compared(self) -> float:
        """Time with a truth [s]."""
        return self._compared / self.rate

    def add(
        self,
        running: np.ndarray,
        reverses: np.ndarray,
        signals: Mapping[str, np.ndarray],
        result: Result,
        contradictions: bool = True,
    ) -> None:
        """Add the next piece, (n,) each.

        Args:
            contradictions: whether to test signals against each other and against the vehicle's parameters
        """
        speed, yaw_rate = signals["vehicle_speed"], signals["yaw_rate"]
        lateral, along = signals["lateral_acceleration"], signals["longitudinal_acceleration"]
        angle = _present(signals["road_wheel_angle"], self._ratio * signals["steering_wheel_angle"])
        torque = _present(signals["motor_torque"], signals["motor_current"])
        running = running & np.isfinite(speed) & np.isfinite(yaw_rate)
        self.angles |= bool(np.isfinite(angle).any())
        self.torques |= bool(np.isfinite(torque).any())
        self.fastest = max(self.fastest, float(np.nanmax(speed, initial=0.0)))
        self._add_estimate(running, reverses, speed, result, truth_in(signals))
        self.sensors.add(speed, yaw_rate, lateral, along, angle, torque)
        if contradictions:
            self.observables.add(signals, angle)
            self.own_motion.add(speed, yaw_rate, lateral, np.where(running, result["statement.magnitude"], np.nan))

    def _add_estimate(
        self, running: np.ndarray, reverses: np.ndarray, speed: np.ndarray, result: Result, truth: np.ndarray
    ) -> None:
        deviation = result["statement.deviation"]
        self._seen += len(running)
        judged = running & (speed > WALKING)
        for part, reversed_, ended in parts_of_motions(speed, reverses):
            counted = deviation[part][judged[part]]
            self._moving = (0.0 if reversed_ else self._moving) + np.array([len(counted), counted.sum()])
            if ended:
                self._judged, self._moving = self._judged + self._moving, np.zeros(2)
        # A truth that is slower than the grid is held: repeated values are stale and must not count again.
        fresh = np.diff(truth, prepend=self._last_truth) != 0.0
        self._last_truth = float(truth[-1]) if len(truth) else self._last_truth
        known = running & np.isfinite(truth) & fresh
        error = (result["statement.magnitude"] - truth)[known]
        self._compared += len(error)
        self._covered += int(np.sum(np.abs(error) <= BAND * deviation[known]))
        self._squared_error += float(error @ error)
        self._absolute_error += float(np.abs(error).sum())

    def evidence(self) -> dict[str, float]:
        """Estimated time, and the correlations between signals where a sign is wrong."""
        samples = self.seconds * self.rate
        found = {"enabled_s": self.seconds, "enabled_share": samples / max(self._seen, 1)}
        if self.motions.largest.speed:
            found["largest_sideslip_by_geometry_rad"] = self.motions.largest.geometry
        if self.sensors.turned():
            agreements = self.sensors.agreements().items()
            found |= {f"agreement of {one} and {other}": value for (one, other), value in agreements}
        return found

    def beside_truth(self) -> dict[str, float]:
        """Errors against the truth where there is one, and the mean standard deviation."""
        samples, deviations = (self._judged + self._moving).tolist()
        found = {}
        if self._compared:
            found["error_against_truth_rms_rad"] = math.sqrt(self._squared_error / self._compared)
            found["error_against_truth_mean_absolute_rad"] = self._absolute_error / self._compared
            found["truth_within_band_share"] = self._covered / self._compared
        return found | {"mean_deviation_rad": deviations / max(samples, 1.0)}


def truth_in(signals: Mapping[str, np.ndarray]) -> np.ndarray:
    """Reference for the estimate [rad]; NaN where the recording has none."""
    measured, simulated = (signals[name] for name in TRUTHS)
    return _present(simulated, measured)


def _present(values: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, otherwise)
