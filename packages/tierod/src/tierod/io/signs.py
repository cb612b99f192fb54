"""Warnings about signals that contradict each other by their signs or by their units, from `methods.relations`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.recording import Recording
from tierod.io.quality import impossible
from tierod.methods.detectors.reversing import MIRRORED, TURN_FORWARD, ReversingLimits, reversing_of_any_car
from tierod.methods.relations import RELATIONS, STRONG, compared, odd_ones_out, related
from tierod.methods.running import Moments

COMPARED = 3600.0  # length from the beginning that is compared [s]: a sign does not change, memory must stay bounded
RATE = 20.0  # of the comparison [Hz]
SMOOTHING = 1.0  # moving average [s]: below 1 Hz a car follows its steering without delay, above there are vibrations
SECONDS = 5.0  # shortest driving time that two signals must have in common [s]
SLOWEST = 2.0  # speed below which lateral acceleration and steering hold little information on the turn [m/s]
STRAIGHT = 0.002  # deviation of the smoothed yaw rate below which there were no turns, 5 times its noise [rad/s]
# Relations by the words for a place where signs are compared; each group votes by itself.
GROUPS = {"in turns": ("car", "bend", "turn"), "among the torques": ("assist",), "angle against rate": ("steering",)}
SIGNALS = sorted({name for keys in GROUPS.values() for key in keys for name in RELATIONS[key].signals})
WHEELS = ("wheel_speed_rear_left", "wheel_speed_rear_right")
NAMES = ("vehicle_speed", "yaw_rate", "lateral_acceleration")
KMH = 3.6
MAGNITUDE = " is never negative"  # words of the remark on a signal whose sign is in another column
SIGN_FROM = 'name the column of its sign in the channel map: sign_from = "COLUMN"'
TURNS = ("steering_wheel_angle", "yaw_rate", "lateral_acceleration")  # signals that a turn to the right makes negative
BOTH_SIDES = 0.1  # share of a drive to either side from which a signal goes to both [-]


def _columns(
    recording: Recording, names: tuple[str, ...], rate: float, age: float
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """(time, columns) of the first hour; empty without one of these signals."""
    known = Recording({name: recording[name] for name in names if name in recording and len(recording[name].time)})
    if not known.channels:
        return np.empty(0), {}
    aligned = known.slice(stop=known.span[0] + COMPARED).align(names, rate, maximum_age=age)
    return aligned.time, dict(aligned.columns)


def _smooth(values: np.ndarray, rate: float) -> np.ndarray:
    width = round(SMOOTHING * rate)
    return np.convolve(values, np.full(width, 1.0 / width), mode="same" if len(values) < width else "valid")


def sign_warnings(recording: Recording) -> tuple[str, ...]:
    """Warnings about signals whose sign contradicts that of the others.

    In turns, steering angle, yaw rate and lateral acceleration must agree, and so must driver and motor torque, and the
    steering rate and the change of the angle. With three signals the deviating one is named; with two, both. A car that
    reverses with unsigned speeds mirrors its yaw rate: there it is not compared.
    """
    time, columns = _columns(recording, (*SIGNALS, *WHEELS), RATE, 0.2)
    if not columns:
        return ()
    columns = {name: np.where(impossible(name, each), np.nan, each) for name, each in columns.items()}
    reverses, reversing = reversing_of_any_car(time, columns, RATE)
    if not (columns["vehicle_speed"] < 0.0).any():
        columns["yaw_rate"] = np.where(reverses, np.nan, columns["yaw_rate"])
    columns = {name: _smooth(column, RATE) for name, column in columns.items()}
    if magnitudes := _magnitudes(columns):
        return magnitudes
    if backwards := _backwards(columns["vehicle_speed"]):
        return (backwards,)
    moving = {**columns, **_in_motion(columns["vehicle_speed"], columns["yaw_rate"])}
    found = [_contradiction(keys, moving, place) for place, keys in GROUPS.items()]
    if reversing.mirrored and not found[0]:
        found[0] = f"{MIRRORED}; {TURN_FORWARD}"
    return tuple(filter(None, found))


def _magnitudes(columns: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    """A sentence on each signal of the turn that is never negative where another goes to both sides as it grows."""
    turns = {name: columns[name] for name in TURNS if np.isfinite(columns[name]).any()}
    sides = {name: float(np.nanmean(values < -0.1 * np.nanstd(values))) for name, values in turns.items()}
    both = [name for name in turns if BOTH_SIDES < sides[name] < 1.0 - BOTH_SIDES]
    found = []
    for name, values in turns.items():
        alike = (compared(values, np.abs(turns[other]), SECONDS * RATE) for other in both)
        if not sides[name] and any(each is not None and each.correlation() > STRONG for each in alike):
            goes = f"{' and '.join(both)} {'goes' if len(both) == 1 else 'go'} to both sides"
            found.append(f"{name}{MAGNITUDE} though {goes}: the column is a magnitude; {SIGN_FROM}")
    return tuple(found)


def _backwards(speed: np.ndarray) -> str:
    speed = speed[np.abs(speed) > SLOWEST]
    if not len(speed) or np.mean(speed < 0.0) <= 0.5:
        return ""
    said = f"vehicle_speed is negative for {100.0 * np.mean(speed < 0.0):.0f} % of the driving time"
    if speed.min() < -ReversingLimits().fastest:
        return f"{said}: its sign is probably wrong; set it in the channel map"
    return (
        f"{said}: the car reversed, or the speed has the wrong sign; if the car drove forward, set the sign of "
        "vehicle_speed in the channel map"
    )


def _in_motion(speed: np.ndarray, yaw_rate: np.ndarray) -> dict[str, np.ndarray]:
    """The speed where the car moves, of 1 m/s where none is recorded; missing without turns."""
    turning = yaw_rate[np.isfinite(yaw_rate)]
    if len(turning) and np.std(turning) < STRAIGHT:
        return {"vehicle_speed": np.full(len(speed), np.nan)}
    known = np.isfinite(speed).any()
    return {"vehicle_speed": np.where(np.abs(speed) > SLOWEST, speed, np.nan) if known else np.ones(len(speed))}


def _contradiction(keys: tuple[str, ...], columns: Mapping[str, np.ndarray], place: str) -> str:
    """A sentence on the signals of these relations that probably have the wrong sign; "" for none."""
    moments = {
        (RELATIONS[key].first[0], RELATIONS[key].second[0]): related(key, columns, RATE, SECONDS) for key in keys
    }
    found = {pair: each.correlation() for pair, each in moments.items() if each is not None}
    strong = {pair: value for pair, value in found.items() if abs(value) >= STRONG}
    names = dict.fromkeys(name for pair in strong for name in pair)
    wrong = odd_ones_out(names, {pair: value > 0.0 for pair, value in strong.items()})
    if not wrong:
        return ""
    figures = ", ".join(f"{a} with {b} {value:.2f}" for (a, b), value in strong.items() if value < 0.0)
    return (
        f"{' or '.join(wrong)} probably has the wrong sign ({place}, correlation {figures}; positive is left for all): "
        "set its sign in the channel map"
    )


@dataclass(frozen=True)
class TurnLimits:
    """Limits beyond which the units of a turn's signals count as contradicting each other."""

    rate: Annotated[float, "Hz"] = 10.0  # of the comparison
    # Least root mean square of speed times yaw rate: three times an offset by bank.
    acceleration: Annotated[float, "m/s**2"] = 0.5
    seconds: Annotated[float, "s"] = 10.0  # shortest driving time
    correlation: Annotated[float, ""] = 0.8  # below it a signal is wrong in another way
    deviation: Annotated[float, ""] = 1.9  # largest factor that bank, roll and gains explain; the square root of km/h


def turn_ratio(turn: Moments | None, limits: TurnLimits) -> float | None:
    """Lateral acceleration over speed times yaw rate, from their moments; None where it is not observable."""
    # A wrong unit makes one of the two too small, so that the larger one must show that there were turns.
    if turn is None or max(turn.deviation(0), turn.deviation(1)) < limits.acceleration:
        return None
    ratio = turn.ratio()
    return None if math.isnan(ratio) or abs(turn.correlation()) < limits.correlation else ratio


def turn_warnings(recording: Recording, limits: TurnLimits | None = None) -> tuple[str, ...]:
    """Warnings where lateral acceleration is far from speed times yaw rate: one of them has a wrong unit."""
    limits = limits or TurnLimits()
    if not all(name in recording and len(recording[name].time) for name in NAMES):
        return ()
    _, columns = _columns(recording, NAMES, limits.rate, 2.0 / limits.rate)
    if len(columns["yaw_rate"]) <= SMOOTHING * limits.rate:
        return ()
    smooth = {name: _smooth(column, limits.rate) for name, column in columns.items()}
    ratio = turn_ratio(related("turn", smooth, limits.rate, limits.seconds), limits)
    if ratio is None or 1.0 / limits.deviation < ratio < limits.deviation:
        return ()
    guess = "at least one of them has a wrong unit"
    for wrong, reason in (
        (1.0 / KMH, "vehicle_speed looks like km/h taken for m/s"),
        (KMH, "vehicle_speed looks converted twice"),
    ):
        if 0.75 < ratio / wrong < 1.33:
            guess = reason
    return (
        f"lateral_acceleration is {ratio:.2g} times vehicle_speed times yaw_rate, where about 1 is right: {guess}; "
        "check their units in the channel map",
    )
