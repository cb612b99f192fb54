"""Choice of the sign of every column: left is positive, which the faster outer wheels of an axle show in a turn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.io.proposal.motion import Motion, correlation
from tierod.methods.detectors.reversing import ReversingLimits
from tierod.methods.relations import STRONG

TURNING = ("yaw_rate", "lateral_acceleration", "steering_wheel_angle")

WORDS = {
    "yaw_rate": "yaw rate",
    "lateral_acceleration": "lateral acceleration",
    "steering_wheel_angle": "steering angle",
}

# Signals that are also positive in a left turn, with those that may decide their sign: the first related one does
FOLLOWERS = {
    "driver_torque": TURNING[1:],
    "motor_torque": (*TURNING[1:], "driver_torque"),
    "rack_force": TURNING[1:],
    "tie_rod_force": TURNING[1:],
    "rack_position": ("steering_wheel_angle",),
    "road_wheel_angle": ("steering_wheel_angle", "yaw_rate"),
    "pinion_angle": ("steering_wheel_angle", "yaw_rate"),
}


class Sign(NamedTuple):
    """A sign with its reason, which is empty where a sign has no meaning."""

    sign: int
    reason: str = ""


def chosen_signs(motion: Motion) -> dict[str, Sign]:
    found = {**_of_speeds(motion), **_of_turns(motion)}
    for name, others in FOLLOWERS.items():
        if name in motion.columns:
            found[name] = _following(motion, name, others, found)
    _add_rates(motion, found)
    return found


def _of_speeds(motion: Motion) -> dict[str, Sign]:
    found = {}
    for name, values in motion.columns.items():
        if name == "vehicle_speed" or name.startswith("wheel_speed_"):
            known = values[np.isfinite(values) & (values != 0.0)]
            backwards = float(np.mean(known < 0.0)) if len(known) else 0.0
            slow = len(known) and known.min() > -ReversingLimits().fastest
            check = "; check that the car did not reverse" if slow else ""
            reason = f"turned: {100 * backwards:.0f} % of samples negative{check}"
            found[name] = Sign(-1, reason) if backwards > 0.5 else Sign(1)
    return found


def _lateral(motion: Motion) -> dict[str, np.ndarray]:
    """Every signal of the turn scaled to a lateral acceleration, up to a positive factor."""
    speed = motion.speed()
    pace = np.ones(1) if speed is None else np.abs(speed)
    powers = {"yaw_rate": pace, "lateral_acceleration": np.ones(1), "steering_wheel_angle": pace * pace}
    return {name: motion.columns[name] * powers[name] for name in TURNING if name in motion.columns}


def _of_turns(motion: Motion) -> dict[str, Sign]:
    signals, turn, speed = _lateral(motion), motion.turn(), motion.speed()
    if turn is not None and speed is not None:
        # Times speed, the difference of the wheel speeds is proportional to the lateral acceleration.
        by_wheels = {name: correlation(values, turn * np.abs(speed)) for name, values in signals.items()}
        if any(abs(value) >= STRONG for value in by_wheels.values()):
            return _by_wheels(signals, by_wheels, str(motion.axle))
    return _by_majority(signals)


def _shown(value: float, words: str) -> Sign | None:
    """The sign that a correlation with something shows; None where it is weak."""
    if abs(value) < STRONG:
        return None
    figure = f"correlation with {words} {value:+.2f}"
    return Sign(1, f"kept: {figure}") if value > 0.0 else Sign(-1, f"turned: {figure}")


def _by_wheels(signals: dict[str, np.ndarray], by_wheels: dict[str, float], axle: str) -> dict[str, Sign]:
    shown = {name: _shown(value, f"right less left {axle} wheel speed") for name, value in by_wheels.items()}
    found = {name: sign for name, sign in shown.items() if sign is not None}
    for name in signals:
        if name not in found:
            found[name] = _as(name, signals, {other: found[other].sign for other in signals if other in found})
    return found


def _as(name: str, signals: dict[str, np.ndarray], known: dict[str, int]) -> Sign:
    for other, sign in known.items():
        if found := _shown(sign * correlation(signals[name], signals[other]), WORDS[other]):
            return found
    return Sign(1, "kept: no redundant signal confirms it; check that left is positive")


def _by_majority(signals: dict[str, np.ndarray]) -> dict[str, Sign]:
    """Signs without wheel speeds: two signals that agree are kept, the third follows; the side is not observable."""
    names = list(signals)
    strong = {(a, b): correlation(signals[a], signals[b]) for i, a in enumerate(names) for b in names[i + 1 :]}
    agreeing = max(strong, key=lambda pair: strong[pair], default=None)
    if agreeing is None or strong[agreeing] < STRONG:
        if any(value <= -STRONG for value in strong.values()):
            reason = "kept, but the signals of the turn contradict each other: one of them has the wrong sign; check"
        else:
            reason = "kept: no redundant signal confirms it; check that left is positive"
        return {name: Sign(1, reason) for name in names}
    first, second = agreeing
    figure = f"correlation {strong[agreeing]:+.2f}; check that left is positive"
    found = {
        first: Sign(1, f"kept: agrees with {WORDS[second]}, {figure}"),
        second: Sign(1, f"kept: agrees with {WORDS[first]}, {figure}"),
    }
    return found | {name: _as(name, signals, {first: 1, second: 1}) for name in names if name not in found}


def _following(motion: Motion, name: str, others: tuple[str, ...], found: dict[str, Sign]) -> Sign:
    for other in others:
        if other in motion.columns and other in found:
            value = found[other].sign * correlation(motion.columns[name], motion.columns[other])
            if sign := _shown(value, WORDS.get(other, other.replace("_", " "))):
                return sign
    return Sign(1, "kept: no redundant signal confirms it; check that it is positive towards left")


def _add_rates(motion: Motion, found: dict[str, Sign]) -> None:
    """Signs of rates, from the change of the signal that each is the rate of."""
    speed, columns = motion.speed(), motion.columns
    changes = {"longitudinal_acceleration": speed, "steering_wheel_rate": columns.get("steering_wheel_angle")}
    for name, of in changes.items():
        if name not in columns or of is None:
            continue
        basis = found.get("steering_wheel_angle") if name == "steering_wheel_rate" else None
        value = (basis.sign if basis else 1) * correlation(columns[name], np.gradient(of))
        what = "change of the steering angle" if basis else "change of speed"
        found[name] = _shown(value, what) or Sign(1, "kept: no redundant signal confirms it; check")
