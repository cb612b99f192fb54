"""Wrong wiring, scale or time base from the start, and a clock that leaps during the drive: no faults of sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Episode
from tierod.methods.relations import Pair, odd_ones_out
from tierod.methods.running import Moments, peak
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.signals import OF_AUTOMATED, SENSORS, WHEELS, CarParameters
from tierod.physics.motion import understeer_gradient

MOVING = 2.0  # speed from which a turn shows in the estimates [m/s]


@dataclass(frozen=True)
class Witness:
    """One estimate of a quantity, from one or several signals."""

    elements: tuple[str, ...]  # sensors that it uses
    # function that gives the quantity from the signals by name, (n,)
    estimate: Callable[[Mapping[str, np.ndarray], CarParameters], np.ndarray]
    turned: str  # meaning of a wrong sign, in words
    scaled: str = ""  # meaning of a wrong scale, in words
    lead: float = 0.0  # time by which it precedes the yaw rate of the vehicle [s]


def mean_speed(signals: Mapping[str, np.ndarray]) -> np.ndarray:
    """Mean speed of both rear wheels, or speed of the one that is present; signals by name, (n,) each."""
    left, right = signals["wheel_speed_rear_left"], signals["wheel_speed_rear_right"]
    return 0.5 * (np.where(np.isfinite(left), left, right) + np.where(np.isfinite(right), right, left))


def _speed(signals: Mapping[str, np.ndarray], vehicle: CarParameters) -> np.ndarray:
    """Speed of the vehicle, corrected by the known scale of its wheel speeds [m/s]."""
    return mean_speed(signals) / vehicle.wheel_speed_scale


YAW_SENSOR, TIMES_SPEED, OVER_SPEED = "yaw rate sensor", ("rear wheels", "steering angle"), "lateral acceleration"
"""Witnesses of the yaw rate: independent of the speed, proportional to it, and inversely proportional to it."""

YAW: dict[str, Witness] = {
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


def _understeering(signals: Mapping[str, np.ndarray], vehicle: CarParameters) -> np.ndarray:
    """Yaw rate by the steering angle with the understeer of the vehicle file, none where it has no tyres [rad/s]."""
    by_geometry = YAW["steering angle"].estimate(signals, vehicle)
    if not isinstance(vehicle, RollingCar.Parameters):
        return by_geometry
    p = vehicle
    stiffness = p.front_cornering_stiffness, p.rear_cornering_stiffness
    gradient = max(float(understeer_gradient(p.mass, p.front_distance, p.rear_distance, *stiffness)), 0.0)
    return by_geometry / (1.0 + gradient * _speed(signals, vehicle) ** 2 / (p.front_distance + p.rear_distance))


UNDERSTEERING: Mapping[str, Witness] = YAW | {"steering angle": replace(YAW["steering angle"], estimate=_understeering)}
"""The same with the understeer of the vehicle file, which lets a car turn half as much at 25 m/s as by geometry."""

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


def _spring(signals: Mapping[str, np.ndarray], vehicle: CarParameters) -> np.ndarray:
    return vehicle.rack_ratio**2 * vehicle.rack_stiffness * signals["steering_wheel_angle"]


STEP = 0.04  # sampling interval of the comparison [s]
LATEST = 1.0  # largest shift in time that is searched, in either direction [s]
CLEAR, TIGHT = 0.6, 0.95  # correlation from which signs are compared, and from which shifts and scales are compared [-]


class Problem(NamedTuple):
    """Defect of the recording or of the vehicle file."""

    kind: str  # "sign", "time", "scale" or "rate"
    elements: tuple[str, ...]  # sensors that it concerns
    cause: str  # description
    action: str  # remedy


Odd = tuple[str, dict[bool, list[float]]]


def _odd_one(found: Mapping[Pair, float], agrees: Callable[[float], bool]) -> Odd | None:
    """The one estimate that contradicts the others, and the numbers of its pairs by whether it is the first."""
    names = tuple(dict.fromkeys(name for pair in found for name in pair))
    odd = odd_ones_out(names, {pair: agrees(value) for pair, value in found.items()})
    if len(odd) != 1:
        return None
    numbers = {place: [value for pair, value in found.items() if pair[not place] == odd[0]] for place in (True, False)}
    return odd[0], numbers


def _pairs(estimates: Mapping[str, np.ndarray], compare: Callable[..., float | None]) -> dict[Pair, float]:
    found = {pair: compare(*(estimates[name] for name in pair)) for pair in combinations(estimates, 2)}
    return {pair: value for pair, value in found.items() if value is not None}


def turned(estimates: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness]) -> tuple[Problem, ...]:
    """Problem that one estimate has the wrong sign; empty if none or several may have it."""
    clear = {pair: value for pair, value in _pairs(estimates, _correlation).items() if abs(value) > CLEAR}
    odd = _odd_one(clear, lambda value: value > 0.0)
    if odd is None:
        return ()
    witness = witnesses[odd[0]]
    return (Problem("sign", witness.elements, witness.turned, "correct the channel map"),)


def late(estimates: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness], limit: float) -> tuple[Problem, ...]:
    """Problem that one estimate is delayed, or early, against the others; empty if none or several may be."""
    shifts = _pairs(estimates, _shift)
    leads = {name: witness.lead for name, witness in witnesses.items()}
    shifts = {(one, other): shift - (leads[one] - leads[other]) for (one, other), shift in shifts.items()}
    odd = _odd_one(shifts, lambda shift: abs(shift) < limit)
    if odd is None:
        return ()
    name, numbers = odd
    delay = float(np.median([*(-each for each in numbers[True]), *numbers[False]]))
    cause = f"{name}: {abs(delay):.2f} s {'late' if delay > 0.0 else 'early'} relative to the other signals"
    action = "check the time stamps: the channel may come from another bus with a clock of its own"
    return (Problem("time", witnesses[name].elements, cause, action),)


def _shift(one: np.ndarray, other: np.ndarray) -> float | None:
    """Delay of the second signal against the first [s]; None if they do not correlate at any shift."""
    most = round(LATEST / STEP)
    inner = one[most : len(one) - most]
    shifts = range(-most, most + 1)
    values = np.array([_correlation(inner, other[most + shift : len(other) - most + shift]) for shift in shifts])
    return peak(np.maximum(values, 0.0))[0] * STEP if values.max() > TIGHT else None


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    return Moments().add(one, other).correlation()


def scaled(estimates: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness], limit: float) -> tuple[Problem, ...]:
    """Problem that one estimate has the wrong scale; empty if none or several may have it."""
    odd = _odd_one(_pairs(estimates, _ratio), lambda ratio: 1.0 / limit < ratio < limit)
    if odd is None:
        return ()
    witness, numbers = witnesses[odd[0]], odd[1]
    times = np.median([*numbers[True], *(1.0 / each for each in numbers[False])])
    cause = f"{witness.scaled}: it is {times:.3g} times the value from the others"
    return (Problem("scale", witness.elements, cause, "correct the vehicle file or the channel map"),)


def _ratio(one: np.ndarray, other: np.ndarray) -> float | None:
    """Ratio of the amplitudes of both estimates; None if they do not correlate."""
    both = Moments().add(one, other)
    return both.ratio(1, 0) if both.correlation() > TIGHT else None


def misread_speed(estimates: Mapping[str, np.ndarray], limit: float) -> tuple[Problem, ...]:
    """Problem that the wheel speeds have the wrong scale; all estimates of the yaw rate but its sensor use them.

    If they read k times the truth, wheels and steering angle give k times the yaw rate, and the lateral acceleration
    gives it over k.
    """
    if not {YAW_SENSOR, *TIMES_SPEED, OVER_SPEED} <= set(estimates):
        return ()
    pairs = (*((name, YAW_SENSOR) for name in TIMES_SPEED), (YAW_SENSOR, OVER_SPEED))
    sizes = [size for one, other in pairs if (size := _ratio(estimates[one], estimates[other])) is not None]
    least, most = min(sizes, default=1.0), max(sizes, default=1.0)
    if not (len(sizes) == len(pairs) and most < limit * least and (least > limit or most < 1.0 / limit)):
        return ()
    cause = (
        f"the wheel speeds have the wrong unit or scale: they are {np.median(sizes):.3g} times the values from the "
        "others"
    )
    return (Problem("scale", WHEELS, cause, "correct their unit in the channel map; 1 m/s is 3.6 km/h"),)


GENTLE = 3.0  # largest lateral acceleration at which the steering angle gives the yaw rate by geometry [m/s^2]
LEAST_TURNING = 5.0  # least time of turning in each part of the beginning [s]
PARTS = 3  # number of parts of the beginning, each of which must show the same problem
TURNING = 0.05  # yaw rate from which the vehicle counts as turning [rad/s]
KEPT = 180.0  # length of the beginning of the drive that is checked [s]: wrong wiring is wrong from the start
SMOOTH = 0.3  # width of the moving average of the signals [s]
BRIDGED = 0.1
"""Longest gap between two readings that is interpolated linearly [s], since few buses have the rate of the grid."""
CLOSE_SCALE, CLOSE_LATE = 1.13, 0.045
"""Limits as in `Wiring` between sensors alone, for a calibrated vehicle [-], [s]: in fault-free drives of an hour
one sensor differs from both others by a factor of 1.07 and by 0.03 s, with tyres a tenth larger by a factor of 1.10."""


class Wiring:
    """Checks the beginning of a drive for signals that were connected or described wrongly."""

    # ratio of amplitudes from which a scale is wrong; tyres, radii and slopes cause up to 1.34
    scale: Annotated[float, ""] = 1.4
    # shift in time from which an estimate is wrong; the motion itself lags by up to 0.1 s
    late: Annotated[float, "s"] = 0.15

    def __init__(self, vehicle: CarParameters, rate: float, calibrated: bool = False):
        self.vehicle, self.rate, self.calibrated = vehicle, rate, calibrated
        self._pieces: list[dict[str, np.ndarray]] = []
        self._kept = 0

    def add(self, signals: Mapping[str, np.ndarray]) -> None:
        """Add the next piece, signals by name, (n,) each; NaN if missing."""
        left = round(KEPT * self.rate) - self._kept
        if left > 0:
            piece = {name: np.array(values[:left]) for name, values in signals.items()}
            self._kept += len(next(iter(piece.values())))
            self._pieces.append(piece)

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
        shown = [{(found.kind, found.elements) for found in problems} for problems in each if problems is not None]
        if len(shown) < PARTS:
            return ()
        return tuple(
            found
            for found in self._problems(whole) or ()
            if all((found.kind, found.elements) in part for part in shown)
        )

    def _problems(self, signals: Mapping[str, np.ndarray]) -> tuple[Problem, ...] | None:
        """Problems of a stretch; None if the car turned too little to show any."""
        if np.count_nonzero(self._turning(signals)) < LEAST_TURNING * self.rate:
            return None
        with np.errstate(invalid="ignore"):
            moving = mean_speed(signals) > MOVING
        gentle = moving & ~(np.abs(signals["lateral_acceleration"]) > GENTLE)
        yaw, slowly = self._estimates(YAW, signals, moving), self._estimates(YAW, signals, gentle)
        understeering = self._estimates(UNDERSTEERING, signals, gentle)
        misread = misread_speed(slowly, self.scale)
        # At the centre of gravity, a = v r + rear_distance dr/dt leads v r by rear_distance / v: samples in which that
        # exceeds twice the lead of the witness show no delay.
        fast = moving & (mean_speed(signals) > self.vehicle.rear_distance / (2.0 * YAW[OVER_SPEED].lead))
        timed = {name: each for name, each in yaw.items() if name != OVER_SPEED}
        timed |= self._estimates({OVER_SPEED: YAW[OVER_SPEED]}, signals, fast)
        found = turned(yaw, YAW) or late(timed, YAW, self.late) or misread
        found = found or _scaled(slowly, understeering, self.scale)
        if self.calibrated and not any(each.elements for each in found):
            near = late(_sensed(yaw), YAW, CLOSE_LATE)
            near = near or _scaled(_sensed(slowly), _sensed(understeering), CLOSE_SCALE)
            found = (*near, *found)
        return found or turned(self._estimates(TORQUE, signals, moving), TORQUE)

    def _turning(self, signals: Mapping[str, np.ndarray]) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            yaw = [YAW[name].estimate(signals, self.vehicle) for name in ("rear wheels", "yaw rate sensor")]
            return np.asarray((mean_speed(signals) > MOVING) & (np.nansum(np.abs(yaw), axis=0) > TURNING))

    def _estimates(
        self, witnesses: Mapping[str, Witness], signals: Mapping[str, np.ndarray], when: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Estimates of every witness, low-pass filtered and with their mean removed; NaN outside `when`."""
        width = max(round(SMOOTH * self.rate), 1)
        found = {}
        for name, witness in witnesses.items():
            value = np.where(when, witness.estimate(signals, self.vehicle), np.nan)
            if np.count_nonzero(np.isfinite(value)) > LEAST_TURNING * self.rate:
                smooth = np.convolve(value, np.full(width, 1.0 / width), "same")[:: max(round(STEP * self.rate), 1)]
                # One NaN spoils a whole window: with many pauses no mean may be left.
                if np.isfinite(smooth).any():
                    found[name] = smooth - np.nanmean(smooth)
        return found


def _bridged(values: np.ndarray, most: int) -> np.ndarray:
    """Values with gaps of up to `most` samples interpolated linearly; longer gaps stay NaN."""
    there = np.flatnonzero(np.isfinite(values))
    if not 1 < len(there) < len(values):
        return values
    place = np.arange(len(values))
    apart = np.concatenate(([len(values)], np.diff(there), [len(values)]))[np.searchsorted(there, place)]
    between = np.isnan(values) & (apart <= most)
    return np.where(between, np.interp(place, there, values[there]), values)


def _scaled(
    by_geometry: Mapping[str, np.ndarray], understeering: Mapping[str, np.ndarray], limit: float
) -> tuple[Problem, ...]:
    """Wrong scale that no understeer between none and that of the vehicle file, often a guess, explains."""
    without = {each.elements for each in scaled(by_geometry, YAW, limit)}
    return tuple(each for each in scaled(understeering, UNDERSTEERING, limit) if each.elements in without)


def _sensed(estimates: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Estimates of judged sensors only, which road slopes and banks do not affect."""
    return {name: values for name, values in estimates.items() if YAW[name].elements}


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

    def __init__(self, look: Callable[[], Wiring]):
        self._look = look
        self._wiring: Wiring | None = None
        self._since = 0.0

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], faulty: np.ndarray) -> None:
        first = 0
        if self._wiring is None:
            together = np.zeros(len(time), bool)
            for bus in BUSES:
                together |= faulty[:, [SENSORS.index(name) for name in bus]].sum(axis=1) >= 2
            if not together.any():
                return
            first = int(np.argmax(together))
            self._wiring, self._since = self._look(), float(time[first])
        self._wiring.add({name: values[first:] for name, values in signals.items()})

    def problems(self, episodes: Sequence[Episode]) -> tuple[Problem, ...]:
        """Problem that the buses have lost their common time base; empty if not, or if a fault began earlier."""
        if self._wiring is None or any(each.declared_at < self._since - BEFORE for each in episodes):
            return ()
        return tuple(
            found._replace(cause=f"{found.cause} since about {self._since:.0f} s")
            for found in self._wiring.problems()
            if found.kind == "time" and found.elements == ("steering_wheel_angle",)
        )
