"""Warnings about signals that contradict each other by their signs or by their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.recording import Recording
from tierod.io.quality import impossible
from tierod.methods.detectors.reversing import MIRRORED, TURN_FORWARD, ReversingLimits, reversing_of_any_car

# Length from the beginning that is compared [s]: a sign does not change, and memory must stay bounded
COMPARED = 3600.0


@dataclass(frozen=True)
class SignLimits:
    """Limits beyond which a sign counts as wrong."""

    rate: Annotated[float, "Hz"] = 20.0  # rate of the comparison [Hz]
    # window of the moving average [s]: below 1 Hz a car follows its steering wheel without delay, above there are
    # vibrations
    smoothing: Annotated[float, "s"] = 1.0
    # speed [m/s] below which lateral acceleration and steering hold little information on the turn
    slowest: Annotated[float, "m/s"] = 2.0
    # magnitude of the correlation coefficient from which a pair agrees or contradicts
    correlation: Annotated[float, ""] = 0.6
    seconds: Annotated[float, "s"] = 5.0  # shortest driving time that a pair must have in common [s]
    # standard deviation of the smoothed yaw rate [rad/s] below which there were no turns; five times its noise
    yaw_rate: Annotated[float, "rad/s"] = 0.002


def sign_warnings(recording: Recording, limits: SignLimits | None = None) -> tuple[str, ...]:
    """Warnings about signals whose sign contradicts that of the others, from left and right turns.

    Steering angle, yaw rate and lateral acceleration over speed must agree in sign, and so must driver and motor
    torque, and the steering rate and the change of the angle. With three signals the deviating one is named; with two,
    both. A car that reverses with unsigned speeds mirrors its yaw rate: there it is not compared. Only the first hour
    (COMPARED) is evaluated.
    """
    limits = limits or SignLimits()
    names = (
        "steering_wheel_angle",
        "steering_wheel_rate",
        "yaw_rate",
        "lateral_acceleration",
        "vehicle_speed",
        "driver_torque",
        "motor_torque",
        "wheel_speed_rear_left",
        "wheel_speed_rear_right",
    )
    known = Recording({name: recording[name] for name in names if name in recording and len(recording[name].time)})
    if not known.channels:
        return ()
    aligned = known.slice(stop=known.span[0] + COMPARED).align(names, limits.rate, maximum_age=0.2)
    columns = {
        name: np.where(impossible(name, column), np.nan, column)
        for name, column in zip(names, aligned.values.T, strict=True)
    }
    reverses, reversing = reversing_of_any_car(aligned.time, columns, limits.rate)
    if not (columns["vehicle_speed"] < 0.0).any():
        columns["yaw_rate"] = np.where(reverses, np.nan, columns["yaw_rate"])
    columns = {name: _smooth(column, limits) for name, column in columns.items()}
    torques = {name: columns[name] for name in ("driver_torque", "motor_torque")}
    speed = columns["vehicle_speed"][np.abs(columns["vehicle_speed"]) > limits.slowest]
    if len(speed) and np.mean(speed < 0.0) > 0.5:
        said = f"vehicle_speed is negative for {100.0 * np.mean(speed < 0.0):.0f} % of the driving time"
        if speed.min() < -ReversingLimits().fastest:
            return (f"{said}: its sign is probably wrong; set it in the channel map",)
        return (
            f"{said}: the car reversed, or the speed has the wrong sign; if the car drove forward, set the sign of "
            "vehicle_speed in the channel map",
        )
    angle, rate = columns["steering_wheel_angle"], columns["steering_wheel_rate"]
    rates = {"steering_wheel_rate": rate, "steering_wheel_angle": np.gradient(angle) if len(angle) > 1 else angle}
    turns = _odd_ones(_turns(columns, limits), limits, "in turns")
    if reversing.mirrored and not turns:
        turns = [f"{MIRRORED}; {TURN_FORWARD}"]
    return (
        *turns,
        *_odd_ones(torques, limits, "among the torques"),
        *_odd_ones(rates, limits, "angle against rate"),
    )


def _smooth(values: np.ndarray, limits: SignLimits) -> np.ndarray:
    width = max(int(limits.smoothing * limits.rate), 1)
    return np.convolve(values, np.full(width, 1.0 / width), mode="same" if len(values) < width else "valid")


def _turns(columns: Mapping[str, np.ndarray], limits: SignLimits) -> dict[str, np.ndarray]:
    """Steering angle, yaw rate and lateral acceleration scaled to lateral accelerations, up to a positive factor."""
    speed, yaw = columns["vehicle_speed"], columns["yaw_rate"]
    known = np.isfinite(speed).any()
    speed = speed if known else np.ones(len(yaw))
    moving = np.abs(speed) > (limits.slowest if known else 0.0)
    turning = yaw[np.isfinite(yaw)]
    if len(turning) and np.std(turning) < limits.yaw_rate:
        return {}
    scales = {
        "steering_wheel_angle": speed * speed,
        "yaw_rate": speed,
        "lateral_acceleration": np.ones(len(yaw)),
    }
    return {name: np.where(moving, columns[name] * scale, np.nan) for name, scale in scales.items()}


def _correlation(a: np.ndarray, b: np.ndarray, limits: SignLimits) -> float:
    good = np.isfinite(a) & np.isfinite(b)
    if np.count_nonzero(good) < limits.seconds * limits.rate:
        return 0.0
    a, b = a[good] - np.mean(a[good]), b[good] - np.mean(b[good])
    norm = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / norm if norm > 0.0 else 0.0


def _odd_ones(signals: Mapping[str, np.ndarray], limits: SignLimits, where: str) -> list[str]:
    names = list(signals)
    pairs = {(a, b): _correlation(signals[a], signals[b], limits) for i, a in enumerate(names) for b in names[i + 1 :]}
    strong = {pair: value for pair, value in pairs.items() if abs(value) >= limits.correlation}
    wrong = {pair: value for pair, value in strong.items() if value < 0.0}
    if not wrong:
        return []
    blamed = [name for name in names if all((name in pair) == (pair in wrong) for pair in strong)]
    figures = ", ".join(f"{a} with {b} {value:.2f}" for (a, b), value in wrong.items())
    if len(strong) > 1 and len(blamed) == 1:
        suspect = f"{blamed[0]} probably has the wrong sign"
    else:
        involved = dict.fromkeys(name for pair in wrong for name in pair)
        suspect = " or ".join(involved) + " probably has the wrong sign"
    return [f"{suspect} ({where}, correlation {figures}; positive is left for all): set its sign in the channel map"]


NAMES = ("vehicle_speed", "yaw_rate", "lateral_acceleration")

KMH = 3.6


@dataclass(frozen=True)
class TurnLimits:
    """Limits beyond which the units count as contradicting each other."""

    rate: Annotated[float, "Hz"] = 10.0  # rate of the comparison [Hz]
    # window of the moving average [s]: shorter motion is not that of a steady turn
    smoothing: Annotated[float, "s"] = 1.0
    # smallest root mean square of speed times yaw rate [m/s^2]; three times an offset by bank
    acceleration: Annotated[float, "m/s**2"] = 0.5
    seconds: Annotated[float, "s"] = 10.0  # shortest driving time [s]
    # smallest correlation coefficient of the two; below it a signal is wrong in another way
    correlation: Annotated[float, ""] = 0.8
    # largest factor between the two that bank, roll and gains explain; the square root of that of km/h
    deviation: Annotated[float, ""] = 1.9


def turn_warnings(recording: Recording, limits: TurnLimits | None = None) -> tuple[str, ...]:
    """Warnings where lateral acceleration is far from speed times yaw rate: one of them has a wrong unit."""
    limits = limits or TurnLimits()
    if not all(name in recording and len(recording[name].time) for name in NAMES):
        return ()
    ratio = _ratio(recording, limits)
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


def _ratio(recording: Recording, limits: TurnLimits) -> float | None:
    """Magnitude of lateral acceleration over that of speed times yaw rate; None where it is not observable."""
    first_hour = recording.slice(stop=recording.span[0] + COMPARED)
    aligned = first_hour.align(NAMES, limits.rate, maximum_age=2.0 / limits.rate)
    width = max(round(limits.smoothing * limits.rate), 1)
    if len(aligned.time) <= width:
        return None
    speed, yaw, acceleration = (
        np.convolve(values, np.full(width, 1.0 / width), "valid") for values in aligned.values.T
    )
    expected = speed * yaw
    good = np.isfinite(expected) & np.isfinite(acceleration)
    if np.count_nonzero(good) < limits.seconds * limits.rate:
        return None
    expected, acceleration = (values[good] - np.mean(values[good]) for values in (expected, acceleration))
    power, measured = float(expected @ expected), float(acceleration @ acceleration)
    # A wrong unit makes one of the two too small, so that the larger one must show that there were turns.
    if max(power, measured) < limits.acceleration**2 * len(expected) or min(power, measured) <= 0.0:
        return None
    correlation = abs(float(expected @ acceleration)) / (power * measured) ** 0.5
    return (measured / power) ** 0.5 if correlation >= limits.correlation else None
