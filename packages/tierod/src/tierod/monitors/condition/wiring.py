"""Wrong wiring, scale or time base from the start, and a clock that leaps during the drive: no faults of sensors."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, combinations, pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Episode
from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.methods.relations import odd_ones_out
from tierod.methods.running import Moments, peak
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.signals import OF_AUTOMATED, SENSORS, WHEELS, CarParameters
from tierod.monitors.decision import Decision, OwnRule, decides, declared
from tierod.physics.motion import understeer_gradient

MOVING = 2.0  # speed from which a turn shows in the estimates [m/s]

Signals = Mapping[str, np.ndarray]


class Witness(NamedTuple):
    """One estimate of a quantity, from one or several signals."""

    elements: tuple[str, ...]  # sensors that it uses
    estimate: Callable[[Signals, CarParameters], np.ndarray]  # the quantity from the signals by name, (n,)
    turned: str  # meaning of a wrong sign, in words
    scaled: str = ""  # meaning of a wrong scale, in words
    lead: float = 0.0  # time by which it precedes the yaw rate of the vehicle [s]


def mean_speed(signals: Signals) -> np.ndarray:
    """Mean speed of both rear wheels, or speed of the one that is present; signals by name, (n,) each."""
    left, right = signals["wheel_speed_rear_left"], signals["wheel_speed_rear_right"]
    return 0.5 * (np.where(np.isfinite(left), left, right) + np.where(np.isfinite(right), right, left))


def _speed(signals: Signals, vehicle: CarParameters) -> np.ndarray:
    """Speed of the vehicle, corrected by the known scale of its wheel speeds [m/s]."""
    return mean_speed(signals) / vehicle.wheel_speed_scale


YAW_SENSOR, TIMES_SPEED, OVER_SPEED = "yaw rate sensor", ("rear wheels", "steering angle"), "lateral acceleration"
"""Witnesses of the yaw rate: independent of the speed, proportional to it, and inversely proportional to it."""

YAW: Mapping[str, Witness] = {
    "rear wheels": Witness(
        WHEELS,
        lambda s, p: (s["wheel_speed_rear_right"] - s["wheel_speed_rear_left"]) / (p.wheel_speed_scale * p.track_width),
        "left and right rear wheel speeds are swapped",
        "the track width of the vehicle file, or the unit of the wheel speeds, is wrong",
    ),
    "yaw rate sensor": Witness(
        ("yaw_rate",),
        lambda s, p: s["yaw_rate"],
        "the yaw rate has the wrong sign",
        "the yaw rate has the wrong unit or scale",
    ),
    "steering angle": Witness(
        ("steering_wheel_angle",),
        lambda s, p: s["steering_wheel_angle"] * p.steering_ratio * _speed(s, p) / (p.front_distance + p.rear_distance),
        "the steering angle has the wrong sign",
        "the steering ratio of the vehicle file, or the unit of the steering angle, is wrong",
        0.1,
    ),
    "lateral acceleration": Witness(
        (),
        lambda s, p: s["lateral_acceleration"] / np.maximum(_speed(s, p), MOVING),
        "the lateral acceleration has the wrong sign",
        "the lateral acceleration has the wrong unit or scale",
        0.1,
    ),
}
"""Witnesses of the yaw rate [rad/s]."""

TORQUE: Mapping[str, Witness] = {
    "steering torque sensor": Witness(
        ("steering_shaft_torque",),
        lambda s, p: s["steering_shaft_torque"] - _spring(s, p),
        "the steering torque has the wrong sign",
    ),
    "targets of the steering motors": Witness(
        (),
        lambda s, p: s["steering_motor_1_target_torque"] + s["steering_motor_2_target_torque"] - _spring(s, p),
        "the target torques of the steering motors have the wrong sign",
    ),
    "tie-rod force": Witness(
        ("tie_rod_force",), lambda s, p: p.rack_ratio * s["tie_rod_force"], "the tie-rod force has the wrong sign"
    ),
}
"""Witnesses of the column torque by the tie rods [N*m]; they differ by friction, so that only signs are compared."""


def _spring(signals: Signals, vehicle: CarParameters) -> np.ndarray:
    return vehicle.rack_ratio**2 * vehicle.rack_stiffness * signals["steering_wheel_angle"]


class Problem(NamedTuple):
    """Defect of the recording or of the vehicle file."""

    kind: str  # "sign", "time", "scale" or "rate"
    elements: tuple[str, ...]  # sensors that it concerns
    cause: str  # description
    action: str  # remedy


LIKE_A_UNIT = 0.1  # relative difference up to which a scale is that of another unit [-]


def wrong_unit(names: Sequence[str], cause: str, times: float = math.nan) -> Problem:
    """Problem of a wrong scale; a factor of another unit names it: radians that hold degrees, m/s that hold km/h.

    Args:
        times: the values over the right ones [-]; NaN where the caller knows that the other unit explains them
    """
    factor, label = shown(SIGNALS[names[0]].unit)
    if factor == 1.0 or abs(times / factor - 1.0) > LIKE_A_UNIT:
        return Problem("scale", tuple(names), cause, "correct the vehicle file or the channel map")
    plain = " and ".join(each.replace("_", " ") for each in names)
    look = f"the values of {plain} look like {'degrees' if label == '°' else label}"
    return Problem("scale", tuple(names), f"{look}: {cause}", f"set the unit of {', '.join(names)} in the channel map")


STEP = 0.04  # sampling interval of the comparison [s]
LATEST = 1.0  # largest shift in time that is searched, in either direction [s]
CLEAR, TIGHT = 0.6, 0.95  # correlation from which signs are compared, and from which shifts and scales are compared [-]
GENTLE = 3.0  # largest lateral acceleration at which the steering angle gives the yaw rate by geometry [m/s^2]
LEAST_TURNING = 5.0  # least time of turning in each part of the beginning [s]
PARTS = 3  # number of parts of the beginning, each of which must show the same problem
TURNING = 0.05  # yaw rate from which the vehicle counts as turning [rad/s]
KEPT = 180.0  # length of the beginning of the drive that is checked [s]: wrong wiring is wrong from the start
SMOOTH = 0.3  # width of the moving average of the signals [s]
BRIDGED = 0.1
"""Longest gap between two readings that is interpolated linearly [s], since few buses have the rate of the grid."""


@dataclass(frozen=True)
class WiringLimits:
    """Differences of two estimates from which one of them is wrong."""

    # ratio of amplitudes from which a scale is wrong; tyres, radii and slopes cause up to 1.34
    scale: Annotated[float, ""] = 1.4
    # shift in time from which an estimate is wrong; the motion itself lags by up to 0.1 s
    late: Annotated[float, "s"] = 0.15
    # close_scale, close_late: the same between sensors alone, for a calibrated vehicle; in fault-free drives of an hour
    # one sensor differs from both others by a factor of 1.07 and by 0.03 s, by 1.10 with tyres a tenth larger
    close_scale: Annotated[float, ""] = 1.13
    close_late: Annotated[float, "s"] = 0.045


LIMITS = WiringLimits()
WIRED = Decision(
    name="wrong wiring, scale or time",
    distance="correlation, ratio and time shift of signals that measure the same quantity, over the first three "
    "minutes",
    rule=OwnRule(
        f"opposite signs, ratio of {LIMITS.scale:g}, or shift of {LIMITS.late:g} s, in each of three parts; "
        f"{LIMITS.close_scale:g} and {LIMITS.close_late:g} s once calibrated",
        vars(LIMITS),
    ),
    place="",
    mean_time_between_false_alarms=None,
    demonstrated=None,
    source="tierod.monitors.condition.wiring; its limits were chosen on healthy drives of three virtual demonstrators",
    unit="recording",
)

Compare = Callable[[np.ndarray, np.ndarray], float | None]


def _turned(one: np.ndarray, other: np.ndarray) -> float | None:
    """1 where two estimates have opposite signs, 0 where they have not; None if they do not correlate."""
    correlation = Moments().add(one, other).correlation()
    return float(correlation < 0.0) if abs(correlation) > CLEAR else None


def _ratio(one: np.ndarray, other: np.ndarray) -> float | None:
    """Logarithm of the ratio of two amplitudes; None if the estimates do not correlate."""
    both = Moments().add(one, other)
    return math.log(both.ratio(1, 0)) if both.correlation() > TIGHT else None


def _delay(one: np.ndarray, other: np.ndarray) -> float | None:
    """Delay of the first estimate against the second [s]; None if they do not correlate at any shift."""
    most = round(LATEST / STEP)
    inner, shifts = one[most : len(one) - most], range(-most, most + 1)
    cut = (other[most + shift : len(other) - most + shift] for shift in shifts)
    values = np.array([Moments().add(inner, each).correlation() for each in cut])
    return -peak(np.maximum(values, 0.0))[0] * STEP if values.max() > TIGHT else None


def _odd(estimates: Signals, compare: Compare, limit: float, leads: Mapping[str, Witness] = {}) -> tuple[str, float]:
    """The one estimate that differs from the others, and by how much; "" if none does, or several may.

    Args:
        limit: largest difference of consistent estimates
        leads: witnesses whose leads are no delay
    """
    found: dict[tuple[str, str], float] = {}
    for one, other in combinations(estimates, 2):
        value = compare(estimates[one], estimates[other])
        if value is not None:
            found[one, other] = value + (leads[one].lead - leads[other].lead if leads else 0.0)
    names = odd_ones_out(dict.fromkeys(chain(*found)), {pair: abs(value) < limit for pair, value in found.items()})
    if len(names) != 1:
        return "", 0.0
    differs = [value if pair[0] == names[0] else -value for pair, value in found.items() if names[0] in pair]
    return names[0], float(np.median(differs))


def turned(estimates: Signals, witnesses: Mapping[str, Witness]) -> tuple[Problem, ...]:
    name, _ = _odd(estimates, _turned, 0.5)
    if not name:
        return ()
    return (Problem("sign", witnesses[name].elements, witnesses[name].turned, "correct the channel map"),)


def late(estimates: Signals, limit: float) -> tuple[Problem, ...]:
    name, delay = _odd(estimates, _delay, limit, YAW)
    if not name:
        return ()
    cause = f"{name}: {abs(delay):.2f} s {'late' if delay > 0.0 else 'early'} relative to the other signals"
    action = "check the time stamps: the channel may come from another bus with a clock of its own"
    return (Problem("time", YAW[name].elements, cause, action),)


def scaled(by_geometry: Signals, understeering: Signals, limit: float) -> tuple[Problem, ...]:
    """Wrong scale that no understeer between none and that of the vehicle file, often a guess, explains."""
    name, size = _odd(understeering, _ratio, math.log(limit))
    if not name or name != _odd(by_geometry, _ratio, math.log(limit))[0]:
        return ()
    faster = math.exp(-size)
    if name == YAW_SENSOR and abs(faster / shown(SIGNALS[WHEELS[0]].unit)[0] - 1.0) < LIKE_A_UNIT:
        # Wheels and angle rest on the speed, and without the lateral acceleration only the yaw rate contradicts it.
        return (wrong_unit(WHEELS, f"they are {faster:.3g} times the values from the yaw rate", faster),)
    cause = f"{YAW[name].scaled}: it is {math.exp(size):.3g} times the value from the others"
    return (wrong_unit(YAW[name].elements or ("lateral_acceleration",), cause, math.exp(size)),)


def misread_speed(estimates: Signals, largest: float) -> tuple[Problem, ...]:
    """Problem that the wheel speeds have the wrong scale; all estimates of the yaw rate but its sensor use them.

    If they read k times the truth, wheels and steering angle give k times the yaw rate, and the lateral acceleration
    gives it over k.
    """
    if not {YAW_SENSOR, *TIMES_SPEED, OVER_SPEED} <= set(estimates):
        return ()
    pairs = (*((name, YAW_SENSOR) for name in TIMES_SPEED), (YAW_SENSOR, OVER_SPEED))
    sizes = [size for one, other in pairs if (size := _ratio(estimates[one], estimates[other])) is not None]
    limit = math.log(largest)
    if len(sizes) < len(pairs) or max(sizes) - min(sizes) > limit or not (min(sizes) > limit or max(sizes) < -limit):
        return ()
    times = math.exp(np.median(sizes))
    cause = f"the wheel speeds have the wrong unit or scale: they are {times:.3g} times the values from the others"
    return (wrong_unit(WHEELS, cause, times),)


@dataclass
class Wiring:
    """Checks the beginning of a drive for signals that were connected or described wrongly."""

    vehicle: CarParameters
    rate: float
    calibrated: bool = False
    limits: WiringLimits = field(default=LIMITS, metadata=decides(WIRED))
    _pieces: list[dict[str, np.ndarray]] = field(default_factory=list)
    _kept: int = 0

    @property
    def _gradient(self) -> float:
        """Understeer of the vehicle file over its wheelbase; none where it has no tyres."""
        p = self.vehicle
        if not isinstance(p, RollingCar.Parameters):
            return 0.0
        tyres = p.front_cornering_stiffness, p.rear_cornering_stiffness
        found = float(understeer_gradient(p.mass, p.front_distance, p.rear_distance, *tyres))
        return max(found, 0.0) / (p.front_distance + p.rear_distance)

    def add(self, signals: Signals) -> None:
        """Add the next piece, signals by name, (n,) each; NaN if missing."""
        left = round(KEPT * self.rate) - self._kept
        if left > 0:
            self._pieces.append({name: np.array(values[:left]) for name, values in signals.items()})
            self._kept += len(next(iter(self._pieces[-1].values())))

    def problems(self) -> tuple[Problem, ...]:
        """Problems of the wiring; empty if there are none, or if the drive turned too little to show any.

        A problem must show in every part of the beginning, each with the same time of turning: what begins later is a
        fault.
        """
        if not self._pieces:
            return ()
        most = round(BRIDGED * self.rate)
        whole = {
            name: _bridged(np.concatenate([each[name] for each in self._pieces]), most) for name in self._pieces[0]
        }
        turned_until = np.cumsum(self._turning(whole))
        edges = np.searchsorted(turned_until, np.linspace(0, turned_until[-1], PARTS + 1)[1:-1])
        parts = [slice(start, stop) for start, stop in pairwise((0, *edges.tolist(), self._kept))]
        each = [self._problems({name: values[part] for name, values in whole.items()}) for part in parts]
        alike = [{(found.kind, found.elements) for found in problems} for problems in each]
        return tuple(
            found for found in self._problems(whole) if all((found.kind, found.elements) in part for part in alike)
        )

    def _problems(self, signals: Signals) -> tuple[Problem, ...]:
        """Problems of a stretch; none if the car turned too little to show any."""
        if np.count_nonzero(self._turning(signals)) < LEAST_TURNING * self.rate:
            return ()
        with np.errstate(invalid="ignore"):
            moving = mean_speed(signals) > MOVING
            # At the centre of gravity, a = v r + rear_distance dr/dt leads v r by rear_distance / v: samples in which
            # that exceeds twice the lead of the witness show no delay.
            fast = moving & (mean_speed(signals) > self.vehicle.rear_distance / (2.0 * YAW[OVER_SPEED].lead))
            gentle = moving & ~(np.abs(signals["lateral_acceleration"]) > GENTLE)
        yaw, slowly = self._estimates(YAW, signals, moving), self._estimates(YAW, signals, gentle)
        understeering = slowly
        if self._gradient and "steering angle" in slowly:
            turns = 1.0 + self._gradient * _speed(signals, self.vehicle) ** 2
            understeering = slowly | self._estimates({"steering angle": YAW["steering angle"]}, signals, gentle, turns)
        timed = {name: each for name, each in yaw.items() if name != OVER_SPEED}
        timed |= self._estimates({OVER_SPEED: YAW[OVER_SPEED]}, signals, fast)
        limits = self.limits
        found = turned(yaw, YAW) or late(timed, limits.late) or misread_speed(slowly, limits.scale)
        found = found or scaled(slowly, understeering, limits.scale)
        if self.calibrated and not any(each.elements for each in found):
            # Judged sensors only, which road slopes and banks do not affect.
            yaw, slowly, understeering = (
                {name: each for name, each in estimates.items() if YAW[name].elements}
                for estimates in (yaw, slowly, understeering)
            )
            found = (*(late(yaw, limits.close_late) or scaled(slowly, understeering, limits.close_scale)), *found)
        return found or turned(self._estimates(TORQUE, signals, moving), TORQUE)

    def _turning(self, signals: Signals) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            yaw = [YAW[name].estimate(signals, self.vehicle) for name in ("rear wheels", "yaw rate sensor")]
            return np.asarray((mean_speed(signals) > MOVING) & (np.nansum(np.abs(yaw), axis=0) > TURNING))

    def _estimates(
        self, witnesses: Mapping[str, Witness], signals: Signals, when: np.ndarray, over: np.ndarray | float = 1.0
    ) -> dict[str, np.ndarray]:
        """Estimates of every witness, low-pass filtered and with their mean removed; NaN outside `when`."""
        width = max(round(SMOOTH * self.rate), 1)
        found = {}
        for name, witness in witnesses.items():
            value = np.where(when, witness.estimate(signals, self.vehicle) / over, np.nan)
            if np.count_nonzero(np.isfinite(value)) > LEAST_TURNING * self.rate:
                smooth = np.convolve(value, np.full(width, 1.0 / width), "same")[:: max(round(STEP * self.rate), 1)]
                # One NaN spoils a whole window: with many pauses no mean may be left.
                if np.isfinite(smooth).any():
                    found[name] = smooth - np.nanmean(smooth)
        return found


WIRING = declared(Wiring, "_wiring")
"""Decisions of a session about its wiring."""


def _bridged(values: np.ndarray, most: int) -> np.ndarray:
    """Values with gaps of up to `most` samples interpolated linearly; longer gaps stay NaN."""
    there = np.flatnonzero(np.isfinite(values))
    if not 1 < len(there) < len(values):
        return values
    place = np.arange(len(values))
    apart = np.concatenate(([len(values)], np.diff(there), [len(values)]))[np.searchsorted(there, place)]
    between = np.isnan(values) & (apart <= most)
    return np.where(between, np.interp(place, there, values[there]), values)


BUSES = (OF_AUTOMATED[:3], OF_AUTOMATED[3:])
"""Sensors that share a bus and its clock: those of the chassis, and those of the steering."""
BEFORE = 1.0
"""Time before the declaration of two sensors of one bus within which the first may have been declared alone [s]."""


class ClockLeap:
    """Tests for a shift in time between the buses after two sensors of one bus have been declared together.

    A single late sensor is a fault. If two sensors of one bus are declared, and the angle is late or early against the
    other estimates of the yaw rate, the bus has lost its time base. Two faults of which one is a delay of the angle
    look the same.
    """

    def __init__(self, wiring: Wiring):
        self._wiring = wiring
        self._since: float | None = None

    def add(self, time: np.ndarray, signals: Signals, faulty: np.ndarray) -> None:
        first = 0
        if self._since is None:
            places = ([SENSORS.index(name) for name in bus] for bus in BUSES)
            together = np.any([faulty[:, each].sum(axis=1) >= 2 for each in places], axis=0)
            if not together.any():
                return
            first = int(np.argmax(together))
            self._since = float(time[first])
        self._wiring.add({name: values[first:] for name, values in signals.items()})

    def problems(self, episodes: Collection[Episode]) -> tuple[Problem, ...]:
        """Problem that the buses have lost their common time base; empty if not, or if a fault began earlier."""
        since = self._since
        if since is None or any(each.declared_at < since - BEFORE for each in episodes):
            return ()
        return tuple(
            found._replace(cause=f"{found.cause} since about {since:.0f} s")
            for found in self._wiring.problems()
            if found.kind == "time" and found.elements == ("steering_wheel_angle",)
        )
