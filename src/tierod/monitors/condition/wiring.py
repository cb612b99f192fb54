"""What was wired, scaled or timed wrongly from the start: no fault of a sensor, and no condition to be judged in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any, NamedTuple

import numpy as np

from tierod.models.automated_parameters import AutomatedParameters
from tierod.monitors.odd_one_out import Pair, odd_ones_out

MOVING = 2.0
"""Speed from which on a turn tells something [m/s]."""
GENTLE = 3.0
"""Lateral acceleration up to which the steering angle tells the yaw rate by geometry [m/s^2]."""
LEAST_TURNING = 5.0
"""Time of turning that a part needs [s]."""
PARTS = 3
"""Of the beginning, each of which must show what is wrong."""
TURNING = 0.05
"""Yaw rate from which on the vehicle turns [rad/s]."""
KEPT = 180.0
"""Beginning of the drive that is looked at [s]: what was wired wrongly was so from the start."""
SMOOTH = 0.3
"""Time over which signals are averaged [s]."""
STEP = 0.04
"""Between two values that are compared [s]."""
CLEAR, TIGHT = 0.6, 0.95
"""Correlations from which on signs, and scales, are told."""
_SCALE = 1.4
"""Ratio of the sizes of two signals from which on a scale is called wrong; tyres, radii and slopes make up to 1.34."""
LATEST, _LATE = 1.0, 0.15
"""Shifts in time that are searched, and from which on one is called wrong [s]; motion itself lags by up to 0.1 s."""


class Close(NamedTuple):
    """What sensors of a calibrated vehicle do not differ by: three hours of healthy driving show 1.144 and 0.03 s.

    Args:
        scale, late: as in `Wiring`
    """

    scale: float = 1.17
    late: float = 0.045


class Problem(NamedTuple):
    """Something that is wrong with the recording or the vehicle file.

    Args:
        kind: sign, time or scale
        elements: sensors that it concerns
        cause: what it is
        action: what to do
    """

    kind: str
    elements: tuple[str, ...]
    cause: str
    action: str


@dataclass(frozen=True)
class Witness:
    """A signal, or several, that tell a quantity.

    Args:
        elements: sensors behind it
        tells: the quantity from the signals by name, (n,)
        turned: what a wrong sign of it means
        scaled: what a wrong size of it means
        lead: by which it comes before the vehicle turns [s]
    """

    elements: tuple[str, ...]
    tells: Callable[[Mapping[str, np.ndarray], Any], np.ndarray]
    turned: str
    scaled: str = ""
    lead: float = 0.0


def _speed(signals: Mapping[str, np.ndarray]) -> np.ndarray:
    return 0.5 * (signals["wheel_speed_rear_left"] + signals["wheel_speed_rear_right"])


def _over_speed(value: np.ndarray, signals: Mapping[str, np.ndarray]) -> np.ndarray:
    return value / np.maximum(_speed(signals), MOVING)


YAW: Mapping[str, Witness] = {
    "rear wheels": Witness(
        ("wheel_speed_rear_left", "wheel_speed_rear_right"),
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
        lambda s, p: s["steering_wheel_angle"] * p.steering_ratio * _speed(s) / (p.front_distance + p.rear_distance),
        "the steering angle has the wrong sign",
        "the steering ratio of the vehicle file, or the unit of the steering angle, is wrong",
        0.1,
    ),
    "lateral acceleration": Witness(
        (),
        lambda s, p: _over_speed(s["lateral_acceleration"], s),
        "the lateral acceleration has the wrong sign",
        "the lateral acceleration has the wrong unit or scale",
        0.1,
    ),
}
"""What tells the yaw rate."""

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
"""What tells the torque that the tie rods take; friction lies between them, so that sizes are not compared."""


def _spring(signals: Mapping[str, np.ndarray], vehicle: Any) -> np.ndarray:
    return vehicle.rack_ratio**2 * vehicle.rack_stiffness * signals["steering_wheel_angle"]


class Wiring:
    """Looks at the beginning of a drive for what was connected or described wrongly.

    Args:
        vehicle: its parameters
        rate: of the samples [Hz]
        scale: ratio of sizes from which on one is wrong
        late: shift in time from which on one is wrong [s]
        close: tighter limits, between sensors alone, for a vehicle that is calibrated; None for another
    """

    def __init__(
        self,
        vehicle: AutomatedParameters,
        rate: float,
        scale: float = _SCALE,
        late: float = _LATE,
        close: Close | None = None,
    ):
        self.vehicle, self.rate, self.scale, self.late, self.close = vehicle, rate, scale, late, close
        self._pieces: list[dict[str, np.ndarray]] = []
        self._kept = 0

    def add(self, signals: Mapping[str, np.ndarray]) -> None:
        """The next piece, signals by name, (n,) each; NaN where missing."""
        left = round(KEPT * self.rate) - self._kept
        if left > 0:
            piece = {name: np.array(values[:left]) for name, values in signals.items()}
            self._kept += len(next(iter(piece.values())))
            self._pieces.append(piece)

    def problems(self) -> tuple[Problem, ...]:
        """What is wrong; empty where nothing is, or where the drive turned too little to tell.

        It must be wrong in every part of the beginning: what becomes wrong on the way is a fault.
        """
        if not self._pieces:
            return ()
        whole = {name: np.concatenate([piece[name] for piece in self._pieces]) for name in self._pieces[0]}
        edges = np.linspace(0, self._kept, PARTS + 1).astype(int)
        parts = [slice(start, stop) for start, stop in pairwise(edges)]
        each = [self._problems({name: values[part] for name, values in whole.items()}) for part in parts]
        told = [{(found.kind, found.elements) for found in problems} for problems in each if problems is not None]
        if len(told) < PARTS:
            return ()
        return tuple(
            found for found in self._problems(whole) or () if all((found.kind, found.elements) in part for part in told)
        )

    def _problems(self, signals: Mapping[str, np.ndarray]) -> tuple[Problem, ...] | None:
        """Of a stretch; None where it turned too little to tell."""
        with np.errstate(invalid="ignore"):
            moving = _speed(signals) > MOVING
            turning = moving & (np.abs(signals["yaw_rate"]) + np.abs(_difference(signals, self.vehicle)) > TURNING)
        if np.count_nonzero(turning) < LEAST_TURNING * self.rate:
            return None
        gentle = moving & ~(np.abs(signals["lateral_acceleration"]) > GENTLE)
        yaw, slowly = self._told(YAW, signals, moving), self._told(YAW, signals, gentle)
        found = _turned(yaw, YAW) or _late(yaw, self.late) or _scaled(slowly, YAW, self.scale)
        if self.close is not None and not found:
            found = _late(_sensed(yaw), self.close.late) or _scaled(_sensed(slowly), YAW, self.close.scale)
        return found or _turned(self._told(TORQUE, signals, moving), TORQUE)

    def _told(
        self, witnesses: Mapping[str, Witness], signals: Mapping[str, np.ndarray], when: np.ndarray
    ) -> dict[str, np.ndarray]:
        """What every witness tells, smooth and about its mean; NaN where it may not count."""
        width = max(round(SMOOTH * self.rate), 1)
        told = {}
        for name, witness in witnesses.items():
            value = np.where(when, witness.tells(signals, self.vehicle), np.nan)
            if np.count_nonzero(np.isfinite(value)) > LEAST_TURNING * self.rate:
                smooth = np.convolve(value, np.full(width, 1.0 / width), "same")[:: max(round(STEP * self.rate), 1)]
                told[name] = smooth - np.nanmean(smooth)
        return told


def _sensed(told: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Only what sensors tell that are judged: slopes and banks do not disturb them."""
    return {name: values for name, values in told.items() if YAW[name].elements}


def _late(told: Mapping[str, np.ndarray], limit: float) -> tuple[Problem, ...]:
    """Who comes late, or early, beside the others."""
    shifts = {}
    for one, other in combinations(told, 2):
        shift = _shift(told[one], told[other])
        if shift is not None:
            shifts[one, other] = shift - (YAW[one].lead - YAW[other].lead)
    odd = odd_ones_out(tuple(told), {pair: abs(shift) < limit for pair, shift in shifts.items()})
    if len(odd) != 1:
        return ()
    by = [(-shift if pair[0] == odd[0] else shift) for pair, shift in shifts.items() if odd[0] in pair]
    late = float(np.median(by))
    cause = f"{odd[0]}: {abs(late):.2f} s {'late' if late > 0.0 else 'early'} beside the other signals"
    action = "check the time stamps: the channel may come from another bus with a clock of its own"
    return (Problem("time", YAW[odd[0]].elements, cause, action),)


def _shift(one: np.ndarray, other: np.ndarray) -> float | None:
    """By how much the second follows the first [s]; None where they do not go together at any shift."""
    most = round(LATEST / STEP)
    inner = one[most : len(one) - most]
    shifts = range(-most, most + 1)
    values = [_correlation(inner, other[most + shift : len(other) - most + shift]) for shift in shifts]
    best = int(np.argmax(values))
    return (shifts[best] + _vertex(values, best)) * STEP if values[best] > TIGHT else None


def _vertex(values: list[float], best: int) -> float:
    """Where a parabola through the highest value and both beside it is highest, in steps from it."""
    if not 0 < best < len(values) - 1:
        return 0.0
    before, top, after = values[best - 1 : best + 2]
    bend = before - 2.0 * top + after
    return 0.5 * (before - after) / bend if bend < 0.0 else 0.0


def _difference(signals: Mapping[str, np.ndarray], vehicle: AutomatedParameters) -> np.ndarray:
    return YAW["rear wheels"].tells(signals, vehicle)


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    both = np.isfinite(one) & np.isfinite(other)
    x, y = one[both], other[both]
    size = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / size if size > 0.0 else 0.0


def _turned(told: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness]) -> tuple[Problem, ...]:
    found = {pair: _correlation(told[pair[0]], told[pair[1]]) for pair in combinations(told, 2)}
    odd = odd_ones_out(tuple(told), {pair: value > 0.0 for pair, value in found.items() if abs(value) > CLEAR})
    if len(odd) != 1:
        return ()
    witness = witnesses[odd[0]]
    return (Problem("sign", witness.elements, witness.turned, "correct the channel map"),)


def _scaled(told: Mapping[str, np.ndarray], witnesses: Mapping[str, Witness], limit: float) -> tuple[Problem, ...]:
    ratios: dict[Pair, float] = {}
    for pair in combinations(told, 2):
        one, other = (told[name] for name in pair)
        if _correlation(one, other) > TIGHT:
            both = np.isfinite(one) & np.isfinite(other)
            ratios[pair] = float(np.sqrt((one[both] @ one[both]) / (other[both] @ other[both])))
    odd = odd_ones_out(tuple(told), {pair: 1.0 / limit < ratio < limit for pair, ratio in ratios.items()})
    if len(odd) != 1:
        return ()
    witness = witnesses[odd[0]]
    by = [(ratio if pair[0] == odd[0] else 1.0 / ratio) for pair, ratio in ratios.items() if odd[0] in pair]
    cause = f"{witness.scaled}: it reads {np.median(by):.3g} times what the others tell"
    return (Problem("scale", witness.elements, cause, "correct the vehicle file or the channel map"),)
