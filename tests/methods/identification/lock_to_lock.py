"""A small lock-to-lock test of its own: spring, damping, inertia and Dahl friction, for the identification's tests."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from tierod.core.recording import Channel, Recording

GEAR, INERTIA, DAMPING = 20.0, 0.10, 0.8


def wheel_angle(seconds_per_turn: float, loops: int, lock: float, rate: float) -> np.ndarray:
    """0 -> -lock -> lock -> 0 with cosine-shaped strokes, a second of rest before and after."""
    corners = [0.0] + [-lock, lock] * loops + [0.0]
    parts = [np.zeros(int(rate))]
    for begin, end in pairwise(corners):
        count = int(rate * seconds_per_turn * abs(end - begin) / (2.0 * math.pi))
        parts.append(begin + (end - begin) * 0.5 * (1.0 - np.cos(np.pi * np.arange(1, count + 1) / count)))
    return np.concatenate([*parts, np.zeros(int(rate))])


def dahl(angle: np.ndarray, pre_sliding: float) -> np.ndarray:
    """Normalised friction in [-1, 1] along an angle; exact between samples."""
    state, out = 0.0, np.zeros_like(angle)
    for index, step in enumerate(np.diff(angle), start=1):
        sign = np.sign(step)
        state = sign + (state - sign) * math.exp(-abs(step) / pre_sliding)
        out[index] = state
    return out


def lock_to_lock(
    friction: float,
    support: str = "hoist",
    *,
    seed: int = 0,
    seconds_per_turn: float = 5.0,
    loops: int = 1,
    lock: float = math.radians(570.0),
    pre_sliding: float = math.radians(1.0),
    torque_offset: float = 0.0,
    rate: float = 100.0,
    noise: float = 1.0,
) -> Recording:
    """Recording of a test with `friction` [N m] inside the steering; on the ground 6 N m of scrub and a spring more."""
    random = np.random.default_rng(seed)
    fine = 1000.0
    angle = wheel_angle(seconds_per_turn, loops, lock, fine)
    time = np.arange(len(angle)) / fine
    speed = np.gradient(angle, time)
    torque = INERTIA * np.gradient(speed, time) + DAMPING * speed + friction * dahl(angle, pre_sliding)
    if support == "ground":
        torque = torque + 6.0 * dahl(angle, math.radians(12.0)) + 1.5 * np.sin(angle / 3.0)
    driver = 0.25 * torque + torque_offset
    motor = 0.75 * torque / GEAR
    every = slice(None, None, round(fine / rate))
    time, count = time[every], len(time[every])

    def channel(name: str, values: np.ndarray, deviation: float, unit: str) -> Channel:
        return Channel(name, time, values[every] + noise * deviation * random.standard_normal(count), unit)

    channels = [
        channel("steering_wheel_angle", angle, 2e-3, "rad"),
        channel("steering_wheel_rate", speed, 1e-2, "rad/s"),
        channel("driver_torque", driver, 0.05, "N*m"),
        channel("motor_torque", motor, 0.005, "N*m"),
        channel("vehicle_speed", np.zeros_like(angle), 0.0, "m/s"),
    ]
    return Recording({one.name: one for one in channels})
