"""Reversing of a car whose speeds carry no sign, from steering angle, yaw rate and wheel speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.series import LastRead, runs

_FRESH = 0.25  # Longest time for which a reading holds [s]; chassis buses send every 10 to 100 ms
_SHOWN = 3  # Largest number of reversals that a sentence names
# Cause where a recording has no turn forward to compare with
MIRRORED = "every turn mirrors the steering angle: the car reversed all the time, or the yaw rate has the wrong sign"
# Its remedy
TURN_FORWARD = "record turns forward as well; if the car drove forward, set the sign of the yaw rate in the channel map"


@dataclass(frozen=True)
class ReversingLimits:
    """Limits from which a car reverses.

    A car changes its direction at standstill only. From one standstill to the next, a car that reverses with unsigned
    speeds turns as the mirror image of its steering, while its wheels mirror the yaw rate as well. A wrong sign of the
    yaw rate does the same at all speeds, a wrong sign of the angle leaves yaw rate and wheels consistent.
    """

    # speed from which a car moves; sensors of wheel speeds end at 0.3 to 0.8 m/s
    standing: Annotated[float, "m/s"] = 0.3
    fastest: Annotated[float, "m/s"] = 8.0  # speed at which no car reverses; 30 km/h is usual for the reverse gear
    # yaw rate from which a turn counts, above offsets and noise of the sensor
    turning: Annotated[float, "rad/s"] = 0.03
    turned: Annotated[float, "rad"] = 0.1  # heading by which a car must have turned since the standstill
    # least cosine between the yaw rate and its mirror image by the steering angle, as vectors of samples
    similar: Annotated[float, ""] = 0.8
    # the same by the wheels, whose coarse steps are a larger part of their difference
    alike: Annotated[float, ""] = 0.5
    # largest ratio of the yaw rate to that by the steering angle, or its inverse; ratios and slip angles of unmeasured
    # cars cause 1.5
    ratio: Annotated[float, ""] = 2.5


class Reversal(NamedTuple):
    """Reversing between two standstills."""

    start: float  # begin of the motion [s]
    found: float  # time from which the direction is known [s]
    end: float  # end of the motion, or of the samples so far [s]


class _Motion(NamedTuple):
    """Motion since the last standstill."""

    start: float  # its begin [s]
    found: float  # time at which it was recognised as reversing [s]; NaN while it is not
    fastest: float  # largest speed [m/s]
    sums: np.ndarray


class Reversing:
    """Recognises piece by piece when a car with unsigned speeds reverses; the cut into pieces does not matter.

    Args:
        rate: sampling rate [Hz]
        steering_ratio: road wheel angle per steering wheel angle [-]
        wheelbase: distance of the axles [m]
    """

    def __init__(self, rate: float, steering_ratio: float, wheelbase: float, limits: ReversingLimits | None = None):
        self._period, self._ratio, self._wheelbase = 1.0 / rate, steering_ratio, wheelbase
        self._limits = limits or ReversingLimits()
        self._read = LastRead(4, _FRESH)
        self._motion: _Motion | None = None
        self._signed = False
        self.found: list[Reversal] = []
        self.turned_forward = False

    @property
    def mirrored(self) -> bool:
        """Whether every turn looks like reversing, so that no turn forward shows that the signs are right."""
        return bool(self.found) and not self.turned_forward

    @property
    def words(self) -> str:
        """Sentence on the times in which the car reversed; "" if it did not, or where its direction is left open."""
        if not self.found or self.mirrored:
            return ""
        named = ", ".join(f"from {each.start:.1f} s to {each.end:.1f} s" for each in self.found[:_SHOWN])
        more = f" and {len(self.found) - _SHOWN} more times" if len(self.found) > _SHOWN else ""
        return f"the car reversed {named}{more}; its speeds have no sign"

    def add(
        self,
        time: np.ndarray,
        yaw_rate: np.ndarray,
        steering_wheel_angle: np.ndarray,
        speed: np.ndarray,
        wheel_difference: np.ndarray | None = None,
    ) -> np.ndarray:
        """Add the next piece, and return whether the car is known to reverse at each sample, (n,).

        Signed speeds show reversing directly; `found` holds only what unsigned speeds hide.

        Args: time: time stamps [s], (n,); yaw_rate: yaw rate [rad/s], (n,); NaN if missing, as in the others;
        steering_wheel_angle: angle [rad], (n,); speed: speed of the car, or mean of its wheel speeds [m/s], (n,);
        wheel_difference: right less left rear wheel speed [m/s], (n,); None without wheel speeds.
        """
        difference = np.full(len(time), np.nan) if wheel_difference is None else wheel_difference
        columns = np.column_stack((yaw_rate, steering_wheel_angle, speed, difference))
        yaw, angle, speed, difference = self._read.held(time, columns).T
        found = np.zeros(len(time), bool)
        with np.errstate(invalid="ignore"):
            self._signed |= bool((speed < -self._limits.standing).any())
            # Without a speed the car may go on as before.
            moves = ~(np.abs(speed) < self._limits.standing) & (np.isfinite(speed) | (self._motion is not None))
        if self._signed:
            with np.errstate(invalid="ignore"):
                return np.asarray(speed < -self._limits.standing)
        added = self._contributions(yaw, angle, speed, difference)
        if len(time) and not moves[0]:
            self._motion = None
        for start, stop in zip(*runs(moves), strict=True):
            found[start:stop] = self._moved(time[start:stop], np.nan_to_num(speed[start:stop]), added[start:stop])
            if stop < len(time):
                self._motion = None
        return found

    def _contributions(
        self, yaw: np.ndarray, angle: np.ndarray, speed: np.ndarray, difference: np.ndarray
    ) -> np.ndarray:
        """Heading; squares of the yaw rate and of that by the angle, and product; the same for the wheels, (n, 7)."""
        expected = speed * np.tan(np.clip(self._ratio * angle, -1.2, 1.2)) / self._wheelbase
        there = np.isfinite(yaw) & np.isfinite(expected)
        turning = there & (np.abs(yaw) > self._limits.turning)
        yaw, expected, wheels = (np.where(there, np.nan_to_num(each), 0.0) for each in (yaw, expected, difference))
        own = np.where(wheels != 0.0, yaw, 0.0)
        heading = np.where(turning, np.abs(yaw), 0.0) * self._period
        by_angle, by_wheels = (
            (yaw * yaw, expected * expected, yaw * expected),
            (own * own, wheels * wheels, own * wheels),
        )
        return np.column_stack((heading, *by_angle, *by_wheels))

    def _moved(self, time: np.ndarray, speed: np.ndarray, added: np.ndarray) -> np.ndarray:
        limits = self._limits
        before = self._motion or _Motion(float(time[0]), np.nan, 0.0, np.zeros(added.shape[1]))
        sums = before.sums + np.cumsum(added, axis=0)
        fastest = np.maximum(np.maximum.accumulate(speed), before.fastest)
        heading, yaw, expected, product, own, wheels, by_wheels = sums.T
        size, least = limits.similar * np.sqrt(yaw * expected), limits.alike * np.sqrt(own * wheels)
        shows = (heading > limits.turned) & (yaw < limits.ratio**2 * expected) & (expected < limits.ratio**2 * yaw)
        self.turned_forward |= bool((shows & (product > size)).any())
        mirrored = shows & (product < -size) & (by_wheels <= -least)
        slow = fastest <= limits.fastest
        known = slow & (np.isfinite(before.found) | np.logical_or.accumulate(mirrored & slow))
        found = before.found if np.isfinite(before.found) or not known.any() else float(time[np.argmax(known)])
        if self.found and self.found[-1].start == before.start:
            del self.found[-1]
        if known[-1]:
            self.found.append(Reversal(before.start, found, float(time[-1])))
        self._motion = _Motion(before.start, found if known[-1] else np.nan, float(fastest[-1]), sums[-1])
        return np.asarray(known)


STEERING_RATIO, WHEELBASE = 1.0 / 15.5, 2.7  # Parameters of a usual car [-], [m], for recordings whose car is not known
# Limits for such recordings: ratio and wheelbase may be those of a kart or of a lorry
_ANY_CAR = ReversingLimits(ratio=10.0)


def reversing_of_any_car(
    time: np.ndarray, columns: Mapping[str, np.ndarray], rate: float
) -> tuple[np.ndarray, Reversing]:
    """Whether an unknown car reverses at each sample, (n,), and how that was found.

    Args: time: time stamps [s], (n,); columns: signals by canonical name, (n,) each; NaN or absent if missing; rate:
    sampling rate [Hz].
    """
    missing = np.full(len(time), np.nan)
    left, right = (columns.get(f"wheel_speed_rear_{side}", missing) for side in ("left", "right"))
    speed, wheels = columns.get("vehicle_speed", missing), 0.5 * (left + right)
    made = Reversing(rate, STEERING_RATIO, WHEELBASE, _ANY_CAR)
    yaw, angle = (columns.get(name, missing) for name in ("yaw_rate", "steering_wheel_angle"))
    return made.add(time, yaw, angle, np.where(np.isfinite(speed), speed, wheels), right - left), made


def reversing_of_any_signs(time: np.ndarray, columns: Mapping[str, np.ndarray], rate: float) -> np.ndarray:
    """Whether a car reverses at each sample, (n,), whatever the signs of yaw rate and angle.

    Arguments are those of `reversing_of_any_car`. Where turns agree with the angle in some motions and mirror it in
    others, or signed speeds differ in sign, the car reversed in the shorter ones; where all are alike, it went forward.
    """
    wheels = [columns.get(f"wheel_speed_rear_{side}") for side in ("left", "right")]
    speed = columns.get("vehicle_speed") if wheels[0] is None or wheels[1] is None else 0.5 * (wheels[0] + wheels[1])
    yaw, angle = columns.get("yaw_rate"), columns.get("steering_wheel_angle")
    none = np.zeros(len(time), bool)
    if speed is not None and (backward := speed < -_ANY_CAR.standing).any():
        forward = speed > _ANY_CAR.standing
        return backward if backward.sum() <= forward.sum() else forward
    if speed is None or yaw is None or angle is None:
        return none
    kinds = []
    for sign in (1.0, -1.0):
        made = Reversing(rate, STEERING_RATIO, WHEELBASE, replace(_ANY_CAR, fastest=np.inf))
        mirrored = made.add(time, sign * yaw, angle, speed)
        slow = not mirrored.any() or float(np.nanmax(speed[mirrored])) <= _ANY_CAR.fastest
        kinds.append((mirrored.sum(), slow, mirrored))
    if not all(count for count, _, _ in kinds):
        return none
    return min(((count, mirrored) for count, slow, mirrored in kinds if slow), default=(0, none), key=lambda k: k[0])[1]
