"""Checks of a car that is judged by its motion: slip of whole axles, and a slow shift of the steering angle's zero."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.series import LastRead, runs
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.accelerations import AGREE, Blocks
from tierod.monitors.condition.rolling_filter import SLIPPERIEST
from tierod.monitors.condition.signals import ALL_WHEELS
from tierod.monitors.condition.wiring import YAW, YAW_SENSOR, mean_speed
from tierod.physics.motion import steady_yaw_gain, understeer_gradient

AXLES = ("front", "rear")
SPUN, SKIDDED = "spun", "skidded"
_PLACES = [[place for place, name in enumerate(ALL_WHEELS) if axle in name] for axle in AXLES]
_ALL = "all"
_SHOWN = 3  # largest number of slips that a sentence names


@dataclass(frozen=True)
class AxleSlipLimits:
    """Limits from which both wheels of an axle slip.

    Tyres accelerate and brake a car by their friction alone. The speed of each axle therefore bounds that of the car at
    all later times; an axle of which both wheels are beyond these bounds slips. In a bend one front wheel is always
    slower than one rear wheel, so that neither yaw rate nor steering angle is needed.
    """

    # largest acceleration of a car along the road; 1.1 g is the most that tyres of road cars transmit
    acceleration: Annotated[float, "m/s**2"] = 11.0
    share: Annotated[float, ""] = 0.25  # slip from which it counts, as a share of the speed; the filters allow for less
    least: Annotated[float, "m/s"] = 0.8  # the same at small speed; wheel speed sensors end at 0.3 to 0.8 m/s
    agrees: Annotated[float, ""] = 0.5  # share of these limits up to which the axles differ while neither slips
    # time after a slip in which it still counts, since tyres slip less but far from usually
    recovers: Annotated[float, "s"] = 1.0
    # alike, alike_least: difference of both wheels of an axle from both of the other one, as a share of the speed and
    # beside it, from which no single wheel of it is wrong; front wheels on their wider way differ by 4 % in a bend of
    # 10 m, and rough roads and coarse readings by some .1 m/s
    alike: Annotated[float, ""] = 0.04
    alike_least: Annotated[float, "m/s"] = 0.3
    longest: Annotated[float, "s"] = 15.0  # longest slip; two wheel sensors that fail alike stay wrong for longer
    fresh: Annotated[float, "s"] = 0.25  # longest time for which a reading holds; chassis buses send every 10 to 100 ms


class Slip(NamedTuple):
    """Slip of both wheels of an axle, or of all wheels."""

    axle: str  # "front", "rear", or "all"
    kind: str  # `SPUN` or `SKIDDED`
    start: float  # start, end: first and last sample of it [s]
    end: float


class AxleSlip:
    """Recognises piece by piece when both wheels of an axle spin or skid; the cut into pieces does not matter."""

    def __init__(self, limits: AxleSlipLimits | None = None):
        self._limits = limits or AxleSlipLimits()
        self._read = LastRead(len(ALL_WHEELS), self._limits.fresh)
        self._bounds = np.array([np.inf, -np.inf])
        self._time = self._agreed = 0.0
        self._begun, self._last = np.nan, -np.inf
        self._found: list[Slip] = []
        self.alike: dict[str, list[tuple[float, float]]] = {axle: [] for axle in AXLES}
        """Bounds of the times in which both wheels of each axle are faster, or slower, than the other axle [s]."""

    @property
    def found(self) -> tuple[Slip, ...]:
        """Slips in the order of time; those of one axle with hardly any time between them are one."""
        merged: list[Slip] = []
        for each in self._found:
            before = next((other for other in reversed(merged) if other[:2] == each[:2]), None)
            if before is not None and each.start - before.end < self._limits.recovers:
                merged[merged.index(before)] = before._replace(end=each.end)
            else:
                merged.append(each)
        return tuple(merged)

    def add(self, time: np.ndarray, wheels: np.ndarray) -> np.ndarray:
        """Add the next piece, and return whether an axle slips, or did shortly before, at each sample, (n,)."""
        if not len(time):
            return np.zeros(0, bool)
        limits, speeds = self._limits, np.abs(self._read.held(time, wheels))
        slower, faster = (np.array([pick(speeds[:, each], axis=1) for each in _PLACES]) for pick in (np.min, np.max))
        self._compare(time, slower, faster)
        speed = self._speed(slower, faster)
        least, most = self._bounded(time, slower, faster, np.isfinite(speed))
        with np.errstate(invalid="ignore"):
            spins = slower > least * (1.0 + limits.share) + limits.least
            skids = most > faster * (1.0 + limits.share) + limits.least
        slips = np.zeros(len(time), bool)
        values = np.concatenate(([self._agreed], speed))
        agreed = values[np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), 0))][1:]
        self._agreed = float(agreed[-1])
        there = np.asarray((spins | skids).any(axis=0))
        if not there[0]:
            self._begun = np.nan
        for start, stop in zip(*runs(there), strict=True):
            goes_on = start == 0 and np.isfinite(self._begun)
            self._begun = self._begun if goes_on else float(time[start])
            counts = time[start:stop] - self._begun <= limits.longest
            slips[start:stop] = counts
            if counts.any():
                end = float(time[start:stop][counts][-1])
                if goes_on:
                    self._found[-1] = self._found[-1]._replace(end=end)
                else:
                    mean = 0.5 * (slower + faster)[:, start] - agreed[start]
                    self._found.append(Slip(*_named(spins[:, start], skids[:, start], mean), self._begun, end))
            if stop < len(time):
                self._begun = np.nan
        last = np.maximum.accumulate(np.where(slips, time, self._last))
        self._last = float(last[-1])
        return np.asarray(time - last <= limits.recovers)

    def _compare(self, time: np.ndarray, slower: np.ndarray, faster: np.ndarray) -> None:
        """Add the times in which both wheels of an axle differ from the other axle in the same direction."""
        for place, times in enumerate(self.alike.values()):
            with np.errstate(invalid="ignore"):
                least = self._limits.alike * faster[1 - place] + self._limits.alike_least
                differs = (slower[place] > faster[1 - place] + least) | (faster[place] < slower[1 - place] - least)
            for start, stop in zip(*runs(differs), strict=True):
                begin, end = float(time[start]), float(time[stop - 1])
                if times and begin - times[-1][1] < self._limits.recovers:
                    begin = times.pop()[0]
                times.append((begin, end))

    def _speed(self, slower: np.ndarray, faster: np.ndarray) -> np.ndarray:
        """Speed of the car where both axles agree, or where only one is read, (n,); NaN elsewhere."""
        means = 0.5 * (slower + faster)
        there = np.isfinite(means)
        speed = np.where(there, means, 0.0).sum(axis=0) / np.where(there.any(axis=0), there.sum(axis=0), np.nan)
        with np.errstate(invalid="ignore"):
            differ = np.abs(means[0] - means[1]) > self._limits.agrees * (
                self._limits.share * speed + self._limits.least
            )
        return np.where(differ, np.nan, speed)

    def _bounded(
        self, time: np.ndarray, slower: np.ndarray, faster: np.ndarray, agree: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest speed of the car by any axle now, and by both before, (n,)."""
        gained = self._limits.acceleration * (time - self._time)
        lowest, highest = np.nan_to_num(faster, nan=np.inf).min(axis=0), np.nan_to_num(slower, nan=-np.inf).max(axis=0)
        past = (np.where(agree, lowest - gained, np.inf), np.where(agree, highest + gained, -np.inf))
        least = np.minimum(np.minimum.accumulate(past[0]), self._bounds[0]) + gained
        most = np.maximum(np.maximum.accumulate(past[1]), self._bounds[1]) - gained
        self._bounds, self._time = np.array([least[-1], most[-1]]), float(time[-1])
        return np.minimum(least, lowest), np.maximum(most, highest)


def _named(spins: np.ndarray, skids: np.ndarray, gained: np.ndarray) -> tuple[str, str]:
    """Axle and kind of a slip that begins, (2,) each; `gained` is the change since both axles agreed [m/s]."""
    if spins.any() and skids.any():
        # One axle bounds the other: the axle that has changed its speed by more is the one that slips.
        place = int(np.argmax(np.abs(gained)))
        return AXLES[place], SPUN if gained[place] > 0.0 else SKIDDED
    flags, kind = (spins, SPUN) if spins.any() else (skids, SKIDDED)
    return _ALL if flags.all() else AXLES[int(np.argmax(flags))], kind


def slips_in_words(found: Sequence[Slip]) -> str:
    """Sentence on the times in which both wheels of an axle spun or skidded; "" if they never did."""
    if not found:
        return ""
    named = ", ".join(
        f"{'all wheels' if each.axle == _ALL else f'wheels of the {each.axle} axle'} {each.kind} from {each.start:.1f} "
        f"to {each.end:.1f} s"
        for each in found[:_SHOWN]
    )
    return f"{named} and {len(found) - _SHOWN} more times" if len(found) > _SHOWN else named


WINDOW = 60
"""Number of blocks of half a second in a mean zero: long enough for bends to both sides, and for wind and road to
change."""
APART = 6  # number of independent zeros among these: bends and banks last some seconds
LEAST = 0.2
"""Least shift of the zero that is a fault [rad]. Without a fault, a road bank of 4 % shifts it by .02, a flat tyre by
.1, an understeer gradient with an error of half its value by .08 at 2 m/s**2; 34 drives of 21 virtual cars with
parameters from brochures (seeds below 100) show .06 at most."""
LEAST_OF_YAW = 0.1
"""The same for a yaw rate that angle and wheels contradict alike [rad]: wind, bank and understeer act on the angle
alone, a flat tyre on the wheels alone."""
SLOWEST = 5.0  # least speed for the estimation of the zero [m/s]; below it the angles of manoeuvring are large
SURELY = 3.0  # number of standard deviations that exclude the other sensor as the cause [-]
SHIFTING = ("steering_wheel_angle", "yaw_rate")  # Sensors of which either may shift the zero


class ZeroShift(NamedTuple):
    """Shift of the zero."""

    suspects: tuple[str, ...]  # sensor that contradicts the rear wheels, or both if they cannot isolate it
    start: Annotated[float, "s"]  # time at which the zero had shifted by half of the shift
    found: Annotated[float, "s"]  # time of the detection
    end: Annotated[float, "s"] | None  # time at which it had shifted back by half; None if it lasts
    value: float  # change of the suspect's mean reading, of the angle if there are two [unit of the reading]
    deviation: float  # standard deviation of that change


class _Change(NamedTuple):
    """Changes of the zero, of the yaw rate against the wheels, and of the zero by that, with their deviations."""

    suspects: tuple[str, ...]
    value: list[float]
    deviation: list[float]


class SteeringZero:
    """Compares the zero of the steering angle with that at the beginning of the drive.

    The zero of a block is the angle less that of a steady turn with the measured yaw rate. Only gentle turns count, in
    which yaw rate and angle both require less lateral acceleration than every road permits, so that no tyre slides. A
    wrong yaw rate shifts the zero as a wrong angle does. The rear wheels isolate the sensor if the change of
    the yaw rate against them excludes the other one.
    """

    def __init__(self, vehicle: RollingCar.Parameters, rate: float):
        p = self._vehicle = vehicle
        self._blocks = Blocks(rate)
        self._gradient = understeer_gradient(
            p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, p.rear_cornering_stiffness
        )
        self._rows: list[tuple[float, float, float, float]] = []
        self._found, self._most = np.nan, 0.0

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        cut, ends = self._blocks.add(time, signals)
        if not ends:
            return
        p = self._vehicle
        read = (*(YAW[name].estimate(cut, p) for name in (YAW_SENSOR, "rear wheels")), mean_speed(cut))
        yaw, rolled, speed, angle = (self._blocks.line(each)[0] for each in (*read, cut["steering_wheel_angle"]))
        yaw, rolled = yaw - p.yaw_rate_offset, rolled - p.wheel_speed_difference * speed / p.track_width
        speed = speed / p.wheel_speed_scale
        # A negative gradient would have a critical speed, at which the gain is infinite.
        gain = p.steering_ratio * steady_yaw_gain(speed, p.front_distance + p.rear_distance, max(self._gradient, 0.0))
        with np.errstate(invalid="ignore", divide="ignore"):
            zero, apart = angle - yaw / gain, yaw - rolled
            gentle = np.maximum(np.abs(speed * yaw), np.abs(speed * gain * angle)) < SLIPPERIEST
            counts = (speed > SLOWEST) & gentle & (np.abs(apart) < AGREE) & np.isfinite(zero)
        rows = np.column_stack((ends, zero, apart, -apart / np.where(counts, gain, np.nan)))[counts]
        for row in rows.tolist():
            self._rows.append(tuple(row))
            self._follow()

    def _follow(self) -> None:
        """Compare the last window with the first one, once they do not overlap."""
        if len(self._rows) < 2 * WINDOW:
            return
        last = self._changed(slice(len(self._rows) - WINDOW, None))
        shift = last.value[0]
        if np.isnan(self._found) and (
            abs(shift) > LEAST or (abs(shift) > LEAST_OF_YAW and last.suspects == SHIFTING[1:])
        ):
            self._found = self._rows[-1][0]
        self._most = max(self._most, shift, key=abs)

    def _changed(self, inside: slice) -> _Change:
        first, last = np.array(self._rows[:WINDOW])[:, 1:], np.array(self._rows[inside])[:, 1:]
        value, deviation = last.mean(axis=0) - first.mean(axis=0), np.hypot(last.std(axis=0), first.std(axis=0))
        deviation /= np.sqrt(APART)
        # Share of the shift that the yaw rate causes by the rear wheels: none if the angle is wrong, else all of it.
        share, doubt = value[2] / value[0], SURELY * deviation[2] / abs(value[0])
        suspects = SHIFTING[:1] if share + doubt < 0.5 else SHIFTING[1:] if share - doubt > 0.5 else SHIFTING
        return _Change(suspects, value.tolist(), deviation.tolist())

    @property
    def found(self) -> ZeroShift | None:
        if np.isnan(self._found):
            return None
        ends, zeros = np.array(self._rows).T[:2]
        moved = (zeros - zeros[:WINDOW].mean()) / self._most > 0.5
        # The stretch with the largest surplus of moved blocks; single ones may be on either side of the half.
        surplus = np.concatenate(([0], np.cumsum(np.where(moved, 1, -1))))
        risen = surplus - np.minimum.accumulate(surplus)
        stop = len(risen) - 1 - int(np.argmax(risen[::-1]))
        first = int(np.argmin(surplus[: stop + 1]))
        change = self._changed(slice(max(first, stop - WINDOW), stop))
        # Blocks of one bend or bank are no end.
        until = float(ends[stop - 1]) if len(moved) - stop > WINDOW // APART else None
        of = int(change.suspects == SHIFTING[1:])
        return ZeroShift(
            change.suspects, float(ends[first]), self._found, until, change.value[of], change.deviation[of]
        )
